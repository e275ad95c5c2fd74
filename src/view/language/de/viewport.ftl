# Shown over the image: messages, hints, menu, warnings.

sky-of = Der Himmel: { $body }
drawing = wird gezeichnet …
hint-drag = Ziehen: drehen
hint-scroll = Mausrad: vergrößern
hint-search = Taste /: suchen
menu-fly = Hinfliegen
menu-fly-hint = Zur beleuchteten Seite fliegen (Doppelklick, g)
menu-look-at = Von hier aus hinsehen
menu-look-at-hint = Die Kamera darauf richten
menu-information = Informationen dazu
menu-effects = Seine Effekte
menu-shader = Sein Shader
menu-measure = Ab hier messen
menu-measure-hint = Den Winkel zu einem anderen Ort messen: dort Strg+Klick, oder dies dort wählen (Strg+Klick)
menu-copy-link = Link zu dieser Ansicht kopieren
menu-copy-link-hint = Ein Link, der sie wiederherstellt (Strg+C)
link-copied = Link kopiert
copied = Kopiert
menu-save-image = Bild speichern
menu-save-image-hint = Wie unter Teilen eingestellt (Strg+S)
warning-title = Diese Ansicht ließ sich nicht öffnen
warning-default = Stattdessen wird die übliche Ansicht gezeigt.
warning-close = Schließen
warning-close-hint = Die Meldung schließen (Eingabe, Esc)
# Errors of the system.
system-not-found = keine solche Datei, kein solcher Ordner
system-denied = keine Berechtigung
system-no-folder = ein Teil des Pfads ist kein Ordner
system-folder = das ist ein Ordner
system-full = der Datenträger ist voll
system-read-only = der Datenträger ist schreibgeschützt
notice = Meldung des Programms: { $detail }
