"""Sobol's indices of a design's objectives, over ranges of its sizes and its material."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.module import with_fields
from ..core.validation import check_choice
from .designs import Designs
from .evaluation import MIXED, evaluate
from .objectives import check_objectives
from .scatter import LARGEST_ANGLE, SMALLEST_ANGLE
from .task import Task


_MATERIAL = ("c10", "c01", "youngs_modulus")
VARIED = ("length", "outer_radius", "wall_thickness", "braid_angle", *_MATERIAL)
_INDICES = ("S1", "S1_conf", "ST", "ST_conf")  # SALib's keys


def sensitivities(
    designs: Designs,
    index: int,
    task: Task,
    ranges: Mapping[str, float],
    objectives: tuple[str, ...],
    samples: int = 64,
    seed: int = 0,
) -> dict[str, dict[str, np.ndarray]]:
    """Sobol's sensitivity indices of each objective, of first and total order, by SALib.

    **Arguments:**

    - `designs`: of one drawing.
    - `index`: of one of them.
    - `task`: what is demanded.
    - `ranges`: largest deviation of each of `VARIED`, over its value, either way [-].
    - `objectives`: by name.
    - `samples`: a power of two; this times the number of ranges plus two are computed.
    - `seed`: random seed.

    **Returns:** for each objective `S1` and `ST` and the half-widths of their 95 % intervals,
    `S1_conf` and `ST_conf`, in the order of the ranges; an objective that doesn't change
    has zeros.

    **Raises:** `ValueError` for unknown objectives and quantities; `ModuleNotFoundError`
    without SALib.
    """
    from SALib.analyze import sobol as analyze
    from SALib.sample import sobol as sample

    names, drawing = check_objectives(objectives, task.scheme), designs.single_drawing
    for name in ranges:
        check_choice(name, VARIED, "ranges")
    problem = {
        "num_vars": len(ranges),
        "names": list(ranges),
        "bounds": [[1 - half, 1 + half] for half in ranges.values()],
    }
    # without second orders a sample takes as many again as there are names, and two
    draws = sample.sample(problem, samples, calc_second_order=False, seed=seed)
    design, rows = designs.take(np.array([index])), []
    for draw in draws:
        factors = dict.fromkeys(VARIED, 1.0) | dict(zip(ranges, draw, strict=True))
        material = {
            name: getattr(drawing.material, name) * factors[name]
            for name in _MATERIAL
            if name in ranges
        }
        varied = replace(
            design, kind=np.zeros(1, int),
            drawings={"": with_fields(drawing, material=with_fields(drawing.material, **material))},
            length=design.length * factors["length"],
            radius=design.radius * factors["outer_radius"],
            wall=design.wall * factors["wall_thickness"],
            angle=np.clip(design.angle * factors["braid_angle"], SMALLEST_ANGLE, LARGEST_ANGLE),
        )  # fmt: skip
        rows.append([column[0] for column in evaluate(varied, task, names, MIXED).values()])
    results: dict[str, dict[str, np.ndarray]] = {}
    for name, values in zip(names, np.transpose(rows), strict=True):
        if np.ptp(values) == 0:
            results[name] = dict.fromkeys(_INDICES, np.zeros(len(ranges)))
            continue
        indices: Any = analyze.analyze(problem, values, calc_second_order=False, seed=seed)
        results[name] = {key: np.asarray(indices[key]) for key in _INDICES}
    return results
