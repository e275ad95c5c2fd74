# Names of bodies that differ between languages, and those beside them; every other body is called as in the catalog.

body-sun = Sonne
body-mercury = Merkur
body-venus = Venus
body-earth = Erde
body-moon = Mond
body-mars = Mars
body-jupiter = Jupiter
body-saturn = Saturn
body-uranus = Uranus
body-neptune = Neptun
body-pluto = Pluto
body-callisto = Kallisto
body-ganymede = Ganymed
body-nereid = Nereide
body-io = Io
body-europa = Europa
body-titan = Titan
