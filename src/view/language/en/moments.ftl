# Well-known moments, what to see now, tours.

now-moon = The Moon tonight
now-eclipse = Next eclipse
now-saturn = Saturn now
now-shadows = Triple shadow
now-shader = An eclipse's shader
now-moon-about = { $percent } % lit, from the Earth
now-dated = { $what }, { $day }
now-saturn-about = Its rings and their shadow
now-shader-about = The shader code that draws { $day }
now = What to see now
now-also = also under Moments
now-close-hint = Close; the Moments panel has them, too
now-close = Close what to see now
presets = Views
preset-system = Whole solar system
preset-system-about = The planets and their orbits, from above
preset-inner-system = Inner planets
preset-inner-system-about = Mercury to Mars and their orbits, from above
preset-phases = Phases of the Moon
preset-phases-about = The Moon from the Earth, a day each second
preset-sky = The sky tonight
preset-sky-about = Stars and constellations from your place
moments-filter = Filter
moments-filter-hint = Show moments whose name contains this text
moments-hint =
    { $about }
    { $time }
    Source: { $source }
outside-ephemeris = { $name }: outside the range of the ephemeris
moments-line = { $day } · { $about }
tours = Tours
tours-file-hint = Tour file (JSON); `orrery render --help` describes its fields
tours-file = Tour file
tours-open = Open tour
tours-open-hint = Play the tour of the file
moment-kind-solar-eclipse = Solar eclipse
moment-kind-lunar-eclipse = Lunar eclipse
moment-kind-transit = Transit
moment-kind-shadows = Shadows
moment-kind-rings = Rings
moment-kind-conjunction = Conjunction
moment-kind-photograph = Photograph
tour-stop = { $tour }: { $stop } of { $stops }
tour-previous = Previous
tour-previous-hint = Back to the stop before
tour-play = Play tour
tour-play-hint = Go on
tour-pause = Pause tour
tour-pause-hint = Stay here; you can move the view
tour-next = Next
tour-next-hint = On to the next stop
tour-record = Record tour
tour-record-hint = Save the whole tour as an animation, with the file, size and rate of the Share panel
tour-end = End tour
tour-end-hint = Close the tour and keep the view (Escape)
