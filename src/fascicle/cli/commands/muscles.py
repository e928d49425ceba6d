"""`fascicle muscles`: the named examples."""

import json
import sys

from .. import options
from ..errors import user_errors
from ..options import argument, complete_target


def run(
    name: str | None = argument(
        "[NAME]", "Example to print.", None, autocompletion=complete_target
    ),
    as_json: bool = options.JSON,
) -> None:
    """List the named examples, or print the file of one."""
    from ...files import example_text, examples

    if name is not None:
        with user_errors():
            text = example_text(name)
        sys.stdout.write(json.dumps({"name": name, "toml": text}) + "\n" if as_json else text)
    elif as_json:
        print(json.dumps(examples()))
    else:
        for example, description in examples().items():
            print(f"{example:24}{description}")
