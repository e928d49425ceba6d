"""The commented task file that `fascicle init --task` writes, an example to run as it is."""

from ...bundle.schemes import listed


TASK_TEMPLATE = """\
# A task file of fascicle: `fascicle design FILE` finds the bundle. Quantities carry units.
format = 1

[task]
example = "pick_and_place_arm"   # or "sit_to_stand_knee", "walking_ankle"; their figures are
                                 # made up. Or your own:
# name = "gripper"
# force = ["60 N", "150 N", "280 N"]
# strain = [0.06, 0.10, 0.13]    # contraction; or in mm: stroke = ["7 mm", "12 mm", "15 mm"]
# weight = [6, 3, 1]             # how much each counts in a mean: all must be reached;
                                 # or time = ["0 s", "0.5 s", "1.2 s"]
supply_pressure = "413.7 kPa"
scheme = "orderly"               # or {schemes}
fluid = "air"                    # or "liquid"

[design]
muscle = "kim2021_slenderness_10"  # whose material and laws; a file, or a list of several
muscles = [2, 3, 4, 5, 6]        # how many, up to 100; of many, limit the valves
splits = "all"                   # or "partitions", or some: ["1+4", "1+1+3"]
radius_rule = "cross_section"    # radius is that of one muscle with the section of all; or
                                 # "each" muscle's, or "packing", a circle's diameter that they fill
radius = ["11 mm", "14 mm"]
length = ["110 mm", "127 mm", "150 mm"]
braid_angle = ["28 deg", "33 deg"]
wall_ratio = [0.2, 0.25]         # wall thickness over radius
# unit_factors = [1, 1.5]        # units may be unlike: each unit's radius takes any of these
# density = "1100 kg/m^3"        # of the bladder, for its mass
# catalog = "festo_dmsp"         # products instead of sizes: a catalog that is shipped, a file, or
                                 # [[design.catalog]] tables with name, outer_radius, price, …

[objectives]                     # what makes the front; see the docs for all of them
mean_efficiency = "max"
envelope = "min"                 # diameter of the bundle with its buckled units
valves = "min"
reversal_depth = "min"

[limits]                         # every load case must be reached, unless you let some go:
# not_reached = { at_most = "10 %" }   # of the points, and of their weight
margin = "20 %"                  # of force to spare, below which you are warned: computed forces
                                 # can be off by tens of percent; relative_margin = { at_least =
                                 # "20 %" } takes no design that has less
envelope = { at_most = "90 mm" }
valves = { at_most = 5 }

# What things cost; what isn't given isn't guessed.
# [prices]
# valve = "95 EUR"
# muscle = "20 EUR"
# air = "0.025 EUR/m^3"          # normal m³; or energy = "0.30 EUR/kWh"

# How muscles come out, for the designs of the front; left out, nothing of it.
# [scatter]
# length = "1 %"                 # standard deviations
# braid_angle = "1 deg"
# draws = 200
# calibrated = true              # and constants as sure as the muscle file's calibration is
""".replace("{schemes}", listed('"', 1))
