"""`fascicle muscles`: the named examples."""

from typing import Annotated

import typer

from ..options import AsJson, complete_target
from ..problems import refusing


def run(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="Print this example's file.",
            autocompletion=complete_target,
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the named examples, or print one."""
    import json
    import sys

    from ...files import example_text, examples

    if name is not None:
        with refusing():
            text = example_text(name)
        sys.stdout.write(json.dumps({"name": name, "toml": text}) + "\n" if as_json else text)
    elif as_json:
        print(json.dumps(examples()))
    else:
        for known, about in examples().items():
            print(f"{known:24}{about}")
