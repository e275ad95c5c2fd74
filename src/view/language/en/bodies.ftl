# Names of bodies that differ between languages, and of some others; a body without a message has its catalog name.

body-sun = Sun
body-mercury = Mercury
body-venus = Venus
body-earth = Earth
body-moon = Moon
body-mars = Mars
body-jupiter = Jupiter
body-saturn = Saturn
body-uranus = Uranus
body-neptune = Neptune
body-pluto = Pluto
body-callisto = Callisto
body-ganymede = Ganymede
body-nereid = Nereid
body-io = Io
body-europa = Europa
body-titan = Titan
