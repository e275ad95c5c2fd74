# The Sample panel: all bodies as seen from the Earth's centre.

tab-sample = Sample
tab-sample-about = All bodies as seen from the Earth's centre
sample-body = body
