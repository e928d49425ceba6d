"""Tasks of one load that a test's command solves quickly: of one design, and of some to sweep."""

TASK = """format = 1
[task]
force = "60 N"
strain = 0.1
supply_pressure = "413.7 kPa"
[design]
muscle = "kim2021_slenderness_10"
muscles = [2]
[objectives]
valves = "min"
"""
SWEPT = TASK.replace("[2]", '[6]\nlength = "100 mm:150 mm:10 mm"').replace(
    'valves = "min"', 'mean_efficiency = "max"\n[sweep]\nblock = 16'
)
