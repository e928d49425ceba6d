r"""Recruitment algebra: what a bundle gives in each state, from what its units give.

With masks $f_{ku}$ of the units at full supply pressure in state $k$, $t_{ku}$ of those throttled
and $o_{ku}$ of those vented, anything that units add up to, force or work or fluid, is

$$X_k(u) = \sum_u f_{ku} X_u(1) + o_{ku} X_u(0) + t_{ku} X_u(u) \tag{B10}$$

at the throttled level $u = p/P_s$. A state's region lies between the least and the largest of it
over the level that its throttled units share; if each has its own, between the sums of least
and of largest. Bundles, their efficiency and designs use it.
"""

from collections.abc import Callable, Sequence
from itertools import chain, product
from math import prod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.types import Bool, Int, Numbers, Values
from ..core.validation import (
    HIGHEST_PRESSURE,
    RANGES,
    check_interval,
    check_plausible,
    check_scalar,
)
from .schemes import AbstractScheme, scheme_of


if TYPE_CHECKING:
    from .bundle import Bundle


MAX_SETS = 4095  # of pressurized units: all of twelve unlike units
Masks = Bool[np.ndarray, "state unit"]
StateMask = Bool[np.ndarray, " state"]


class States(NamedTuple):
    """Masks of the units at `full` supply pressure and of those `throttled` in each state.

    `independent`: each throttled unit has a pressure of its own; `scheme`: name of the scheme.
    """

    full: Masks
    throttled: Masks
    independent: bool
    scheme: str

    @property
    def size(self) -> int:
        """Number of states."""
        return len(self.full)

    @property
    def pressurized(self) -> Masks:
        """Mask of the units that take fluid in each state."""
        return self.full | self.throttled

    @property
    def vented(self) -> Masks:
        """Mask of the units at no pressure in each state."""
        return ~self.pressurized

    @property
    def throttled_unit(self) -> Int[np.ndarray, " state"]:
        """First unit that each state throttles, counted from 0."""
        return self.throttled.argmax(axis=1)

    @property
    def separable(self) -> bool:
        """True if no two units share a pressure: then a state's edges are sums of its units'."""
        return self.independent or bool(np.all(self.throttled.sum(axis=1) == 1))

    @property
    def order(self) -> Int[np.ndarray, " unit"]:
        """Indices of the units in the order of their recruitment."""
        pressurized = self.pressurized
        first = np.where(pressurized.any(axis=0), pressurized.argmax(axis=0), self.size)
        return np.argsort(first, kind="stable")

    @property
    def nested(self) -> bool:
        """True if each state holds the units of the one before: then the first is the cheapest."""
        return bool(np.all(self.pressurized[1:] >= self.pressurized[:-1]))

    @property
    def gapless(self) -> bool:
        """True if no gap is between the forces of states: each begins (its throttled units vented)
        without any pressure, or as an earlier one begins or ends (its throttled units full).
        """
        return not self.full[self.independent | self.owns_endpoints[0]].any()

    @property
    def owns_endpoints(self) -> tuple[StateMask, StateMask]:
        """Masks of the states whose beginning, and whose end, is no earlier state's."""
        pairs = np.stack([self.full, self.pressurized], axis=1)
        endpoints = [row.tobytes() for pair in pairs for row in pair]
        new = np.array([row not in endpoints[:i] for i, row in enumerate(endpoints)])
        return new[::2], new[1::2]

    def pressures(
        self, state: int | Int[np.ndarray, "*any"], throttled: Numbers, supply: Numbers
    ) -> Numbers:
        """Pressures of all units [Pa], on a new last axis: `supply` [Pa] where full, `throttled`
        [Pa] where a state throttles them, else zero; `state`: index of the state, from 0.
        """
        xp = array_namespace(state, throttled, supply)
        full, mask = (xp.asarray(x)[state] for x in (self.full, self.throttled))
        return where(full, supply, where(mask, xp.asarray(throttled)[..., None], 0.0))

    def sums(self, throttled: Numbers, vented: Numbers, full: Numbers) -> Numbers:
        """Sum over units in every state, (B10) [SI], states on a new first axis; independent units
        of a state have one level. Of each unit, units last: `throttled` [SI] at every level, levels
        first, `vented` [SI] at no pressure, `full` [SI] at supply pressure.
        """
        total = self._throttled_sum(throttled) + self._fixed_sum(vented, full)
        return array_namespace(total).moveaxis(total, -1, 0)

    def edges(self, throttled: Numbers, vented: Numbers, full: Numbers) -> tuple[Numbers, Numbers]:
        """Least and largest sum [SI] of every state over levels, from the arguments of `sums`."""
        xp, fixed = array_namespace(throttled, vented, full), self._fixed_sum(vented, full)

        def edge(pick: Callable[..., Numbers]) -> Numbers:
            if self.independent:
                return xp.moveaxis(fixed + self._throttled_sum(pick(throttled, axis=0)), -1, 0)
            return xp.moveaxis(fixed + pick(self._throttled_sum(throttled), axis=0), -1, 0)

        return edge(xp.min), edge(xp.max)

    def sets(
        self, kinds: Sequence[int] | None = None, max_sets: int = MAX_SETS
    ) -> tuple["States", Int[np.ndarray, " set"]]:
        """Sets of pressurized units, which differ in their fluid energy (29): those of the states,
        and if units are independent every choice of them, few units before many; and the index of
        the state that each set belongs to. `kinds`: index of each unit's kind; of equal units the
        first are pressurized. `ValueError` for more than `max_sets` sets.
        """
        if not self.independent:
            return self, np.arange(self.size)
        kinds = range(self.full.shape[1]) if kinds is None else kinds
        rows: list[tuple[int, list[int], int]] = []  # in the order of the sets
        for state, (full, throttled) in enumerate(zip(self.full, self.throttled, strict=True)):
            by_kind: dict[int, list[int]] = {}
            for unit in np.flatnonzero(throttled).tolist():
                by_kind.setdefault(kinds[unit], []).append(unit)
            choices = [[units[:n] for n in range(len(units) + 1)] for units in by_kind.values()]
            count = prod(map(len, choices)) - 1
            if count > max_sets:
                rule = f"{self.scheme!r} has {count} sets of motor units, more than {max_sets}"
                raise InvalidInputError("scheme", rule, count, "take fewer units", shown="")
            for choice in product(*choices):
                members = sorted(chain.from_iterable(choice))
                if members:
                    rows.append((int(full.sum()) + len(members), members, state))
        _, members, owners = zip(*sorted(rows), strict=True)
        throttled = np.array([np.isin(np.arange(self.full.shape[1]), row) for row in members])
        return self._replace(full=self.full[list(owners)], throttled=throttled), np.array(owners)

    def _fixed_sum(self, vented: Numbers, full: Numbers) -> Numbers:
        """Sum over the units that each state doesn't throttle, states last."""
        return full @ self.full.T.astype(float) + vented @ self.vented.T.astype(float)

    def _throttled_sum(self, values: Numbers) -> Numbers:
        """Sum over each state's throttled units, states last."""
        if np.all(self.throttled.sum(axis=1) == 1):
            return values[..., self.throttled_unit]
        return values @ self.throttled.T.astype(float)


def overlap_edges(
    first: tuple[Numbers, Numbers], second: tuple[Numbers, Numbers]
) -> tuple[Numbers, Numbers]:
    """Least and largest force [N] that two states both reach, zero or more, from the edges of each
    [N]; the least is the larger if they don't overlap.
    """
    return maximum(maximum(first[0], second[0]), 0.0), minimum(first[1], second[1])


def states_of(scheme: AbstractScheme, units: int) -> States:
    """States of a `scheme` for so many motor `units`; `ValueError` for impossible ones."""
    masks: list[list[np.ndarray]] = []
    for k, state in enumerate(scheme.states(units), start=1):
        full, throttled = map(list, state)
        members, rule = full + throttled, ""
        if not throttled or len(set(members)) < len(members):
            rule = "throttle a unit, and name each unit once,"
        elif any(not 0 <= unit < units for unit in members):
            rule = f"name units of 0 to {units - 1}"
        if rule:
            rule = f"{scheme.name!r} must {rule} in state {k}"
            description = f"full {full} and throttled {throttled}"
            raise InvalidInputError("scheme", rule, state, shown=description)
        masks.append([np.isin(np.arange(units), index) for index in (full, throttled)])
    if not masks:
        rule = f"{scheme.name!r} has no state for {units} motor units"
        raise InvalidInputError("scheme", rule, scheme, shown="")
    full_mask, throttled_mask = map(np.array, zip(*masks, strict=True))
    return States(full_mask, throttled_mask, scheme.independent, scheme.name)


def is_prefix_consistent(scheme: AbstractScheme, units: int) -> bool:
    """True if fewer units have the first states of so many `units`: then a bundle of fewer counts
    as one whose last units have no muscles.
    """
    states = states_of(scheme, units)
    for fewer in range(1, units):
        try:
            shorter = states_of(scheme, fewer)
        except ValueError:  # a scheme for so many units alone
            return False
        first = [mask[: shorter.size, :fewer] for mask in states[:2]]
        if not np.array_equal(first, shorter[:2]):
            return False
    return True


def resolve_scheme(bundle: "Bundle", scheme: AbstractScheme | str | None) -> AbstractScheme:
    """A `scheme`, by default the bundle's own; `ValueError` also for a batch of bundles."""
    check_single(bundle)
    return bundle.scheme if scheme is None else scheme_of(scheme)


def resolve_supply_pressure(
    bundle: "Bundle", supply_pressure: Values = None, name: str = "supply_pressure"
) -> float:
    """A supply pressure [Pa], by default the bundle's own; errors have the
    argument's `name`; also a batch is one.
    """
    check_single(bundle)
    supply = bundle.supply_pressure if supply_pressure is None else supply_pressure
    if supply is None:
        remedy = "the bundle has none of its own"
        raise InvalidInputError(name, "must be given, such as 400 kPa", None, remedy)
    P = check_interval(supply, 0.0, HIGHEST_PRESSURE, name, "Pa", "(gauge)", (False, True))
    return check_scalar(check_plausible(P, name, RANGES["supply_pressure"]), name)


def check_single(bundle: "Bundle") -> None:
    """Refuse anything but a `Bundle`, and batches of bundles."""
    if not hasattr(bundle, "motor_units"):
        rule, remedy = "must be a Bundle", "build one: fs.Bundle([fs.MotorUnit(muscle)])"
        raise InvalidInputError("bundle", rule, bundle, remedy, shown=type(bundle).__name__)
    if not bundle._batch:
        return
    rule, remedy = "must be a single one here", "build a bundle for each of its muscles"
    description = f"a batch of shape {bundle._batch}"
    raise InvalidInputError("bundle", rule, bundle, remedy, shown=description)
