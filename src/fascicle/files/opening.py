"""Whatever a file of ours describes: muscle, bundle or scenario."""

import os
from pathlib import Path
from typing import Any

from .reading import described, parsed, text_of


def load(path: str | os.PathLike[str]) -> Any:
    """Read a muscle, bundle or scenario file.

    **Arguments:** `path`: the TOML file [-].

    **Returns:** a `Scenario` if the file has a `[load]` and a `[run]`, a `Bundle` if it has a
    `[bundle]` alone, else its `Muscle` [-].

    **Raises:** `OSError` where it can't be read; `ValueError`, in one line with the path and
    the key, where what it says can't be.
    """
    path = Path(path)
    data = parsed(text_of(path), str(path))
    if {"load", "run", "schedule"} & data.keys():
        from .scenario import scenario_of

        return scenario_of(data, str(path), path.parent, path.stem)
    return described(data, str(path))
