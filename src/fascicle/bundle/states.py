r"""The recruitment algebra: what a bundle gives in each state, from what its units give.

With masks $f_{ku}$ of the units at full supply pressure in state $k$, $t_{ku}$ of those throttled
and $o_{ku}$ of the others, anything that units add up to, force or work or fluid, is

$$X_k(u) = \sum_u f_{ku} X_u(1) + o_{ku} X_u(0) + t_{ku} X_u(u) \tag{B10}$$

at the throttled level $u = p/P_s$. A state's region lies between the least and the largest of it
over the level that its throttled units share; where each has its own, between the sums of least
and of largest. Bundles, their efficiency and designs all read it here.
"""

from collections.abc import Sequence
from functools import cache
from itertools import product
from math import prod
from typing import Any, NamedTuple

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.errors import InvalidInputError
from ..core.types import Bool, Int, Numbers
from .schemes import AbstractScheme


MOST_SETS = 4095  # of units that are fed: all of twelve unlike units
Masks = Bool[np.ndarray, "state unit"]


class States(NamedTuple):
    """Which units are at `full` supply pressure and which `throttled` in each state [-];
    `independent`: whether the latter have a pressure each. `scheme`: whose they are [-].
    """

    full: Masks
    throttled: Masks
    independent: bool
    scheme: str

    @property
    def size(self) -> int:
        """How many states there are [-]."""
        return self.full.shape[0]

    @property
    def fed(self) -> Masks:
        """Which units take fluid in each state [-]."""
        return self.full | self.throttled

    @property
    def unfed(self) -> Masks:
        """Which units are at no pressure in each state [-]."""
        return ~self.fed

    @property
    def leading(self) -> Int[np.ndarray, " state"]:
        """The first unit that each state throttles [-], counted from 0."""
        return self.throttled.argmax(axis=1)

    @property
    def single(self) -> bool:
        """Whether every state throttles one unit alone [-]."""
        return bool(np.all(self.throttled.sum(axis=1) == 1))

    @property
    def apart(self) -> bool:
        """Whether a state's edges are sums of its units' own [-]: no two share a pressure."""
        return self.single or self.independent

    @property
    def first(self) -> Int[np.ndarray, " unit"]:
        """The first state that feeds each unit [-]; as many as there are where none does."""
        return np.where(self.fed.any(axis=0), self.fed.argmax(axis=0), len(self.full))

    @property
    def order(self) -> Int[np.ndarray, " unit"]:
        """The units in the order of their recruitment [-]."""
        return np.argsort(self.first, kind="stable")

    @property
    def nested(self) -> bool:
        """Whether the units that a state feeds are among those of the next [-]: then the lowest
        state that gives a force takes least fluid.
        """
        fed = self.fed
        return bool(np.all(fed[1:] >= fed[:-1]))

    @property
    def in_turn(self) -> bool:
        """Whether each state begins where the one before it ends [-], at full supply."""
        return self.nested and np.array_equal(self.full[1:], self.fed[:-1])

    @property
    def together(self) -> bool:
        """Whether no unit is held at full supply, and states grow [-]."""
        return self.nested and not self.full.any()

    @property
    def joined(self) -> bool:
        """Whether no gap is between the forces of states [-]: each begins with no unit fed, or as
        an earlier one begins or ends.
        """
        if self.independent:
            return not self.full.any()
        seen = [np.zeros(self.full.shape[1], bool)]
        for full, fed in zip(self.full, self.fed, strict=True):
            if not any(np.array_equal(full, one) for one in seen):
                return False
            seen += [full, fed]
        return True

    @property
    def counted(self) -> tuple[Bool[np.ndarray, " state"], Bool[np.ndarray, " state"]]:
        """Whether each state's beginning and end are counted there [-], not in an earlier one."""
        seen: set[bytes] = set()
        found = []
        for full, fed in zip(self.full, self.fed, strict=True):
            row = []
            for corner in (full, fed):
                row.append(corner.tobytes() not in seen)
                seen.add(corner.tobytes())
            found.append(row)
        begins, ends = np.array(found).T
        return begins, ends

    def pressures(self, state: Any, level: Numbers, supply: Numbers) -> Numbers:
        """Pressures of all units [Pa], on a new last axis.

        **Arguments:**

        - `state`: which [-], counted from 0.
        - `level`: the throttled pressure over the supply's [-].
        - `supply`: $P_s$ [Pa].

        **Returns:** pressures [Pa].
        """
        at_work = array_namespace(state, level, supply)
        full, throttled = (at_work.asarray(x)[state] for x in (self.full, self.throttled))
        P = at_work.asarray(level * supply)[..., None]
        return where(full, supply, where(throttled, P, 0.0))

    def held(self, off: Numbers, full: Numbers) -> Numbers:
        """What the units give that a state doesn't throttle.

        **Arguments:**

        - `off`: of each unit at no pressure, units last [any unit].
        - `full`: of each unit at the supply's [any unit].

        **Returns:** sums [any unit], states last.
        """
        return full @ self.full.T.astype(float) + off @ self.unfed.T.astype(float)

    def sums(self, throttled: Numbers, off: Numbers, full: Numbers) -> Numbers:
        """Sum over units in every state, (B10); units of an independent state have one level here.

        **Arguments:**

        - `throttled`: of each unit at every level, which are first; units last [SI].
        - `off`: of each unit at no pressure [SI].
        - `full`: of each unit at the supply's [SI].

        **Returns:** sums [SI], states on a new first axis.
        """
        every = self._joint(throttled) + self.held(off, full)
        return array_namespace(every).moveaxis(every, -1, 0)

    def edges(self, throttled: Numbers, off: Numbers, full: Numbers) -> tuple[Numbers, Numbers]:
        """Least and largest of every state; arguments as of `sums` [SI], without levels in
        what is returned [SI].
        """
        at_work, held = array_namespace(throttled, off, full), self.held(off, full)
        found = []
        for pick in (at_work.min, at_work.max):
            if self.independent:
                part = self._joint(pick(throttled, axis=0))
            else:
                part = pick(self._joint(throttled), axis=0)
            found.append(at_work.moveaxis(held + part, -1, 0))
        return found[0], found[1]

    def sets(
        self, alike: Sequence[int] | None = None, most: int = MOST_SETS
    ) -> tuple["States", Int[np.ndarray, " set"]]:
        """All that (29) tells apart: the states, and where units are independent every choice of
        those that are fed, few before many.

        **Arguments:**

        - `alike`: which kind each unit is of [-]; of one kind the first are fed.
        - `most`: how many there may be [-].

        **Returns:** a state for each, and which of these states it belongs to [-].

        **Raises:** `ValueError` where there are too many.
        """
        if not self.independent:
            return self, np.arange(len(self.full))
        kinds = range(self.full.shape[1]) if alike is None else alike
        rows: list[tuple[list[int], np.ndarray, np.ndarray, int]] = []
        for k, (full, free) in enumerate(zip(self.full, self.throttled, strict=True)):
            of_kind: dict[int, list[int]] = {}
            for unit in np.flatnonzero(free).tolist():
                of_kind.setdefault(kinds[unit], []).append(unit)
            count = prod(len(units) + 1 for units in of_kind.values())
            if count - 1 > most:
                raise InvalidInputError(
                    "scheme",
                    f"{self.scheme!r} has {count - 1} sets of motor units that may be fed,"
                    f" and {most} at most can be looked at",
                    count - 1,
                    "take fewer units",
                    shown="",
                )
            for numbers in product(*(range(len(units) + 1) for units in of_kind.values())):
                fed = sorted(
                    unit
                    for units, number in zip(of_kind.values(), numbers, strict=True)
                    for unit in units[:number]
                )
                if fed:
                    rows.append((fed, full, np.isin(np.arange(full.size), fed), k))
        rows.sort(key=lambda row: (int(row[1].sum()) + len(row[0]), row[0]))
        _, full, throttled, owner = (
            np.array(one) for one in zip(*((0, *row[1:]) for row in rows), strict=True)
        )
        return self._replace(full=full, throttled=throttled), owner

    def _joint(self, values: Numbers) -> Numbers:
        """Sum over each state's throttled units, states last."""
        if self.single:
            return values[..., self.leading]
        return values @ self.throttled.T.astype(float)


def common(one: tuple[Numbers, Numbers], other: tuple[Numbers, Numbers]) -> tuple[Numbers, Numbers]:
    """Between which forces two states overlap, at zero and above.

    **Arguments:** `one`, `other`: least and largest force of each [N].

    **Returns:** both ends [N]; the first is the larger where they don't overlap.
    """
    return maximum(maximum(one[0], other[0]), 0.0), minimum(one[1], other[1])


@cache
def states_of(scheme: AbstractScheme, units: int) -> States:
    """The states of a scheme.

    **Arguments:**

    - `scheme`: the one [-].
    - `units`: how many motor units there are [-].

    **Returns:** its states [-].

    **Raises:** `ValueError` for a scheme that has none, and for states that can't be.
    """
    found = list(scheme.states(units))
    if not found:
        raise InvalidInputError(
            "scheme", f"{scheme.name!r} has no state for {units} motor units", scheme, shown=""
        )
    masks = np.zeros((2, len(found), units), bool)
    for k, state in enumerate(found):
        full, throttled = (list(part) for part in state)
        every = full + throttled
        if not throttled or len(set(every)) < len(every):
            rule = f"{scheme.name!r} must throttle a unit in state {k + 1}, and name each once"
            raise InvalidInputError(
                "scheme", rule, state, shown=f"full {full} and throttled {throttled}"
            )
        if any(not 0 <= unit < units for unit in every):
            rule = f"{scheme.name!r} must name units of 0 to {units - 1} in state {k + 1}"
            raise InvalidInputError(
                "scheme", rule, state, shown=f"full {full} and throttled {throttled}"
            )
        masks[0, k, full], masks[1, k, throttled] = True, True
    return States(masks[0], masks[1], scheme.independent, scheme.name)


@cache
def extends(scheme: AbstractScheme, units: int) -> bool:
    """Whether a bundle of fewer units has the first states of one of so many `units` [-], for it
    counts as one whose last units have no muscles.
    """
    whole = states_of(scheme, units)
    for fewer in range(1, units):
        try:
            part = states_of(scheme, fewer)
        except ValueError:  # one that is for so many units alone
            return False
        for one, other in ((part.full, whole.full), (part.throttled, whole.throttled)):
            if not np.array_equal(one, other[: part.size, :fewer]):
                return False
    return True
