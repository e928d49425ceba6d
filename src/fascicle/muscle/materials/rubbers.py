"""Named rubbers of the literature.

**Source:** Klute and Hannaford (2000) for latex; Kim, Mazzoleni and Bryant (2021), section 3.4,
for the silicone's modulus [R3].
"""

from collections.abc import Mapping
from types import MappingProxyType

from .mooney_rivlin import LATEX_C01, LATEX_C10, MooneyRivlin


# The library's default: Klute and Hannaford's latex, E = 1.34 MPa.
LATEX = MooneyRivlin(c10=LATEX_C10, c01=LATEX_C01)

# The paper gives its silicone's modulus (1.78 MPa, uniaxial) but not its constants. 0.75
# times latex meets its two statements on free strain and collapse within its figures [R3].
SILICONE_KIM2021 = MooneyRivlin(c10=88.8e3, c01=79.3e3, youngs_modulus=1.78e6)

MATERIALS: Mapping[str, MooneyRivlin] = MappingProxyType(
    {"latex": LATEX, "silicone_kim2021": SILICONE_KIM2021}
)
