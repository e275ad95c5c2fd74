# Well-known moments, what to see now, tours.

now-moon = Der Mond heute Nacht
now-eclipse = Nächste Finsternis
now-saturn = Saturn jetzt
now-shadows = Dreifacher Schatten
now-shader = Shader einer Finsternis
now-moon-about = zu { $percent } % beleuchtet
now-dated = { $day }: { $what }
now-saturn-about = Ringe und ihr Schatten
now-shader-about = Shadercode für den { $day }
now = Was jetzt zu sehen ist
now-also = auch unter Momente
now-close-hint = Schließen; sie stehen auch unter Momente
now-close = Was jetzt zu sehen ist schließen
presets = Ansichten
preset-system = Ganzes Sonnensystem
preset-system-about = Die Planeten und ihre Bahnen, von oben
preset-inner-system = Innere Planeten
preset-inner-system-about = Merkur bis Mars und ihre Bahnen, von oben
preset-phases = Mondphasen
preset-phases-about = Der Mond von der Erde aus, ein Tag je Sekunde
preset-sky = Der Himmel heute Nacht
preset-sky-about = Sterne und Sternbilder von Ihrem Ort aus
moments-filter = Filter
moments-filter-hint = Momente zeigen, deren Name diesen Text enthält
moments-hint =
    { $about }
    { $time }
    Quelle: { $source }
outside-ephemeris = { $name }: außerhalb des Bereichs der Ephemeride
moments-line = { $day } · { $about }
tours = Touren
tours-file-hint = Tourdatei (JSON); `orrery render --help` beschreibt ihre Felder
tours-file = Tourdatei
tours-open = Tour öffnen
tours-open-hint = Die Tour der Datei abspielen
moment-kind-solar-eclipse = Sonnenfinsternis
moment-kind-lunar-eclipse = Mondfinsternis
moment-kind-transit = Transit
moment-kind-shadows = Schatten
moment-kind-rings = Ringe
moment-kind-conjunction = Konjunktion
moment-kind-photograph = Fotografie
tour-stop = { $tour }: { $stop } von { $stops }
tour-previous = Zurück
tour-previous-hint = Zurück zur vorigen Station
tour-play = Tour abspielen
tour-play-hint = Weiter
tour-pause = Tour anhalten
tour-pause-hint = Hier bleiben; die Ansicht lässt sich bewegen
tour-next = Weiter
tour-next-hint = Weiter zur nächsten Station
tour-record = Tour aufzeichnen
tour-record-hint = Die ganze Tour als Animation speichern, mit Datei, Größe und Bildrate aus Teilen
tour-end = Tour beenden
tour-end-hint = Die Tour schließen und die Ansicht behalten (Esc)
