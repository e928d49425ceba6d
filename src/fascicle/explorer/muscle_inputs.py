"""Inputs of a muscle: its sizes, material and laws; errors appear at their own fields."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import panel as pn

from ..core.errors import InvalidInputError
from ..core.module import replace_checked
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from .state import CHANGED, Session, View, is_shipped
from .widgets import SIZES, Field, Message, column, dropdown, field_unit, fold


_CUSTOM = "its own"
_TITLES = {"post_collapse": "After collapse"}  # where it isn't the kind's name


class MuscleInputs:
    """Inputs of a muscle; a change makes another muscle, or shows why there is none."""

    def __init__(self, session: Session):
        self._session = session
        self.fields = {
            name: Field(label, name, dimension, partial(self._set_size, name))
            for name, (label, dimension) in SIZES.items()
        }
        options = [*MATERIALS, _CUSTOM]
        self._material = dropdown("Material", options, self._choose_material)
        self.message = Message()
        self.laws = {kind: LawInputs(kind, self) for kind in LAWS}
        sizes = [widget for field in self.fields.values() for widget in field.widgets]
        laws = fold(
            "Advanced: laws and their constants", *(law.panel for law in self.laws.values())
        )
        self.panel = column(column(*sizes, kind="pairs"), self._material, self.message.pane, laws)

    def show(self, view: View) -> None:
        """Show the muscle of a `view`."""
        muscle = view.muscle
        for name, (_, dimension) in SIZES.items():
            unit = field_unit(dimension, view.display_units)
            self.fields[name].show(float(getattr(muscle, name)), unit)
        names = [name for name, material in MATERIALS.items() if material == muscle.material]
        self._material.value = names[0] if names else _CUSTOM
        for kind, law in self.laws.items():
            law.show(getattr(muscle, kind), view.display_units)
        self.message.show("")

    def change(self, **parts: object) -> None:
        """Replace parts of the session's muscle, and rename it; `ValueError` if it can't be."""
        view = self._session.view
        muscle = view.muscle.replace(**parts)
        after = replace(view, muscle=muscle, name=self._name_of(muscle))
        _ = after.bundle  # raises at this field if it can't be a bundle any more
        self._session.show(after)

    def try_change(self, message: Message, **parts: object) -> None:
        """As `change`, with an error in a `message`."""
        with message.errors():
            self.change(**parts)

    def _name_of(self, muscle: Muscle) -> str:
        """Name of a changed `muscle`; again the first one's name if it has returned to that."""
        opened, name = self._session.opened, self._session.view.name.removesuffix(CHANGED)
        if muscle == opened.muscle:
            return opened.name
        return name if is_shipped(name, muscle) else f"{name}{CHANGED}"

    def _set_size(self, name: str, value: float) -> None:
        """Set the size with a `name`; errors are for the field to show."""
        try:
            self.change(**{name: value})
        except InvalidInputError as error:
            # a rule between two sizes names one of them: it is shown at both
            if error.argument != name and error.argument in self.fields:
                self.fields[error.argument].show_error(error)
            raise

    def _choose_material(self, name: str) -> None:
        if name != _CUSTOM and MATERIALS[name] != self._session.view.muscle.material:
            self.try_change(self.message, material=name)


class LawInputs:
    """Inputs of one kind of law: its name, and a field for each of its constants and options."""

    def __init__(self, kind: str, inputs: MuscleInputs):
        self._kind, self._inputs = kind, inputs
        self._law: Any = None
        self.fields: dict[str, Field] = {}
        self.choices: dict[str, pn.widgets.Select] = {}
        names = {name.replace("_", " "): name for name in LAWS[kind]}
        title = _TITLES.get(kind, kind.capitalize())
        self.select = dropdown(title, names, self._choose_law)
        self._message = Message()
        self._constants = column(margin=(0, 0, 0, 12))
        self.panel = column(self.select, self._message.pane, self._constants)

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` with quantities in `units`, by dimension."""
        before, self._law = self._law, law
        if type(law) is not type(before):
            self.fields = {
                constant.name: Field(
                    _label_of(constant.name),
                    constant.name,
                    constant.dimension,
                    partial(self._set_constant, constant.name),
                )
                for constant in law.constants()
            }
            self.choices = {
                switch.name: dropdown(
                    _label_of(switch.name),
                    {option.replace("_", " "): option for option in switch.options},
                    partial(self._choose_option, switch.name),
                )
                for switch in law.switches()
            }
            fields = [widget for field in self.fields.values() for widget in field.widgets]
            self._constants.objects = [*fields, *self.choices.values()]
        self.select.value = law.name
        for constant in law.constants():
            unit = field_unit(constant.dimension, units)
            self.fields[constant.name].show(float(getattr(law, constant.name)), unit)
        for name, choice in self.choices.items():
            choice.value = getattr(law, name)

    def _set_constant(self, name: str, value: object) -> None:
        self._inputs.change(**{self._kind: replace_checked(self._law, {name: value})})

    def _choose_law(self, name: str) -> None:
        if name != self._law.name:
            self._inputs.try_change(self._message, **{self._kind: name})

    def _choose_option(self, name: str, option: str) -> None:
        if option != getattr(self._law, name):
            law = replace_checked(self._law, {name: option})
            self._inputs.try_change(self._message, **{self._kind: law})


def _label_of(name: str) -> str:
    """Label of a law's constant or switch: `some_name` as "Some name"."""
    return name.replace("_", " ").capitalize()
