"""Recruitment schemes: the motor units that each recruitment state pressurizes.

A scheme is a list of states. In each, some units are held at full supply pressure, some are
throttled between zero and supply pressure, and the others are vented. Bundles, designs, the command
line and the explorer use that list. Arguments named `scheme` take a name or an object; files and
the command line know the names in `SCHEMES`. This module imports no NumPy, since the command line's
help shows the names.

**Source:** Kim, Mazzoleni and Bryant (2021), section 4, Fig. 8, for orderly and batch.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple, TypeVar

from ..core.errors import InvalidInputError


class State(NamedTuple):
    """A recruitment state: units at `full` supply pressure and `throttled` ones, counted from 0."""

    full: Sequence[int]
    throttled: Sequence[int]


class AbstractScheme(ABC):
    """Order in which a bundle's motor units are pressurized; equals its `name` and prints as it.

    `independent`: each throttled unit of a state has a pressure of its own; else they share one.
    """

    name: ClassVar[str]
    independent: ClassVar[bool] = False

    @abstractmethod
    def states(self, units: int) -> Sequence[State]:
        """States of a bundle of so many `units`, in the order of recruitment."""

    @property
    def about(self) -> str:
        """Description of the scheme, the first sentence of its docstring."""
        return " ".join((self.__doc__ or "").split()).split(". ")[0].rstrip(".")

    def __eq__(self, scheme: object) -> bool:
        """True for an equal scheme, and for its name."""
        if isinstance(scheme, str):
            return self.name == scheme
        # by their texts: attributes may be arrays, and this module imports no NumPy
        return type(self) is type(scheme) and repr(self) == repr(scheme)

    def __hash__(self) -> int:
        """Hash of the name, which the scheme equals."""
        return hash(self.name)

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        arguments = ", ".join(f"{key}={value!r}" for key, value in vars(self).items())
        return f"{type(self).__name__}({arguments})"


Scheme = TypeVar("Scheme", bound=AbstractScheme)
SCHEMES: dict[str, AbstractScheme] = {}


def register(scheme: type[Scheme]) -> type[Scheme]:
    """Class decorator: let files, the command line and the explorer know a scheme, made without
    arguments, by its name; `ValueError` for that of another class.
    """
    if scheme.name in SCHEMES and type(SCHEMES[scheme.name]) is not scheme:
        rule, remedy = f"{scheme.name!r} is another scheme's", "choose a name that is free"
        raise InvalidInputError("name", rule, scheme.name, remedy, shown="")
    SCHEMES[scheme.name] = scheme()
    return scheme


@register
class Orderly(AbstractScheme):
    """Unit after unit: earlier units at supply pressure, one throttled, later ones vented."""

    name = "orderly"

    def states(self, units: int) -> Sequence[State]:
        """A state for each of the `units`: it throttled, those before it full."""
        return [State(full=range(k), throttled=(k,)) for k in range(units)]


@register
class Batch(AbstractScheme):
    """More and more units together: pressurized units share one throttled pressure."""

    name = "batch"

    def states(self, units: int) -> Sequence[State]:
        """A state for each of the `units`: it and those before it throttled alike."""
        return [State(full=(), throttled=range(k + 1)) for k in range(units)]


@register
class Free(AbstractScheme):
    """Any unit at any pressure: of all pressures that give a force, those of least fluid energy."""

    name = "free"
    independent = True

    def states(self, units: int) -> Sequence[State]:
        """One state, in which each of the `units` has a pressure of its own."""
        return [State(full=(), throttled=range(units))]


def scheme_of(
    scheme: AbstractScheme | str | type[AbstractScheme], argument: str = "scheme"
) -> AbstractScheme:
    """Scheme by name or as an object; `argument`: name of the argument that an error reports.
    `ValueError` for an unknown name (the nearest is suggested) and for a class.
    """
    if isinstance(scheme, AbstractScheme):
        return scheme
    from ..core.validation import check_choice  # imports NumPy

    if isinstance(scheme, type):
        remedy, text = f"write {scheme.__name__}()", f"the class {scheme.__name__}"
        raise InvalidInputError(argument, "takes a name or an object", scheme, remedy, shown=text)
    return SCHEMES[check_choice(scheme, SCHEMES, argument)]


def serializable_name(scheme: AbstractScheme) -> str:
    """Name that a file has for a `scheme`; `ValueError` for one that isn't registered."""
    if SCHEMES.get(scheme.name) != scheme:
        rule = f"{scheme.name!r} is a Python object that no file can name"
        remedy = f"register its class, or take one of {', '.join(sorted(SCHEMES))}"
        raise InvalidInputError("scheme", rule, scheme, remedy, shown="")
    return scheme.name


def format_names(quote: str = "", start: int = 0) -> str:
    """Names of the schemes from index `start` on as text, such as "orderly, batch or free"."""
    *first, last = (f"{quote}{name}{quote}" for name in list(SCHEMES)[start:])
    return f"{', '.join(first)} or {last}" if first else last
