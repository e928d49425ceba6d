"""The domain of the model: how far pressure, strain and braid angle go, written down once.

**Source:** Kim, Mazzoleni and Bryant (2021), whose muscles are driven with up to 0.42 MPa; muscles
on sale go up to 0.8 MPa.
"""

import math


HIGHEST_PRESSURE = 1e6  # Pa, gauge
LARGEST_STRAIN = 0.6  # no braid contracts by more than 0.423, a bundle's muscles may be pushed on
NEUTRAL_ANGLE = math.atan(math.sqrt(2))  # rad, 54.7356 deg: a braid neither pulls nor pushes
