# The Sample panel: the moons of the target's planet.

tab-sample = Sample
tab-sample-about = The moons of the target's planet as the camera sees them
sample-moon = moon
sample-none = No moons in the catalog
sample-fly-hint = Fly to { $name }
