"""The force at single points as a bare function, compiled by CasADi in a tenth of a second."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..bundle import Bundle
from ..bundle.pressurized import muscle_strain
from ..core.errors import InvalidInputError, require
from ..muscle import Muscle


class PointFunction:
    """Force at single points: nothing is checked, and one thread at a time may call it."""

    def __init__(self, name: str, inputs: Sequence[Any], force: Any, slopes: Sequence[Any]):
        """**Arguments:**

        - `name`: name of the function.
        - `inputs`: symbols of pressure or pressures [Pa] and strain [-].
        - `force`: expression of the force [N].
        - `slopes`: expressions of its derivatives by the inputs [N/Pa, N].
        """
        import casadi as ca

        self._arguments = [np.zeros(x.numel()) for x in inputs]
        self._force = _bind(ca.Function(name, inputs, [force]), self._arguments)
        self._all = _bind(
            ca.Function(name, inputs, [force, *map(ca.densify, slopes)]), self._arguments
        )

    def __call__(self, pressure: float | Sequence[float], strain: float) -> float:
        """The force.

        **Arguments:**

        - `pressure`: gauge pressure $P$ [Pa]; of a bundle one for each motor unit.
        - `strain`: contraction $\\varepsilon$ [-].

        **Returns:** force $F$ [N].
        """
        self._arguments[0][:] = pressure
        self._arguments[1][0] = strain
        run, (force,), *_ = self._force
        run()
        return float(force[0])

    def with_slopes(
        self, pressure: float | Sequence[float], strain: float
    ) -> tuple[float, np.ndarray, float]:
        """The force with its derivatives.

        **Arguments:** those of the call.

        **Returns:** force $F$ [N], its derivatives by the pressures [N/Pa] and by strain [N].
        """
        self._arguments[0][:] = pressure
        self._arguments[1][0] = strain
        run, (force, by_pressure, by_strain), *_ = self._all
        run()
        return float(force[0]), by_pressure.copy(), float(by_strain[0])


class MuscleFunction(PointFunction):
    """Force of a muscle at single points, with its derivatives by the muscle's parameters, too."""

    def __init__(self, muscle: Muscle):
        """**Arguments:** `muscle`: one muscle, of numbers."""
        ca, functions = _casadi()
        _check_expression(muscle)
        pressure, strain = ca.SX.sym("pressure"), ca.SX.sym("strain")
        force, by_strain = muscle.law.at(pressure).force(strain)
        force, *slopes = functions.resolve(force, ca.jacobian(force, pressure), by_strain)
        super().__init__("muscle_force", [pressure, strain], force, slopes)
        self._muscle = muscle

    def with_gradient(self, pressure: float, strain: float) -> tuple[float, dict[str, float]]:
        """The force with its derivatives by pressure, strain and each parameter of the muscle. The
        first call compiles them.

        **Arguments:** those of the call.

        **Returns:** force $F$ [N], and its derivatives [N per SI unit] by name: `pressure`,
        `strain`, and the muscle's attributes, such as `length`, `material.c10`, `tuning.c1[0]`.
        """
        self._arguments[0][:] = pressure
        self._arguments[1][0] = strain
        names, (run, (force, gradient), *_) = self._gradient
        run()
        return float(force[0]), dict(zip(names, gradient.tolist(), strict=True))

    @cached_property
    def _gradient(self) -> tuple[list[str], tuple]:
        """Names of the derivatives, and the force and its gradient as `_bind` gives them."""
        ca, functions = _casadi()
        inputs = [ca.SX.sym("pressure"), ca.SX.sym("strain")]
        muscle = functions.with_symbols(self._muscle)
        variables = [*inputs, *functions.constants]
        force, _ = muscle.law.at(inputs[0]).force(inputs[1])
        gradient = ca.densify(ca.gradient(force, ca.vertcat(*variables)))
        function = ca.Function("gradient", inputs, functions.resolve(force, gradient))
        return [symbol.name() for symbol in variables], _bind(function, self._arguments)


def compile_muscle_force(muscle: Muscle) -> MuscleFunction:
    """Compiled force of a muscle [N] and its slopes, at one pressure [Pa] and strain [-] a call."""
    return MuscleFunction(muscle)


def compile_bundle_force(bundle: Bundle) -> PointFunction:
    """Compiled force of a bundle [N] and its slopes, at pressures [Pa] and a strain [-] a call."""
    ca, functions = _casadi()
    pressures, strain = ca.SX.sym("P", len(bundle.motor_units)), ca.SX.sym("eps")
    total, by_pressure, by_strain = ca.SX(0), [], ca.SX(0)
    for i, unit in enumerate(bundle.motor_units):
        _check_expression(unit.muscle)
        ratio = None if bundle.ratios is None else float(bundle.ratios[i])
        unit_strain = strain if ratio is None else muscle_strain(ratio, strain)
        force, slope = unit.muscle.law.at(pressures[i]).force(unit_strain)
        count = float(unit.count)
        total = total + count * force
        by_pressure.append(count * ca.jacobian(force, pressures)[i])
        by_strain = by_strain + count * slope * (1.0 if ratio is None else ratio)
    force, *slopes = functions.resolve(total, ca.vertcat(*by_pressure), by_strain)
    return PointFunction("bundle_force", [pressures, strain], force, slopes)


def _check_expression(muscle: Muscle) -> None:
    """Refuse a `muscle` whose buckling law has no expression of the force."""
    if not muscle.buckling.symbolic:
        remedy = 'take backend="jax", or the law elastica or kim2021'
        raise InvalidInputError(
            "buckling", "can't be compiled by CasADi", muscle.buckling.name, remedy
        )


def _casadi() -> tuple[Any, Any]:
    """CasADi, and `Symbols` registered as the array library of its expressions."""
    require("casadi")
    import casadi as ca

    from .symbols import symbols

    return ca, symbols()


def _bind(function: Any, arguments: list[np.ndarray]) -> tuple[Callable[[], None], list, Any, Any]:
    """Bind a CasADi function to fixed arrays: a call, and its results, which it overwrites."""
    buffer, run = function.buffer()
    results = [np.zeros(function.sparsity_out(i).nnz()) for i in range(function.n_out())]
    for i, x in enumerate(arguments):
        buffer.set_arg(i, x.data)
    for i, x in enumerate(results):
        buffer.set_res(i, x.data)
    return run, results, function, buffer  # the last two must live as long as the call
