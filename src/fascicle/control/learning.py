r"""Correction of a controller's muscles, learned from the force of its runs.

A muscle that differs from its model has the force $F + c(P, \varepsilon)$. With lever arms $a_i$
and $n_i$ muscles of each unit, a sample of a run tells about the sum of their corrections

$$r = F_{measured} - \sum_i a_i n_i F_i(P_i, \varepsilon_i)
    = \sum_i a_i n_i\, c_i(P_i, \varepsilon_i) + \text{noise}. \tag{K9}$$

It can't tell units apart whose pressures change together, as they do in a hand-over. What can be
expected of muscles does: the corrections are a Gaussian process, whose covariance is that of the
errors of `draws`, bundles drawn around the model, and of what these don't explain,

$$\mathrm{cov}\left[c, c'\right] = \frac{1}{N} \sum_{draws} \Delta F\, \Delta F'
  + \delta_{ii'}\, s^2 x^2 x'^2 \exp\left[-\frac{(x - x')^2}{2 l_x^2}
  - \frac{(\varepsilon - \varepsilon')^2}{2 l_\varepsilon^2}\right],
  \qquad x = \sqrt{P/P_s}, \tag{K10}$$

on a small grid, linear between its nodes. The mean after a run is the next run's correction. That
run begins with a share $\lambda$ of it, and with the rest of the covariance,

$$c \sim \mathcal{N}\left[\lambda\, c_{before},\; (1 - \lambda)\, \mathrm{cov}\right]: \tag{K11}$$

equal runs lead to what one of them teaches, instead of fitting their noise more closely each time.

**Assumes** force and pressures that are measured together, and muscles without hysteresis.
**Source:** Gaussian process on a linear basis: Rasmussen and Williams (2006), Gaussian Processes
for Machine Learning, section 2.1; the covariance and its use derived here.
"""

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..bundle.bundle import Bundle
from ..core.array_namespace import array_namespace, maximum, minimum, sqrt, where
from ..core.errors import InvalidInputError
from ..core.module import unique_indices
from ..core.types import Numbers, Values, Whole
from ..core.validation import check_finite
from ..dynamics import Plant
from ..dynamics.muscles import MuscleTables, MuscleWrapper
from ..io.atomic import check_overwrite, check_writable, write_text
from ..io.input_file import read_bytes
from ..muscle.surface import Surface
from .branches import Branches
from .uncertainty import draw_bundles
from .units import ControlledUnits


_CELLS = 48  # of pressure, even in √P: of 7 kPa at a dip at 72 kPa, which 11 kPa would miss
_COLUMNS = 17  # nodes of strain over the table's: of 2 % of strain
_REST = 3e-3  # of a muscle's largest force at zero strain, s: a tenth of what draws make
_ROOT = 0.05  # l_x, two nodes: as narrow as a dip's bend
_STRAIN = 0.04  # l_ε: two nodes
_FORMAT = "correction 1"  # of a file
_MEMORY = 0.5  # λ: share of earlier runs' correction that a run begins with
_LIMIT = 2**26  # bytes of a file: a hundred units
_SAMPLES = 5000  # of a run, thinned evenly: 5 s at 1 kHz, and a basis of some 100 MB
_NOISE = 2e-3  # of the same force, of a sample: what the grid can't follow


class Correction(NamedTuple):
    """Correction of muscles: `forces` [N] of one muscle of each unit, by `pressures` [Pa] and
    `strains` [-].
    """

    pressures: Numbers
    strains: Numbers
    forces: Numbers

    def save(self, path: str | os.PathLike[str], overwrite: bool = False) -> None:
        """Write the correction to a JSON file, as `load` reads it.

        **Arguments:**

        - `path`: of the file.
        - `overwrite`: true to replace a file that is there.

        **Raises:** `FileExistsError` for a file that is there, `OSError` for one that can't be
        written.
        """
        check_writable(path)
        check_overwrite(path, overwrite, "`overwrite=True`")
        table = {name: np.asarray(row).tolist() for name, row in self._asdict().items()}
        write_text(path, json.dumps({"fascicle": _FORMAT, **table}) + "\n")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Correction":
        """Read a correction from a file of `save`; `path`: of the file.

        **Raises:** `InvalidInputError` for a file that isn't one, `OSError` for one that can't be
        read.
        """
        text, remedy = read_bytes(Path(path), _LIMIT, "correction"), "take one that `save` wrote"
        try:
            data = json.loads(text)
            rows = [np.array(data[name], float) for name in cls._fields]
        except (ValueError, TypeError, KeyError) as error:
            rule = "is no correction of muscles"
            raise InvalidInputError("path", rule, None, remedy, shown=str(path)) from error
        correction = cls(*rows)
        shapes = correction.pressures.shape + correction.strains.shape
        is_complete = correction.forces.ndim == 3 and correction.forces.shape[1:] == shapes
        if data.get("fascicle") != _FORMAT or not is_complete or not np.all(np.isfinite(rows[2])):
            rule = "is no correction of muscles with finite forces"
            raise InvalidInputError("path", rule, None, remedy, shown=str(path))
        return correction


class CorrectedMuscles(MuscleWrapper):
    """Muscles whose forces are corrected: `forces` are added, a `Correction` by `pressures` and
    `grid_strains` [SI]. Volumes stay those of the model: a force at one strain says little about
    them.
    """

    muscles: MuscleTables
    pressures: Numbers
    grid_strains: Numbers
    forces: Numbers

    @property
    def indices(self) -> Whole:
        """Index of each unit's muscle: none is shared, as corrections differ."""
        return np.arange(self.forces.shape[0])

    @property
    def columns(self) -> int:
        """Number of the tables' cells along strain."""
        return self.muscles.columns

    def at(self, pressure: Numbers, strain: Numbers) -> Surface:
        """Energy, force, volume and slopes (`Surface`) of one muscle of each unit at its `pressure`
        [Pa] and `strain` [-], with corrected forces.
        """
        surface = self.muscles.at(pressure, strain)
        xp = array_namespace(pressure, strain)
        forces, nodes, eps = map(xp.asarray, (self.forces, self.pressures, self.grid_strains))
        top, cells, columns = nodes[-1], len(nodes) - 1, len(eps) - 1
        P = minimum(maximum(pressure, 0.0), top)
        # nodes are even in √P; a root has no slope at zero
        i = xp.floor(sqrt(where(P > 0, P / top, 1.0)) * where(P > 0, 1.0, 0.0) * cells)
        i = minimum(i, cells - 1.0).astype(int)
        x = (strain - eps[0]) / (eps[-1] - eps[0]) * columns
        x = minimum(maximum(x, 0.0), float(columns))
        j = minimum(xp.floor(x), columns - 1.0)
        w, j, unit = x - j, j.astype(int), self.indices
        low, high = (
            (1 - w) * forces[unit, i + side, j] + w * forces[unit, i + side, j + 1]
            for side in (0, 1)
        )
        slope = (high - low) / (nodes[i + 1] - nodes[i])
        inside = (pressure > 0) & (pressure < top)
        return surface._replace(
            force=surface.force + low + slope * (P - nodes[i]),
            force_by_pressure=surface.force_by_pressure + where(inside, slope, 0.0),
        )


class Learner(NamedTuple):
    """Learner of the correction of a plant's muscle forces from its runs; `Learner.of(plant)`.

    `plant`: the controller's model. `grid`: the correction that has learned nothing.
    `covariance`: of all its nodes, (K10) [N²].
    """

    plant: Plant
    grid: Correction
    covariance: Numbers

    @classmethod
    def of(cls, plant: Plant, draws: Sequence[Sequence[Bundle]] | None = None) -> "Learner":
        """Prepare a learner: the covariance of the model errors of a plant's muscles.

        **Arguments:**

        - `plant`: the controller's model.
        - `draws`: of each of its bundles, others that it could be; left out, `draw_bundles`.
        """
        top = float(plant.supply_pressure)
        roots = np.linspace(0.0, 1.0, _CELLS + 1)
        low, high = (np.asarray(x, float) for x in plant.muscles.strains)
        strains = np.linspace(low.min(), high.max(), _COLUMNS)
        zeros = np.zeros((plant.units, len(roots), len(strains)))
        grid = Correction(top * roots**2, strains, zeros)
        draws = [draw_bundles(bundle) for bundle in plant.bundles] if draws is None else draws
        first, parts = 0, []
        for bundle, drawn in zip(plant.bundles, draws, strict=True):
            model = _muscle_forces(bundle, grid)
            rows = np.stack([_muscle_forces(bundle, grid) - model for bundle in drawn])
            n, last = rows[0].size, first + rows[0].size
            rows = rows.reshape(len(rows), n)
            parts.append((slice(first, last), rows.T @ rows / len(rows)))
            first = last
        covariance = _residual_covariance(_blocked_forces(plant), roots, strains)
        for block, expected in parts:
            covariance[block, block] += expected
        return cls(plant, grid, covariance)

    def learn(
        self, force: Values, pressures: Values, strains: Values, before: Correction | None = None
    ) -> Correction:
        """Improve a correction by the forces that were measured in a run.

        **Arguments:**

        - `force`: measured, of all muscles on the load, at each sample [N or N·m].
        - `pressures`: of each unit at each sample [Pa].
        - `strains`: of each unit's muscles at each sample [-].
        - `before`: the correction that was learned before, or none.

        **Returns:** the correction for the next run.

        **Raises:** `InvalidInputError` for rows of unequal length, and for a correction of another
        plant.
        """
        plant, grid = self.plant, self.grid
        F = np.atleast_1d(check_finite(force, "force", "N"))
        P = np.asarray(check_finite(pressures, "pressures", "Pa"))
        eps = np.asarray(check_finite(strains, "strains", "-"))
        for name, rows in (("pressures", P), ("strains", eps)):
            if rows.shape != (len(F), plant.units):
                rule = f"must have {plant.units} columns and a row for each force"
                raise InvalidInputError(name, rule, None, shown=str(rows.shape))
        thin = slice(None, None, -(-len(F) // _SAMPLES))
        F, P, eps = F[thin], P[thin], eps[thin]
        before = grid if before is None else before
        has_nodes = all(map(np.array_equal, before[:2], grid[:2]))
        if not has_nodes or np.shape(before.forces) != grid.forces.shape:
            rule = "must have this learner's units, pressures and strains"
            raise InvalidInputError("before", rule, None, "begin without one", shown="")
        arms = np.asarray(plant.lengths * plant.gains) * plant.counts
        P = np.clip(P, 0.0, grid.pressures[-1])
        by_pressure = _interpolation_weights(P, grid.pressures)
        by_strain = _interpolation_weights(eps, grid.strains)
        basis = np.einsum("u,tup,tus->tups", arms, by_pressure, by_strain).reshape(len(F), -1)
        residual = F - np.asarray(plant.muscles.at(P, eps).force) @ arms
        mean = _MEMORY * before.forces.ravel()
        residual = residual - basis @ mean
        indices = np.flatnonzero(np.any(basis != 0, axis=0))
        basis, K = basis[:, indices], (1 - _MEMORY) * self.covariance[:, indices]
        noise = (_NOISE * np.max(np.abs(arms * _blocked_forces(plant)) / plant.counts)) ** 2
        A = basis.T @ basis @ K[indices] + noise * np.eye(len(indices))
        change = K @ np.linalg.solve(A, basis.T @ residual)
        return grid._replace(forces=(mean + change).reshape(grid.forces.shape))


def correct_units(
    plant: Plant, units: Sequence[ControlledUnits], correction: Correction
) -> tuple[ControlledUnits, ...]:
    """The `units` of each bundle of a `plant`, with a `correction` in their tables.

    **Raises:** `InvalidInputError` for a correction of another number of units.
    """
    if len(correction.forces) != plant.units:
        rule = f"must be one of {plant.units} motor units"
        raise InvalidInputError("correction", rule, len(correction.forces))
    corrected = []
    for side, bundle in enumerate(units):
        forces = correction.forces[plant.unit_indices(side)]
        muscles = CorrectedMuscles(bundle.branches.muscles, *correction._replace(forces=forces))
        top = float(bundle.branches.top)
        corrected.append(replace(bundle, branches=Branches.tabulated(muscles, top)))
    return tuple(corrected)


def _blocked_forces(plant: Plant) -> Numbers:
    """Blocked force of one muscle of each unit at the supply's pressure [N]."""
    zero = np.zeros(plant.units)
    return np.asarray(plant.muscles.at(zero + plant.supply_pressure, zero).force)


def _muscle_forces(bundle: Bundle, grid: Correction) -> Numbers:
    """Force of one muscle of each unit at the nodes of a `grid` [N]; zero off its domain."""
    unique, indices = unique_indices([unit.muscle for unit in bundle.motor_units])
    forces = []
    for i in unique:
        law = bundle.motor_units[i].muscle.law.at(grid.pressures[:, None])
        with np.errstate(all="ignore"):  # of branches that aren't selected
            force, _ = law.force(grid.strains)
        forces.append(np.where(np.isfinite(force), force, 0.0))
    return np.stack(forces)[list(indices)]  # a tuple would index axes instead of muscles


def _residual_covariance(full: Numbers, roots: Numbers, strains: Numbers) -> Numbers:
    """Covariance [N²] of the model errors that draws don't explain, (K10), between the nodes of
    square `roots` of the relative pressure [-] and `strains` [-]; `full`: blocked forces [N].
    """
    by_root, by_strain = (
        np.exp(-(np.subtract.outer(x, x) ** 2) / (2 * length**2))
        for x, length in ((roots, _ROOT), (strains, _STRAIN))
    )
    by_pressure = np.outer(roots**2, roots**2) * by_root
    return np.kron(np.diag((_REST * full) ** 2), np.kron(by_pressure, by_strain))


def _interpolation_weights(values: Numbers, nodes: Numbers) -> Numbers:
    """Weights of `nodes`, on a last axis, for linear interpolation at `values`."""
    x = np.interp(values, nodes, np.arange(len(nodes)))
    return np.maximum(1.0 - np.abs(x[..., None] - np.arange(len(nodes))), 0.0)
