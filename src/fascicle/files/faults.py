"""What is wrong with a file, in one line: path, key, the value as written, the rule.

Pydantic reports every fault of a file at once. One is enough to act on, so the most telling
one is shown: an unknown key before the missing one that it probably misspells.
"""

import difflib
import json
import re
from collections.abc import Iterable, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from ..muscle.law import AbstractLaw
from ..muscle.laws import LAWS
from .schema import CHOICES, PLAIN, TABLE


_ORDER = ("extra_forbidden", "missing")
_RULES = {
    "model_type": "must be a table of keys",
    "dict_type": "must be a table of keys",
    "list_type": "must be a list",
    "string_type": "must be a name in quotes",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
}


def from_validation(error: ValidationError, source: str, data: Any, model: type[BaseModel]) -> str:
    """One line for the most telling fault in `error`.

    **Arguments:**

    - `error`: what pydantic found [-].
    - `source`: the file's path, or what stands for it [-].
    - `data`: the data it looked at [-].
    - `model`: the section that the whole of `data` should be [-].

    **Returns:** the line [-].
    """
    faults = sorted(
        error.errors(include_url=False),
        key=lambda fault: _ORDER.index(fault["type"]) if fault["type"] in _ORDER else len(_ORDER),
    )
    fault, more = faults[0], len(faults) - 1
    loc = _without_choices(fault["loc"])
    # a lone muscle's name is empty
    path = [part for i, part in enumerate(loc) if part != "" or i != 1 or loc[0] != "muscle"]
    kind, name = fault["type"], str(path[-1])
    if kind == "extra_forbidden":
        known = _of_law(_known_keys(model, fault["loc"][:-1]), data, loc[:-1])
        return line(source, path, f"unknown key{nearest(name, known)}")
    if kind == "missing":
        return line(source, path, f"missing{_example(model, fault['loc'])}.")
    rule = fault.get("ctx", {}).get("error") or f"{_RULES.get(kind, fault['msg'])}"
    others = f" ({more} more after it)" if more else ""
    return line(source, path, f"{str(rule).rstrip('.')}.{others}", value(data, loc))


def line(source: str, path: Iterable[Any], rule: str, written: Any = None) -> str:
    """`path: dotted.key = value: rule`, on one line.

    **Arguments:**

    - `source`: the file's path [-].
    - `path`: the keys that lead to the value [-].
    - `rule`: what it should be and what to do [-].
    - `written`: the value as it stands in the file [-]; a table or nothing isn't shown.

    **Returns:** the line [-].
    """
    key = re.sub(r"\.(\d+)", lambda index: f"[{index[1]}]", ".".join(map(_bare, path)))
    shown = ""
    if isinstance(written, str | int | float | bool):
        text = json.dumps(written, ensure_ascii=False)
        shown = f" = {text if len(text) <= 60 else text[:50] + '…'}"
    return " ".join(f"{source}: {key}{shown}: {rule}".split())


def nearest(name: str, known: Iterable[str]) -> str:
    """`, did you mean "length"?` where there is one like it, else the choices.

    **Arguments:**

    - `name`: what was written [-].
    - `known`: what could have been [-].

    **Returns:** the hint [-], which ends its sentence.
    """
    choices = sorted(known)
    near = difflib.get_close_matches(name, choices, n=1, cutoff=0.6)
    if near:
        return f', did you mean "{near[0]}"?'
    return f", choose one of {', '.join(choices)}." if choices else "."


def value(data: Any, path: Iterable[Any]) -> Any:
    """What stands in `data` at `path`, or `None`.

    **Arguments:**

    - `data`: nested tables and lists [-].
    - `path`: keys and indices [-].

    **Returns:** the value [-].
    """
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _without_choices(loc: Sequence[Any]) -> list[Any]:
    """Keys and indices without pydantic's marks of a choice between types, which no file has."""
    marks = (PLAIN, TABLE)
    return [one for i, one in enumerate(loc) if one not in marks or loc[i - 1 : i] not in CHOICES]


def _bare(part: Any) -> str:
    """A key as TOML writes it: in quotes where it isn't a bare one."""
    text = str(part)
    if isinstance(part, int) or re.fullmatch(r"[\w-]{1,40}", text, re.ASCII):
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    return quoted if len(quoted) <= 42 else quoted[:40] + "…"


def _field(model: type[BaseModel], loc: Sequence[Any]) -> Any:
    """The schema's field at `loc`; names and indices that aren't fields are passed over."""
    field = None
    for part in loc:
        found = model.model_fields.get(part) if isinstance(part, str) else None
        if found is None:
            continue
        field, inner = found, _sections(found.annotation)
        model = inner[0] if inner else model
    return field if loc else model


def _sections(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    arguments = getattr(annotation, "__args__", ())
    return [section for argument in arguments for section in _sections(argument)]


def _known_keys(model: type[BaseModel], loc: Sequence[Any]) -> list[str]:
    field = _field(model, loc)
    sections = _sections(getattr(field, "annotation", None)) or [model]
    return list(sections[0].model_fields)


def _of_law(known: list[str], data: Any, loc: Sequence[Any]) -> list[str]:
    """Of the `known` keys of a law's table those of the law that it names, where it names one."""
    laws, table = LAWS.get(str(loc[-1]), {}) if loc else {}, value(data, loc)
    named = laws.get(str(table.get("law"))) if isinstance(table, dict) else None
    if named is None:
        return known
    others = {key for law in laws.values() for key in _keys(law)} - _keys(named)
    return [key for key in known if key not in others]


def _keys(law: type[AbstractLaw]) -> set[str]:
    return {one.name for one in (*law.constants(), *law.switches())}


def _example(model: type[BaseModel], loc: Sequence[Any]) -> str:
    examples = getattr(_field(model, loc), "examples", None)
    if not examples:
        return ""
    return (
        f", write {examples[0]}" if examples[0][0] == "[" else f", write {loc[-1]} = {examples[0]}"
    )
