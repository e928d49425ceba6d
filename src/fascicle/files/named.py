"""The named examples: muscles and bundles of the literature, scenarios that drive them, each a file
with its source.
"""

import difflib
from typing import Any

from .shipped import abouts, names, text


_KIND, _SCENARIOS = "examples", "scenarios"


def examples() -> dict[str, str]:
    """The named muscles and bundles.

    **Returns:** a line about each, by name [-].
    """
    return abouts(_KIND)


def scenarios() -> dict[str, str]:
    """The named scenarios.

    **Returns:** a line about each, by name [-].
    """
    return abouts(_SCENARIOS)


def example_text(name: str) -> str:
    """The file of a named example.

    **Arguments:** `name`: one of `examples()` or `scenarios()` [-].

    **Returns:** the TOML with its comments [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    kinds = {one: kind for kind in (_SCENARIOS, _KIND) for one in names(kind)}
    if name not in kinds:
        near = difflib.get_close_matches(str(name), kinds, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(sorted(kinds))}."
        raise ValueError(f"no example is named {str(name)[:60]!r}: {hint}")
    return text(kinds[name], name)


def example(name: str) -> Any:
    """A named muscle, bundle or scenario.

    **Arguments:** `name`: one of `examples()` or `scenarios()` [-].

    **Returns:** the `Muscle`, `Bundle` or `Scenario` [-].

    **Raises:** `ValueError` for an unknown name; the nearest is suggested.
    """
    content = example_text(name)
    if name in names(_SCENARIOS):
        from .scenario import loads_scenario

        return loads_scenario(content, source=name)
    from .reading import loads

    return loads(content, source=name)
