"""`--json FILE` and `--csv FILE`: what a command prints goes to a file, whole or not at all.

The options stand for themselves, too, and a name after them is a file where it ends as they do, or
where an equals sign joins them: `--json out.json`, `--json=out`. `-` is standard output.
"""

import contextlib
import io
import itertools
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from .once import refuse_repeated
from .problems import refusing


_ENDS = {"--json": ".json", "--csv": ".csv"}


def parted(arguments: Sequence[str]) -> tuple[list[str], str, str]:
    """The arguments of a command without the file that its output goes to.

    **Arguments:** `arguments`: as they were typed [-].

    **Returns:** the others, the option and the file, both empty where there is none [-].
    """
    out, option, path = [], "", ""
    waiting = list(arguments)
    while waiting:
        one = waiting.pop(0)
        name, equals, value = one.partition("=")
        if name not in _ENDS:
            out.append(one)
            continue
        out.append(name)
        if not equals and waiting and (waiting[0] == "-" or _is_file(waiting[0], name)):
            value = waiting.pop(0)
        if value not in ("", "-"):
            refuse_repeated(name, [path, value] if option == name else [], listed=False)
            option, path = name, value
    return out, option, path


def misnamed(arguments: Sequence[str], told: str) -> str:
    """What to say where a command was `told` [-] to have too many `arguments` [-], and one of them
    was meant for a file [-]; empty where none was.
    """
    extra = re.search(r"unexpected extra argument\S* \((.*)\)", told)
    for option, name in itertools.pairwise(arguments):
        if extra and option in _ENDS and name in extra[1].split() and Path(name).suffix:
            return f"{option} {name}: the file's name must end in {_ENDS[option]}."
    return ""


@contextlib.contextmanager
def into(path: str, option: str, overwrite: bool, flag: str) -> Iterator[None]:
    """Let what is printed inside go to a file, once all of it is there.

    **Arguments:**

    - `path`: of the file [-]; empty for none.
    - `option`: that named it [-].
    - `overwrite`: whether whatever stands there is replaced [-].
    - `flag`: the option that says so [-].
    """
    if not path:
        yield
        return
    from ..files.ours import check_file, replacing
    from ..io.atomic import check_writable

    with refusing(f"{option} "):
        check_writable(path)
        check_file(path, overwrite, flag)
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        yield
    with refusing(f"{option} "), replacing(path, overwrite, flag) as draft:
        draft.write_text(told.getvalue(), encoding="utf-8", newline="\n")


def _is_file(text: str, option: str) -> bool:
    return Path(text).suffix.lower() == _ENDS[option] and not text.startswith("-")
