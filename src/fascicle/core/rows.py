"""Programs of small arrays, taken apart: each number becomes a row of as many as there are runs.

A batch of loops that work on a few numbers each is slow on a CPU as it is: every array is a few
numbers wide, and what reshapes, stacks and adds up such arrays takes longer than what computes.
Here a program for one run is gone through operation by operation, and written anew for `size` runs
at once. Of a small array each number is a row of its own, so that arranging them costs nothing, and
what computes goes along whole rows. A large array is kept, runs on its last axis; what doesn't
differ from run to run is kept as it is.

XLA joins operations on rows to loops, and works out in each loop anew what several of them need. A
row that takes more than some operations and is asked for again is therefore put down, by a call
that XLA doesn't look into.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.experimental.xla_metadata import set_xla_metadata
from jax.extend.core import ClosedJaxpr, Literal


_MOST = 256  # numbers in an array that is taken apart
_AGAIN = 15  # operations that are worth putting down; of 4 to 50 the fastest by a tenth or more
# what each number goes through by itself
_ALONE = """
abs acos add add_any and asin atan atan2 ceil clamp convert_element_type copy copy_p cos cosh div
eq exp exp2 expm1 floor ge gt integer_pow is_finite le log log1p logistic lt max min mul ne neg not
or pow rem round rsqrt select_n sign sin sinh sqrt square stop_gradient sub tan tanh xor
"""
_EACH = frozenset(_ALONE.split())
# a program within the program
_INSIDE = frozenset(
    ("checkpoint", "closed_call", "custom_jvp_call", "custom_vjp_call", "jit", "pjit", "remat2")
)
_ARRANGED: dict[str, Callable[[list[np.ndarray], dict[str, Any]], list[np.ndarray]]] = {
    "concatenate": lambda x, p: [np.concatenate(x, p["dimension"])],
    "rev": lambda x, p: [np.flip(x[0], p["dimensions"])],
    "slice": lambda x, p: [x[0][_cut(p["start_indices"], p["limit_indices"], p["strides"])]],
    "split": lambda x, p: list(np.split(x[0], np.cumsum(p["sizes"])[:-1], p["axis"])),
    "stack": lambda x, p: [np.stack(x, p["axis"])],
    "transpose": lambda x, p: [x[0].transpose(p["permutation"])],
    "unstack": lambda x, p: [
        x[0][(*(slice(None),) * p["axis"], place, ...)] for place in range(x[0].shape[p["axis"]])
    ],
}
_SHAPED = ("expand_dims", "reshape", "squeeze")
_REDUCED: dict[str, Callable] = {
    "reduce_sum": lax.add,
    "reduce_prod": lax.mul,
    "reduce_max": lax.max,
    "reduce_min": lax.min,
    "reduce_and": lax.bitwise_and,
    "reduce_or": lax.bitwise_or,
}


class _Apart(NamedTuple):
    """A small array: each of its `numbers` is a row, or a number that all runs have in common."""

    numbers: np.ndarray


class _Wide(NamedTuple):
    """An `array` with runs on its last axis."""

    array: Any


def in_rows(
    program: ClosedJaxpr, size: int, mapped: Sequence[bool], given: Sequence[Any]
) -> list[Any]:
    """What a `program` [-] gives for `size` [-] runs: of all that is `given` [-] what is `mapped`
    [-] has runs on its last axis, all results do [-].
    """
    work = _Work(size)
    args = [
        work.smallest(_Wide(x), v.aval) if many else x
        for x, many, v in zip(given, mapped, program.jaxpr.invars, strict=True)
    ]
    found = work.program(program, args)
    return [work.wide(x, v.aval) for x, v in zip(found, program.jaxpr.outvars, strict=True)]


class _Work:
    """A program's way through, for `size` runs."""

    def __init__(self, size: int):
        self.size = size
        # of this turn of a loop, by identity: rows with the operations that each takes, and copies
        self.takes: dict[int, tuple[int, Any]] = {}
        self.copies: dict[int, Any] = {}

    def program(self, program: Any, given: Sequence[Any]) -> list[Any]:
        inner = getattr(program, "jaxpr", program)
        fixed = getattr(program, "consts", ())
        known: dict[Any, Any] = dict(zip(inner.constvars, fixed, strict=True))
        known |= dict(zip(inner.invars, given, strict=True))

        asked = Counter(atom for one in inner.eqns for atom in _atoms(one.invars))
        asked.update(_atoms(inner.outvars))

        def value(atom: Any) -> Any:
            if isinstance(atom, Literal):
                return atom.val
            if asked[atom] > 1 and isinstance(known[atom], _Apart):
                known[atom] = self.put_down(known[atom])
            return known[atom]

        for one in inner.eqns:
            found = self.operation(one, [value(atom) for atom in one.invars])
            known |= dict(zip(one.outvars, found, strict=True))
        return [value(atom) for atom in inner.outvars]

    def operation(self, one: Any, given: list[Any]) -> list[Any]:
        name = one.primitive.name
        if name in _INSIDE:
            return self.program(_inner(one), given)
        if not any(map(_differs, given)):
            return _called(one)(*given)
        if name == "scan":
            return self.scan(one, given)
        avals = [v.aval for v in (*one.invars, *one.outvars)]
        if name == "gather" and not _differs(given[0]):
            found = self.gathered(one, *given)
        elif max(aval.size for aval in avals) > _MOST:
            found = None
        elif name in _EACH:
            found = self.each(one, given)
        else:
            found = self.arranged(one, given)
        return self.as_usual(one, given) if found is None else [_Apart(x) for x in found]

    def each(self, one: Any, given: list[Any]) -> list[np.ndarray]:
        """An operation on each number by itself."""
        shape, found = one.outvars[0].aval.shape, np.empty(one.outvars[0].aval.shape, object)
        apart = [np.broadcast_to(_apart(x), shape) for x in given]
        for place in np.ndindex(shape):
            rows = [self.row(x[place], v.aval) for x, v in zip(apart, one.invars, strict=True)]
            found[place] = row = one.primitive.bind(*rows, **one.params)
            before = {id(x): self.takes.get(id(x), (0, x))[0] for x in rows}
            self.takes[id(row)] = 1 + sum(before.values()), row
        return [found]

    def put_down(self, value: _Apart) -> _Apart:
        """The same, with rows that take long worked out here, once."""
        every = {id(x): x for x in value.numbers.flat}
        long = [i for i in every if self.takes.get(i, (0,))[0] >= _AGAIN and i not in self.copies]
        if long:
            call: Any = jax.jit(list)([every[i] for i in long])
            copies: Any = set_xla_metadata(call, inlineable="false")
            self.copies |= dict(zip(long, copies, strict=True))
        numbers = np.empty(value.numbers.shape, object)
        for place in np.ndindex(numbers.shape):
            row = value.numbers[place]
            numbers[place] = self.copies.get(id(row), row)
        return _Apart(numbers)

    def arranged(self, one: Any, given: list[Any]) -> list[np.ndarray] | None:
        """An operation that arranges numbers, or adds up; none where it is neither."""
        name, p, shape = one.primitive.name, one.params, one.outvars[0].aval.shape
        numbers = [_apart(x) for x in given]
        if name in _ARRANGED:
            return _ARRANGED[name](numbers, p)
        if name in _SHAPED:
            return [numbers[0].reshape(shape)]
        if name == "broadcast_in_dim":
            wide = [1] * len(shape)
            for length, axis in zip(numbers[0].shape, p["broadcast_dimensions"], strict=True):
                wide[axis] = length
            return [np.broadcast_to(numbers[0].reshape(wide), shape)]
        if name in _REDUCED and numbers[0].size:
            return [self.reduced(_REDUCED[name], numbers[0], p["axes"], one)]
        return None

    def reduced(self, add: Callable, numbers: np.ndarray, axes: Any, one: Any) -> np.ndarray:
        shape, aval = one.outvars[0].aval.shape, one.invars[0].aval
        numbers = np.moveaxis(numbers, axes, range(len(axes))).reshape(-1, *shape)
        found = np.empty(shape, object)
        for place in np.ndindex(shape):
            found[place] = reduce(add, [self.row(x[place], aval) for x in numbers])
        return found

    def gathered(self, one: Any, table: Any, places: Any, *_: Any) -> list[np.ndarray] | None:
        """Parts of a table that all runs have in common, one for each place in it."""
        how, shape = one.params["dimension_numbers"], one.outvars[0].aval.shape
        aval, part = one.invars[1].aval, tuple(shape[axis] for axis in how.offset_dims)
        if how.operand_batching_dims or max(aval.size, one.outvars[0].aval.size) > _MOST:
            return None
        of_one = lax.GatherDimensionNumbers(
            tuple(range(len(part))), how.collapsed_slice_dims, how.start_index_map
        )
        kept = {k: one.params[k] for k in ("slice_sizes", "mode", "fill_value")}
        others = [axis for axis in range(len(shape)) if axis not in how.offset_dims]
        found, places = np.empty(shape, object), _apart(places)
        for place in np.ndindex(places.shape[:-1]):
            rows = jnp.stack([self.row(x, aval) for x in places[place]], axis=-1)

            # one after the other into columns: as one gather rows would lie across, and be picked
            # up number by number wherever they are used
            def put(i: Any, columns: Any, rows: Any = rows) -> Any:
                found = lax.gather(table, rows[i], of_one, **kept)
                return lax.dynamic_update_index_in_dim(columns, found, i, len(part))

            none = jnp.zeros((*part, self.size), table.dtype)
            taken = lax.fori_loop(0, self.size, put, none)
            for inside in np.ndindex(part):
                where = dict(zip((*others, *how.offset_dims), (*place, *inside), strict=True))
                found[tuple(where[axis] for axis in range(len(shape)))] = taken[inside]
        return [found]

    def as_usual(self, one: Any, given: list[Any]) -> list[Any]:
        """Any operation, as JAX makes a batch of it."""
        arrays = [
            self.wide(x, v.aval) if _differs(x) else x
            for x, v in zip(given, one.invars, strict=True)
        ]
        axes = [-1 if _differs(x) else None for x in given]
        found = jax.vmap(_called(one), in_axes=axes, out_axes=-1)(*arrays)
        return [self.smallest(_Wide(x), v.aval) for x, v in zip(found, one.outvars, strict=True)]

    def scan(self, one: Any, given: list[Any]) -> list[Any]:
        """A loop, whose numbers are carried as rows."""
        p = one.params
        fixed, carried = p["num_consts"], p["num_carry"]
        differ = _looped(one, [_differs(x) for x in given])
        inside = [v.aval for v in p["jaxpr"].jaxpr.invars]
        results = [v.aval for v in p["jaxpr"].jaxpr.outvars]
        same, begun, rows = given[:fixed], given[fixed : fixed + carried], given[fixed + carried :]

        def step(carry: list[Any], row: list[Any]) -> tuple[list[Any], list[Any]]:
            here = [
                self.smallest(_Wide(x), aval) if _differs(every) else x
                for x, every, aval in zip(row, rows, inside[fixed + carried :], strict=True)
            ]
            state = self.unpacked(carry, differ, inside[fixed : fixed + carried])
            outside = self.takes, self.copies
            self.takes, self.copies = {}, {}  # what a loop is given is put down
            found = self.program(p["jaxpr"], [*same, *state, *here])
            self.takes, self.copies = outside
            every = [
                self.wide(x, aval) if many else x
                for x, many, aval in zip(
                    found[carried:], differ[carried:], results[carried:], strict=True
                )
            ]
            return self.packed(found[:carried], differ, results), every

        arrays = [
            self.wide(x, v.aval) if _differs(x) else x
            for x, v in zip(rows, one.invars[fixed + carried :], strict=True)
        ]
        last, every = lax.scan(
            step, self.packed(begun, differ, inside[fixed:]), arrays,
            length=p["length"], reverse=p["reverse"],
        )  # fmt: skip
        return self.unpacked(last, differ, results) + [
            self.smallest(_Wide(x), v.aval) if many else x
            for x, many, v in zip(every, differ[carried:], one.outvars[carried:], strict=True)
        ]

    def packed(self, values: list[Any], differ: list[bool], avals: list[Any]) -> list[Any]:
        """What a loop carries: lists of rows, and arrays."""
        found = []
        for x, many, aval in zip(values, differ, avals, strict=False):
            if not many:
                found.append(x)
            elif aval.size > _MOST:
                found.append(self.wide(x, aval))
            else:
                found.append([self.row(number, aval) for number in _apart(x).flat])
        return found

    def unpacked(self, values: list[Any], differ: list[bool], avals: list[Any]) -> list[Any]:
        """The same again, so as an operation takes it."""
        found = []
        for x, many, aval in zip(values, differ, avals, strict=False):
            if many and isinstance(x, list):
                numbers = np.empty(len(x), object)
                for place, row in enumerate(x):
                    numbers[place] = row
                found.append(_Apart(numbers.reshape(aval.shape)))
            else:
                found.append(_Wide(x) if many else x)
        return found

    def row(self, number: Any, aval: Any) -> Any:
        """A number as a row, for all runs."""
        if np.shape(number) == (self.size,):
            return number
        return lax.broadcast_in_dim(jnp.asarray(number, aval.dtype), (self.size,), ())

    def wide(self, value: Any, aval: Any) -> Any:
        """A value with runs on its last axis."""
        if isinstance(value, _Wide):
            return value.array
        if not isinstance(value, _Apart):
            array = jnp.asarray(value, aval.dtype)
            return jnp.broadcast_to(array[..., None], (*array.shape, self.size))
        rows = [self.row(x, aval) for x in value.numbers.flat]
        if not rows:
            return jnp.zeros((*aval.shape, self.size), aval.dtype)
        return jnp.stack(rows).reshape(*aval.shape, self.size)

    def smallest(self, value: _Wide, aval: Any) -> _Wide | _Apart:
        """The same, taken apart where it is small."""
        if aval.size > _MOST:
            return value
        numbers = np.empty(aval.shape, object)
        for place in np.ndindex(aval.shape):
            numbers[place] = value.array[place]
        return _Apart(numbers)


def _atoms(atoms: Sequence[Any]) -> list[Any]:
    """Those that aren't literal, each once."""
    return list(dict.fromkeys(x for x in atoms if not isinstance(x, Literal)))


def _differs(value: Any) -> bool:
    """Whether a value is another in each run."""
    return isinstance(value, _Apart | _Wide)


def _apart(value: Any) -> np.ndarray:
    """Numbers of a small array, as objects."""
    if isinstance(value, _Apart):
        return value.numbers
    numbers = np.empty(np.shape(value), object)
    for place in np.ndindex(numbers.shape):
        numbers[place] = value[place] if place else value
    return numbers


def _cut(begins: Any, ends: Any, steps: Any) -> tuple[slice, ...]:
    steps = steps or (1,) * len(begins)
    return tuple(slice(*each) for each in zip(begins, ends, steps, strict=True))


def _called(one: Any) -> Callable[..., list[Any]]:
    """An operation as a function."""

    def function(*given: Any) -> list[Any]:
        found = one.primitive.bind(*given, **one.primitive.get_bind_params(one.params))
        return found if one.primitive.multiple_results else [found]

    return function


def _inner(one: Any) -> Any:
    """The program within an operation."""
    return one.params["jaxpr" if "jaxpr" in one.params else "call_jaxpr"]


def _differing(program: Any, given: list[bool]) -> list[bool]:
    """Which results of a program differ from run to run, where of what it is given these do."""
    inner = getattr(program, "jaxpr", program)
    known = dict.fromkeys(inner.constvars, False) | dict(zip(inner.invars, given, strict=True))

    def value(atom: Any) -> bool:
        return False if isinstance(atom, Literal) else known[atom]

    for one in inner.eqns:
        some = [value(atom) for atom in one.invars]
        if one.primitive.name == "scan":
            found = _looped(one, some)
        elif one.primitive.name in _INSIDE:
            found = _differing(_inner(one), some)
        else:
            found = [any(some)] * len(one.outvars)
        known |= dict(zip(one.outvars, found, strict=True))
    return [value(atom) for atom in inner.outvars]


def _looped(one: Any, given: list[bool]) -> list[bool]:
    """The same of a loop, which hands on what it carries."""
    fixed, carried = one.params["num_consts"], one.params["num_carry"]
    while True:
        found = _differing(one.params["jaxpr"], given)
        here = given[fixed : fixed + carried]
        next_ = [x or y for x, y in zip(here, found[:carried], strict=True)]
        if next_ == here:
            return next_ + found[carried:]
        given = given[:fixed] + next_ + given[fixed + carried :]
