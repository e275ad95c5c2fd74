# The Sample panel: all bodies as seen from the Earth's centre.

tab-sample = Sample
tab-sample-about = Alle Körper, vom Erdmittelpunkt gesehen
sample-body = Körper
