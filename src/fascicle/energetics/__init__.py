"""Work, fluid energy and efficiency; an alias of `fascicle.bundle.efficiency`."""

from ..bundle.efficiency import PATHS as PATHS
from ..bundle.efficiency import EfficiencyMap as EfficiencyMap
from ..bundle.efficiency import average_efficiency as average_efficiency
from ..bundle.efficiency import constant_cross_section as constant_cross_section
from ..bundle.efficiency import efficiency_map as efficiency_map
from ..bundle.efficiency import fluid_energy as fluid_energy
from ..bundle.efficiency import unit_volume_change as unit_volume_change
from ..bundle.efficiency import unit_work as unit_work
from ..bundle.efficiency import work as work
