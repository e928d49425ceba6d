"""Recruitment schemes: which motor units are fed in which state, each declared once, here.

A scheme is a list of states. In each, some units are held at full supply pressure, some are
throttled between none and it, and the rest isn't fed. Forces, work, pressures, the way back from
a force, the judging of designs, the command line's choices and the explorer's all read that list.
Wherever a scheme is asked for, its name or an object will do; files and the command line know the
names in `SCHEMES`.

Nothing is imported here that takes time: the command line's help shows the names.

**Source:** Kim, Mazzoleni and Bryant (2021), section 4, Fig. 8, for orderly and batch.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple, TypeVar

from ..core.errors import InvalidInputError


class State(NamedTuple):
    """A recruitment state: the units at `full` supply pressure and those that are `throttled`
    [-], both counted from 0. The others are at no pressure.
    """

    full: Sequence[int]
    throttled: Sequence[int]


class AbstractScheme(ABC):
    """In which order a bundle's motor units are fed. Compares equal to its `name`, prints as it.

    `independent`: whether every throttled unit of a state has a pressure of its own; else they
    share one.
    """

    name: ClassVar[str]
    independent: ClassVar[bool] = False

    @abstractmethod
    def states(self, units: int) -> Sequence[State]:
        """The states [-] of a bundle of so many `units` [-], in the order of recruitment."""

    @property
    def about(self) -> str:
        """What it is, in a sentence: the first one of its docstring."""
        return " ".join((self.__doc__ or "").split()).split(". ")[0].rstrip(".")

    def __eq__(self, other: object) -> bool:
        """Whether `other` is the same scheme, or its name [-]."""
        if isinstance(other, str):
            return self.name == other
        return type(self) is type(other) and vars(self) == vars(other)

    def __hash__(self) -> int:
        """As its name's, which it equals."""
        return hash(self.name)

    def __str__(self) -> str:
        """Its name."""
        return self.name

    def __repr__(self) -> str:
        """As it is made."""
        given = ", ".join(f"{key}={value!r}" for key, value in vars(self).items())
        return f"{type(self).__name__}({given})"


Kind = TypeVar("Kind", bound=AbstractScheme)
SCHEMES: dict[str, AbstractScheme] = {}


def register(kind: type[Kind]) -> type[Kind]:
    """Let files, the command line and the explorer know a scheme by its name; a class decorator.

    **Arguments:** `kind`: a final class of scheme, which is made without arguments [-].

    **Returns:** the same class [-].

    **Raises:** `ValueError` for a name that another class has.
    """
    known = SCHEMES.get(kind.name)
    if known is not None and type(known) is not kind:
        raise InvalidInputError(
            "name",
            f"{kind.name!r} is another scheme's",
            kind.name,
            "choose one that is free",
            shown="",
        )
    SCHEMES[kind.name] = kind()
    return kind


@register
class Orderly(AbstractScheme):
    """Unit after unit: those before it at supply pressure, one throttled, those after it unfed."""

    name = "orderly"

    def states(self, units: int) -> Sequence[State]:
        """A state [-] for each of the `units` [-]."""
        return [State(full=range(k), throttled=(k,)) for k in range(units)]


@register
class Batch(AbstractScheme):
    """More and more units together: those that are fed share one throttled pressure."""

    name = "batch"

    def states(self, units: int) -> Sequence[State]:
        """A state [-] for each of the `units` [-]."""
        return [State(full=(), throttled=range(k + 1)) for k in range(units)]


@register
class Free(AbstractScheme):
    """Any unit at any pressure: of all that give a force, those that take least fluid energy."""

    name = "free"
    independent = True

    def states(self, units: int) -> Sequence[State]:
        """One state [-], in which each of the `units` [-] has a pressure of its own."""
        return [State(full=(), throttled=range(units))]


def scheme_of(
    scheme: AbstractScheme | str | type[AbstractScheme], what: str = "scheme"
) -> AbstractScheme:
    """A scheme by its name, or the one that is given.

    **Arguments:**

    - `scheme`: one of `SCHEMES` by name, or an object [-]; a class is refused.
    - `what`: the argument that it is given for [-].

    **Returns:** the scheme [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    if isinstance(scheme, AbstractScheme):
        return scheme
    from ..core.validation import (
        check_choice,  # brings JAX, which the command line's help does without
    )

    if isinstance(scheme, type):
        raise InvalidInputError(
            what,
            "takes a name or an object",
            scheme,
            f"write {scheme.__name__}()",
            shown=f"the class {scheme.__name__}",
        )
    return SCHEMES[check_choice(scheme, SCHEMES, what)]


def name_of(scheme: AbstractScheme) -> str:
    """The name by which a file can tell a scheme.

    **Arguments:** `scheme`: the one in use [-].

    **Returns:** its name [-].

    **Raises:** `ValueError` for a scheme by object that no file can name.
    """
    if SCHEMES.get(scheme.name) != scheme:
        raise InvalidInputError(
            "scheme",
            f"{scheme.name!r} is an object of Python's, which files can't tell",
            scheme,
            f"register its class, or take one of {', '.join(sorted(SCHEMES))}",
            shown="",
        )
    return scheme.name


def listed(quote: str = "", but: int = 0) -> str:
    """The names in words, such as "orderly, batch or free".

    **Arguments:**

    - `quote`: put before and after each [-].
    - `but`: so many of the first are left out [-].

    **Returns:** the words [-].
    """
    *others, last = (f"{quote}{name}{quote}" for name in list(SCHEMES)[but:])
    return f"{', '.join(others)} or {last}" if others else last
