"""`fascicle export`: a muscle or bundle for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from ..inputs import read_target
from ..options import Replace, Target
from ..outputs import say
from ..problems import UserError, refusing


def run(
    file: Target,
    c: Annotated[
        str,
        typer.Option(
            "--c",
            metavar="FOLDER",
            help="Write C there, a header and a source without dependencies.",
            show_default=False,
        ),
    ],
    name: Annotated[
        str, typer.Option("--name", help="With which files, and names in C, begin.")
    ] = "muscle",
    overwrite: Replace = False,
) -> None:
    """Write a muscle's or bundle's force, its slopes and free strain as C.

    The code stands for the numbers in the file as they are now; it needs `fascicle[export]`.
    """
    from ...core.atomic import check_writable, write_text
    from ...files.ours import check_file, replacing

    found = read_target(file)
    paths = [Path(c) / f"{name}.{end}" for end in ("h", "c")]
    with refusing("--c "):
        check_writable(c, folder=True)
        for path in paths:
            check_file(path, overwrite)
    from ...export import c_code

    try:
        with refusing():
            texts = c_code(found, name)
    except ModuleNotFoundError as error:
        raise UserError(str(error)) from None
    with refusing("--c "):
        Path(c).mkdir(parents=True, exist_ok=True)
        for path, text in zip(paths, texts, strict=True):
            with replacing(path, overwrite):
                write_text(path, text)
    say(f"wrote {paths[0]} and {paths[1]}")
