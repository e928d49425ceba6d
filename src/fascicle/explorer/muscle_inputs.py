"""What a muscle is: its sizes, material and laws, each refused at its own field."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import panel as pn

from ..core.errors import InvalidInputError
from ..core.module import replace_checked
from ..muscle.law import AbstractLaw
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from ..units import DIMENSIONS
from .state import Session, View
from .theme import Look
from .widgets import Field, Message, choice, heading


SIZES = {
    "length": ("Length at rest", "length"),
    "outer_radius": ("Bladder's radius", "length"),
    "wall_thickness": ("Wall thickness", "length"),
    "braid_angle": ("Braid angle", "angle"),
}
_OWN = "its own"
_TITLES = {"post_collapse": "After collapse"}  # where it isn't the kind's name


class MuscleInputs:
    """Fields of a muscle; a change makes another muscle, or says why there is none."""

    def __init__(self, session: Session, look: Look):
        """**Arguments:** `session` [-]; `look`: the page's [-]."""
        self._session, self._silent = session, False
        self.message = Message("muscle")
        self._fields = {
            name: Field(look, label, name, dimension, self._sized(name))
            for name, (label, dimension) in SIZES.items()
        }
        self._material = choice(look, "Material", [*MATERIALS, _OWN])
        self._material.param.watch(self._chose_material, "value")
        self._laws = {
            kind: LawInputs(
                look, _TITLES.get(kind, kind.capitalize()), known, self._becomes(kind),
                self.message.say,
            )
            for kind, known in LAWS.items()
        }  # fmt: skip
        self._title = heading("")
        self.panel = pn.Column(
            self._title,
            *_pairs([field.panel for field in self._fields.values()]),
            self._material,
            *(law.panel for law in self._laws.values()),
            self.message.pane,
            sizing_mode="stretch_width",
            margin=0,
        )

    def show(self, view: View) -> None:
        """Show the muscle of a `view` [-]."""
        self._silent = True
        muscle = view.muscle
        for name, field in self._fields.items():
            length = SIZES[name][1] == "length"
            field.show(float(getattr(muscle, name)), view.shown["length"] if length else "deg")
        known = [name for name, one in MATERIALS.items() if one == muscle.material]
        self._material.value = known[0] if known else _OWN
        for kind, law in self._laws.items():
            law.show(getattr(muscle, kind), view.shown)
        self.message.say("")
        self._silent = False

    def _sized(self, name: str) -> Callable[[float], None]:
        def take(value: float) -> None:
            try:
                self._become(**{name: value})
            except ValueError as error:
                # a rule between two sizes names one of them; the other's field is left alone
                named = error.argument if isinstance(error, InvalidInputError) else name
                other = self._fields.get(named) if named != name else None
                if other is not None:
                    other.refuse(error)
                raise

        return take

    def _chose_material(self, event: Any) -> None:
        if self._silent or event.new == _OWN:
            return
        try:
            self._become(material=event.new)
        except ValueError as error:
            self.message.say(str(error))

    def _becomes(self, kind: str) -> Callable[[Any], None]:
        return lambda law: self._become(**{kind: law})

    def _become(self, **parts: Any) -> None:
        view = self._session.view
        name = view.name if view.name.endswith(", changed") else f"{view.name}, changed"
        after = replace(view, muscle=view.muscle.replace(**parts), name=name)
        _ = after.bundle  # refused here, where it was typed, if it can't be a bundle any more
        self._session.become(after)


def _pairs(parts: list[Any]) -> list[Any]:
    """Rows of two `parts` [-] each."""
    several = (parts[i : i + 2] for i in range(0, len(parts), 2))
    return [pn.Row(*two, margin=0, sizing_mode="stretch_width") for two in several]


class LawInputs:
    """A kind of law; a change makes another law, which `takes` is given, or a refusal."""

    def __init__(
        self,
        look: Look,
        title: str,
        laws: Mapping[str, type[AbstractLaw]],
        takes: Callable[[Any], None],
        refused: Callable[[str], None],
    ):
        """**Arguments:**

        - `look`: the page's [-].
        - `title`: of the kind [-].
        - `laws`: of that kind, by name [-].
        - `takes`: the law that was chosen, by name, or with other numbers [-].
        - `refused`: is told why a choice can't be [-].
        """
        self._look, self._takes, self._refused = look, takes, refused
        self._law: Any = None
        self._silent = False
        self.fields: dict[str, Field] = {}
        self.choices: dict[str, Any] = {}
        self.select = choice(look, title, {name.replace("_", " "): name for name in laws})
        self.select.param.watch(lambda event: self._chose(event.new), "value")
        self._own = pn.Column(margin=(0, 0, 4, 12), sizing_mode="stretch_width")
        self.panel = pn.Column(self.select, self._own, margin=0, sizing_mode="stretch_width")

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` [-], its quantities in those `units` [-] that are shown."""
        self._silent = True
        if type(law) is not type(self._law):
            self._renew(law)
        self._law = law
        self.select.value = law.name
        for one in law.constants():
            unit = units.get(one.dimension, DIMENSIONS[one.dimension].shown)
            self.fields[one.name].show(float(getattr(law, one.name)), unit)
        for name, widget in self.choices.items():
            widget.value = getattr(law, name)
        self._silent = False

    def _renew(self, law: Any) -> None:
        self.fields = {
            one.name: Field(
                self._look, _title(one.name), one.name, one.dimension, self._set(one.name)
            )
            for one in law.constants()
        }
        self.choices = {
            one.name: choice(
                self._look, _title(one.name), {o.replace("_", " "): o for o in one.options}
            )
            for one in law.switches()
        }
        for name, widget in self.choices.items():
            widget.param.watch(lambda event, name=name: self._switched(name, event.new), "value")
        shown = [field.panel for field in self.fields.values()]
        self._own.objects = [*shown, *self.choices.values()]

    def _set(self, name: str) -> Callable[[float], None]:
        return lambda value: self._takes(replace_checked(self._law, {name: value}))

    def _switched(self, name: str, option: str) -> None:
        self._chose(replace_checked(self._law, {name: option}))

    def _chose(self, law: Any) -> None:
        if self._silent:
            return
        try:
            self._takes(law)
        except ValueError as error:
            self._refused(str(error))


def _title(name: str) -> str:
    return name.replace("_", " ").capitalize()
