"""Inputs of a muscle: its sizes, material and laws; errors appear at their own fields."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from typing import Any

from ..core.errors import InvalidInputError
from ..core.module import replace_checked
from ..files.shipped_files import named_muscles
from ..muscle import Muscle
from ..muscle.laws import LAWS
from ..muscle.materials import MATERIALS
from .pins import shipped_muscle
from .state import Session, View
from .theme import column
from .widgets import SIZES, WHOLE_ROW, Field, Message, dropdown, field_unit


_CUSTOM, _CHANGED = "its own", ", changed"
_TITLES = {"post_collapse": "After collapse"}  # where it isn't the kind's name
_INDENT: dict[str, Any] = {"margin": (2, 8, 2, 20), **WHOLE_ROW}


class MuscleInputs:
    """Inputs of a muscle; a change makes another muscle, or shows why there is none."""

    def __init__(self, session: Session):
        self._session = session
        self.fields = {
            name: Field(label, name, dimension, partial(self._set_size, name))
            for name, (label, dimension) in SIZES.items()
        }
        self._material = dropdown(
            "Material", [*MATERIALS, _CUSTOM], self._choose_material, **WHOLE_ROW
        )
        self.laws = {kind: LawInputs(kind, self) for kind in LAWS}
        self.panel = column(kind="pairs")
        self.message = Message()
        self.arrange()

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

    def show_error(self, error: ValueError | str) -> None:
        """Show an error that isn't of one field, below all of them."""
        self.message.show(error, self._session.view.display_units)

    def arrange(self) -> None:
        """Put all widgets in order, after a law has got other fields."""
        laws = [widget for law in self.laws.values() for widget in law.widgets]
        sizes = [widget for field in self.fields.values() for widget in field.widgets]
        self.panel.objects = [*sizes, self._material, *laws, self.message.pane]

    def change(self, **parts: Any) -> None:
        """Replace parts of the session's muscle, and rename it; `ValueError` if it can't be."""
        view = self._session.view
        muscle = view.muscle.replace(**parts)
        after = replace(view, muscle=muscle, name=self._name_of(muscle))
        _ = after.bundle  # raises at this field if it can't be a bundle any more
        self._session.show(after)

    def _name_of(self, muscle: Muscle) -> str:
        """Name of a `muscle` that was changed: the opened one's if it is the same again."""
        opened, name = self._session.opened, self._session.view.name.removesuffix(_CHANGED)
        if muscle == opened.muscle:
            return opened.name
        if name in named_muscles() and muscle == shipped_muscle(name):
            return name
        return f"{name}{_CHANGED}"

    def errors(self) -> AbstractContextManager[None]:
        """Show a `ValueError` of the block below all fields."""
        return self.message.errors(self._session.view.display_units)

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
            with self.errors():
                self.change(material=name)


class LawInputs:
    """Inputs of one kind of law: its name, and a field for each of its constants and options."""

    def __init__(self, kind: str, inputs: MuscleInputs):
        self._kind, self._inputs = kind, inputs
        self._law: Any = None
        self.fields: dict[str, Field] = {}
        self.choices: dict[str, Any] = {}
        names = {name.replace("_", " "): name for name in LAWS[kind]}
        title = _TITLES.get(kind, kind.capitalize())
        self.select = dropdown(title, names, self._choose_law, **WHOLE_ROW)

    @property
    def widgets(self) -> list[Any]:
        """Widgets in the order of the page."""
        fields = [widget for field in self.fields.values() for widget in field.widgets]
        return [self.select, *fields, *self.choices.values()]

    def show(self, law: Any, units: Mapping[str, str]) -> None:
        """Show a `law` with quantities in `units`, by dimension."""
        before, self._law = self._law, law
        if type(law) is not type(before):
            self._make_widgets(law)
        self.select.value = law.name
        for constant in law.constants():
            unit = field_unit(constant.dimension, units)
            self.fields[constant.name].show(float(getattr(law, constant.name)), unit)
        for name, choice in self.choices.items():
            choice.value = getattr(law, name)

    def _make_widgets(self, law: Any) -> None:
        self.fields = {
            constant.name: Field(
                _label_of(constant.name), constant.name, constant.dimension,
                partial(self._change_law, constant.name), **_INDENT,
            )
            for constant in law.constants()
        }  # fmt: skip
        self.choices = {}
        for switch in law.switches():
            names = {option.replace("_", " "): option for option in switch.options}
            self.choices[switch.name] = dropdown(
                _label_of(switch.name), names, partial(self._choose_option, switch.name), **_INDENT
            )
        self._inputs.arrange()

    def _change_law(self, name: str, value: Any) -> None:
        self._inputs.change(**{self._kind: replace_checked(self._law, {name: value})})

    def _choose_law(self, name: str) -> None:
        if name != self._law.name:
            with self._inputs.errors():
                self._inputs.change(**{self._kind: name})

    def _choose_option(self, name: str, option: str) -> None:
        if option != getattr(self._law, name):
            with self._inputs.errors():
                self._change_law(name, option)


def _label_of(name: str) -> str:
    """Label of a law's constant or switch: `some_name` as "Some name"."""
    return name.replace("_", " ").capitalize()
