"""Work, fluid energy and efficiency of muscles and bundles."""

from ..bundle.volumes import unit_volume_change as unit_volume_change
from .efficiency import PATHS as PATHS
from .efficiency import EfficiencyMap as EfficiencyMap
from .efficiency import average_efficiency as average_efficiency
from .efficiency import efficiency_map as efficiency_map
from .family import constant_cross_section as constant_cross_section
from .work import fluid_energy as fluid_energy
from .work import unit_work as unit_work
from .work import work as work
