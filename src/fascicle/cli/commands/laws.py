"""`fascicle laws`: the laws of each kind, their constants, and the packages that have them."""

import json
import textwrap

from ...io.sanitize import sanitize_line
from .. import options
from ..errors import user_errors
from ..inputs import load_laws
from ..options import argument


_WIDTH = 74  # characters of a line of constants: with the indent, a terminal's 80


def run(
    kind: str | None = argument(
        "KIND",
        "Kind of law: tension, buckling, collapse, post_collapse or ends; default: all.",
        None,
    ),
    as_json: bool = options.JSON,
) -> None:
    """List the laws and their constants, including those of other packages."""
    load_laws()
    from ...core.validation import check_choice
    from ...muscle.law import package_of
    from ...muscle.laws import LAWS

    with user_errors():
        kinds = list(LAWS) if kind is None else [check_choice(kind, LAWS, "kind")]
    entries = [
        {
            "kind": name,
            "law": law.name,
            "constants": [x.name for x in (*law.constants(), *law.switches())],
            "source": law.source,
            "package": package_of(law),
        }
        for name in kinds
        for law in LAWS[name].values()
    ]
    if as_json:
        print(json.dumps(entries))
        return
    for name in kinds:
        print(f"{name} laws, default: {LAWS[name].default.name}")
        for entry in (entry for entry in entries if entry["kind"] == name):
            package = "" if entry["package"] == "fascicle" else f" [{entry['package']}]"
            source = sanitize_line(f"{entry['source']}{package}")
            print(f"  {sanitize_line(entry['law']):20}{source}")
            for line in textwrap.wrap(", ".join(entry["constants"]), _WIDTH):
                print(f"      {line}")
