# Names of bodies that differ between languages, and of some others; a body without a message has its catalog name.

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
