# Shown over the image: messages, hints, menu, warnings.

sky-of = The sky: { $body }
drawing = drawing…
hint-drag = Drag to turn
hint-scroll = Scroll to zoom
hint-search = Press / to search
menu-fly = Fly there
menu-fly-hint = Fly to its lit side (double-click, g)
menu-look-at = Look at it from here
menu-look-at-hint = Turn the camera towards it
menu-information = Information about it
menu-effects = Its effects
menu-shader = Its shader
menu-measure = Measure from here
menu-measure-hint = Measure the angle to another place: Ctrl+click it, or choose this there (Ctrl+click)
menu-copy-link = Copy link to this view
menu-copy-link-hint = A link that restores it (Ctrl+C)
link-copied = Link copied
copied = Copied
menu-save-image = Save image
menu-save-image-hint = As the Share panel says (Ctrl+S)
warning-title = This view could not be opened
warning-default = The default view is shown instead.
warning-close = Close
warning-close-hint = Close the message (Enter, Escape)
# Errors of the system.
system-not-found = No such file or directory
system-denied = Permission denied
system-no-folder = Not a directory
system-folder = Is a directory
system-full = No space left on device
system-read-only = Read-only file system
notice = { $detail }
