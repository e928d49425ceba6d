"""Catalogs of products in files: from what a data sheet says to muscles that can be judged.

A product has a radius, and lengths: those it is stocked in, or a range that it is cut from to
order. What it doesn't say, wall and braid angle among it, is taken from the drawing whose material
and laws it has. One product of one length becomes one drawing.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from ..core.errors import InvalidInputError
from ..core.validation import check_choice, check_interval
from ..design.catalog import Product
from ..muscle import Muscle
from .faults import from_validation
from .places import Place
from .prices import Price
from .reading import parsed, text_of
from .shipped import abouts, names, text
from .task_schema import CatalogFileSection, ProductSection


_KIND = "catalogs"
_MOST = 10_000  # drawings


class Offer(NamedTuple):
    """Muscles by name, the `products` that they are, the `currency` of their prices, "" if none
    has one, and `notes` on what was left out.
    """

    drawings: dict[str, Muscle]
    products: dict[str, Product]
    currency: str
    notes: tuple[str, ...]


def catalogs() -> dict[str, str]:
    """The catalogs that are shipped: a line about each, by name [-]."""
    return abouts(_KIND)


def sections_of(
    given: str | Sequence[ProductSection], place: Place, folder: Path
) -> tuple[Sequence[ProductSection], Place]:
    """A catalog's products, wherever they stand.

    **Arguments:**

    - `given`: a shipped catalog's name, a file's, or the products themselves [-].
    - `place`: where that stands [-].
    - `folder`: beside which files stand [-].

    **Returns:** the products, and the place of their list [-].

    **Raises:** `ValueError`, in one line; `OSError` where a file can't be read.
    """
    if not isinstance(given, str):
        return given, place
    path = folder / given
    known = names(_KIND)
    if given in known:
        content, source = text(_KIND, given), given
    else:
        if not path.exists():
            with place.naming():
                check_choice(given, known, "catalog")
        content, source = text_of(path), str(path)
    data = parsed(content, source)
    try:
        file = CatalogFileSection.model_validate(data)
    except ValidationError as error:
        raise ValueError(from_validation(error, source, data, CatalogFileSection)) from None
    return file.product, Place(source, data, ("product",), "catalog")


def offer(
    sections: Sequence[ProductSection],
    place: Place,
    lengths: Sequence[float],
    drawing: Mapping[str | None, tuple[str, Muscle]],
) -> Offer:
    """What can be bought.

    **Arguments:**

    - `sections`: products as they are written [-].
    - `place`: where their list stands [-].
    - `lengths`: that are looked at of what is cut to order [m]; left empty, the drawing's own.
    - `drawing`: muscles with their names, by the name that products give, `None` for those that
      give none [-].

    **Returns:** the offer [-].

    **Raises:** `ValueError`, in one line, for a product that can't be, and where none is left.
    """
    if not sections:
        raise place.refuse((), "holds no product.")
    drawings: dict[str, Muscle] = {}
    products: dict[str, Product] = {}
    currencies: dict[str, Any] = {}
    notes: list[str] = []
    taken: dict[tuple[str, str], list[str]] = {}  # what isn't the product's own
    for i, section in enumerate(sections):
        at = place.inner(i, kind="catalog")
        called, own = drawing[section.muscle]
        wanted = section.length or tuple(lengths) or (float(own.length),)
        low, high = section.least_length or 0.0, section.most_length or float("inf")
        if low > high:
            raise at.refuse(("least_length",), "must not be more than most_length.")
        kept = [length for length in wanted if low <= length <= high]
        if len(kept) < len(wanted):
            rest = ", ".join(f"{1e3 * x:g}" for x in wanted if x not in kept)
            end = "" if high == float("inf") else f" to {1e3 * high:g}"
            notes.append(f"{section.name} isn't made {rest} mm long, but {1e3 * low:g}{end} mm.")
        for price in (section.price, section.price_per_length):
            if price is not None:
                currencies.setdefault(price.currency, at)
        for length in kept:
            name = f"{section.name}, {1e3 * length:.6g} mm"
            if name in drawings:
                raise at.refuse(("name",), "is there twice with this length.")
            with at.naming():
                drawings[name] = _muscle(section, own, length)
                products[name] = _product(section, length)
        taken.setdefault((called, _left_out(section)), []).append(section.name)
        if len(drawings) > _MOST:
            raise place.refuse((), f"holds more than {_MOST} products and lengths.")
    if len(currencies) > 1:
        at = list(currencies.values())[1]
        raise at.refuse((), f"prices in {' and '.join(currencies)}: give all in one currency.")
    if not drawings:
        raise place.refuse((), f"none of its products can be had: {' '.join(notes)}")
    for (called, what), sold in taken.items():
        notes.append(f"of {', '.join(sold)} {what} are taken from {called}.")
    return Offer(drawings, products, next(iter(currencies), ""), tuple(notes))


def _left_out(section: ProductSection) -> str:
    """What a product doesn't say of itself."""
    words = [
        word
        for word, value in (
            ("wall", section.wall_thickness),
            ("braid angle", section.braid_angle),
        )
        if value is None
    ]
    return ", ".join([*words, "rubber and laws"])


def _muscle(section: ProductSection, own: Muscle, length: float) -> Muscle:
    """The drawing in a product's sizes, checked as any muscle is."""
    ratio = float(own.wall_thickness) / float(own.outer_radius)
    wall = section.wall_thickness
    given = [
        key
        for key in ("outer_radius", "outer_diameter", "inner_diameter")
        if getattr(section, key) is not None
    ]
    if len(given) != 1:
        got = " and ".join(given) or "none"
        raise InvalidInputError(
            "outer_radius",
            ", outer_diameter or inner_diameter tells how wide it is",
            None,
            f"give one of them, got {got}",
        )
    if section.inner_diameter is not None:
        inner = 0.5 * section.inner_diameter
        radius = inner / (1 - ratio) if wall is None else inner + wall
    else:
        radius = section.outer_radius or 0.5 * (section.outer_diameter or 0.0)
    return own.replace(
        length=length, outer_radius=radius,
        wall_thickness=ratio * radius if wall is None else wall,
        braid_angle=float(own.braid_angle) if section.braid_angle is None else section.braid_angle,
    )  # fmt: skip


def _product(section: ProductSection, length: float) -> Product:
    for key, most, unit in (("largest_pressure", 1e9, "Pa"), ("largest_strain", 1.0, "-"),
                            ("mass", 1e6, "kg"), ("mass_per_length", 1e6, "kg/m")):  # fmt: skip
        if getattr(section, key) is not None:
            check_interval(getattr(section, key), 0.0, most, key, unit, closed=(False, True))
    return Product(
        section.name, _sum(section.price, section.price_per_length, length),
        _sum(section.mass, section.mass_per_length, length), section.largest_pressure,
        section.largest_strain, section.source or "",
    )  # fmt: skip


def _sum(fixed: Price | float | None, each: Price | float | None, length: float) -> float | None:
    """What is fixed and what grows with the length [any unit], where either is known."""
    if fixed is None and each is None:
        return None
    one, more = (
        0.0 if x is None else x.amount if isinstance(x, Price) else x for x in (fixed, each)
    )
    return one + more * length
