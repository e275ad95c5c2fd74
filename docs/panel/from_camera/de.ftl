# The Sample panel: the moons of the target's planet.

tab-sample = Sample
tab-sample-about = Die Monde des Zielplaneten, wie die Kamera sie sieht
sample-moon = Mond
sample-none = Keine Monde im Katalog
sample-fly-hint = Zu { $name } fliegen
