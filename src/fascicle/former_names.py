"""Former public names: what each is now, and the version that drops all of them.

Packages, modules and classes take their aliases from these tables; nothing else lists one. A former
name warns (`DeprecationWarning`) with the present one.
"""

from collections.abc import Mapping


REMOVAL = "0.3.0"  # version without the names below: they warn for one minor version before it

# names of a package by their former ones
NAMES: Mapping[str, Mapping[str, str]] = {
    "fascicle": {"Refused": "InvalidInputError"},
    "fascicle.bundle.recruitment": {
        "Recruited": "RecruitmentResult", "Space": "Workspace", "space": "workspace",
    },
    "fascicle.calibrate": {"Choice": "Selection", "find": "select_model"},
    "fascicle.control": {
        "Choice": "PolicyChoice", "Reach": "Reachability", "Sines": "FrequencyResponse",
        "Worth": "ControlMetrics", "choose": "select_policy", "done": "controlled_output",
        "front": "pareto_front", "gain": "added_force",
        "reachable": "reachability", "sines": "frequency_response", "worth": "control_metrics",
    },
    "fascicle.design": {
        "Found": "SearchResult", "refined": "refine_sizes", "summary_of": "summarize",
    },
    "fascicle.dynamics": {
        "Pace": "StepSizeEstimate", "Seen": "PlantOutputs", "pace": "estimate_substeps",
        "rest": "equilibrium_state",
    },
    "fascicle.export": {"on_table": "tabulate_controller", "tabulated": "tabulate"},
    "fascicle.fluid": {"Balance": "StateResidual", "checked_commands": "validate_commands"},
    "fascicle.laws": {"Column": "BucklingColumn"},
}  # fmt: skip

# modules in fascicle by their former names in a package
MODULES: Mapping[str, Mapping[str, str]] = {
    "fascicle": {
        "describe": "files", "describe.atomic": "io.atomic",
        "describe.calibrated": "files.calibration_files", "describe.results": "results.labelled",
    },
    "fascicle.bundle": {"efficiency": "bundle.energetics"},
    "fascicle.calibrate": {
        "comparing": "calibrate.comparison", "finding": "calibrate.model_selection",
        "profiling": "calibrate.intervals",
    },
    "fascicle.design": {
        "checkpoint": "design.genetic", "cycle_run": "design.cycle", "examples": "design.task",
        "judging": "design.evaluation", "packing": "design.designs",
        "pareto": "design.exhaustive_search", "reach": "design.objectives",
        "searching": "design.exhaustive_search", "store": "design.sweep", "study": "design.sweep",
    },
    "fascicle.dynamics": {"hysteresis": "muscle.hysteresis"},
    "fascicle.files": {"calibrated": "files.calibration_files"},
    "fascicle.plot": {"style": "plot.theme"},
    "fascicle.records": {
        "asking": "records.columns", "csv_table": "records.tables",
        "averaging": "records.hysteresis", "fabrication": "records.dynamometer",
        "loops": "records.hysteresis", "pairs": "records.dynamometer",
        "splitting": "records.segmentation", "writing": "records.published",
    },
    "fascicle.reports": {"fitted": "calibrate.plot_data"},
}  # fmt: skip

# attributes and methods of a class by their former names
ATTRIBUTES: Mapping[str, Mapping[str, str]] = {
    "AbstractBolen": {"largest_force": "blocked_force"},
    "AbstractChamber": {
        "balance": "state_residual", "guess": "static_pressure", "heat": "heat_flow",
        "start": "state_at", "stored": "stored_energy",
    },
    "AbstractEnds": {"stretch": "strain_ratio"},
    "AbstractPostCollapse": {"halves": "bending_force"},
    "AbstractSpool": {"commands": "command_count", "states": "state_count"},
    "AbstractSupply": {
        "spent": "drive_energies", "start": "initial_state", "stored": "stored_energy",
        "switched": "update_switch",
    },
    "Balance": {
        "closes_within": "tolerance", "into": "inputs", "left": "residual",
        "share": "relative_residual", "went": "outputs",
    },
    "Crossing": {"found": "exists", "needed": "deadline", "time": "fill_time"},
    "Designs": {"alike": "uniform"},
    "ElasticBraid": {"stretch": "fiber_strain"},
    "Event": {"moments": "samples", "words": "message"},
    "FrequencyResponse": {
        "drawn": "supply_flow", "reached": "reachable_share", "top": "highest_pressure",
        "trusted": "is_valid",
    },
    "Fluid": {"known": "inside"},
    "OrderlyValve": {"middle": "closing_command"},
    "PressureBand": {"after": "update", "start": "initial_state"},
    "Reachability": {"can": "is_reachable", "inside": "in_stroke", "short": "shortfall"},
    "PressurizedMuscle": {"collapse": "collapse_strain", "hinge": "hinge_moment"},
    "Remedy": {"contracts": "free_strain"},
    "Scenario": {"controlled": "control", "taking": "with_policy"},
    "Trajectory": {"account": "ledger", "seen": "outputs"},
    "UnitSurface": {"at": "lookup_at", "inside": "validate_point"},
}  # fmt: skip
