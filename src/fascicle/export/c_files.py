"""Header and source file of an export: checks of its object and name, templates, and writing."""

import re
from collections.abc import Callable, Mapping
from importlib.resources import files

import numpy as np

from ..bundle import Bundle
from ..bundle.bundle import as_bundle
from ..bundle.pressurized import muscle_strain, plate_strain
from ..core.errors import InvalidInputError
from ..core.types import Numbers
from ..core.validation import LARGEST_STRAIN, is_concrete
from ..muscle import Muscle
from ..muscle.table import default_strains


# a file of such a name would hide a header of C23, of POSIX or one that these include; and `fmu.c`
# is another source of a unit for co-simulation
_HEADERS = """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign
    stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath
    threads time uchar wchar wctype
    aio cpio dirent dlfcn fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen libintl monetary
    mqueue ndbm netdb nl_types poll pthread pwd regex sched search semaphore spawn strings stropts
    syslog tar termios trace ulimit unistd utime utmpx wordexp
    alloca endian features malloc memory values windows fmu
"""
# of C23 and of C++, which may include a header; devices of Windows
_KEYWORDS = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept
    const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype
    default delete do double dynamic_cast else enum explicit export extern false final float for
    friend goto if import inline int long module mutable namespace new noexcept not not_eq nullptr
    operator or or_eq override private protected public register reinterpret_cast requires restrict
    return short signed sizeof static static_assert static_cast struct switch template this
    thread_local throw true try typedef typeid typename typeof typeof_unqual union unsigned using
    virtual void volatile wchar_t while xor xor_eq
    main aux con nul prn
    null
"""
_RESERVED = {*_HEADERS.split(), *_KEYWORDS.split()}


def check_c_name(name: str) -> str:
    """The name, if C allows it."""
    # C++ reserves two underscores in succession, as `a_` would have before `_force`
    if len(name) > 31 or not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name):
        rule = "must be a name in C"
        remedy = "up to 31 letters, digits and single _ between them, a letter first"
        raise InvalidInputError("name", rule, None, f"{remedy}, got {name[:40]!r}")
    if name.lower() in _RESERVED:  # some file systems ignore case
        rule = "must not be a keyword or a standard header of C"
        remedy = f"add a word, such as {name}_muscle"
        raise InvalidInputError("name", rule, None, remedy, shown=name)
    return name


def concrete_bundle(target: Muscle | Bundle) -> Bundle:
    """The target as a bundle, if it holds numbers instead of arrays."""
    bundle = as_bundle(target, "target")
    if not is_concrete(target) or any(not unit.muscle.is_single for unit in bundle.motor_units):
        rule = "must hold numbers, one for each size"
        raise InvalidInputError("target", rule, None, shown="arrays")
    return bundle


def length_ratios(bundle: Bundle) -> tuple[float, ...]:
    """Distance of the plates over the length of each motor unit [-]."""
    ratios = np.ones(len(bundle.motor_units)) if bundle.ratios is None else bundle.ratios
    return tuple(map(float, ratios))


def table_strains(bundle: Bundle) -> list[tuple[float, float]]:
    """Ends of the table of each motor unit's muscle [-]: up to the contraction at which no unit of
    the bundle pulls any more, also where its own muscle stops pulling before.
    """
    muscles = [unit.muscle for unit in bundle.motor_units]
    pairs, ends = [*zip(muscles, length_ratios(bundle), strict=True)], []
    largest = max(plate_strain(ratio, float(m.braid.ideal_free_strain)) for m, ratio in pairs)
    for muscle, ratio in pairs:
        low, high = default_strains(muscle.law)
        ends.append((low, max(high, min(muscle_strain(ratio, largest), LARGEST_STRAIN))))
    return ends


def render_template(file: str, values: Mapping[str, object]) -> str:
    """Text of a template of the folder `templates`, with `values` in place of their `@names@`."""
    text = (files("fascicle.export") / "templates" / file).read_text(encoding="utf-8")
    text = re.sub(r"@(\w+)@", lambda match: str(values[match[1]]), text)
    return text.rstrip("\n") + "\n"


def c_array(values: Numbers, number: Callable[[float], str] = repr) -> str:
    """Initializers of an array in C, in braces from its second axis on; `number`: formats one."""
    rows = np.asarray(values).tolist()
    if rows and isinstance(rows[0], list):
        return ",\n".join("{" + c_array(row, number) + "}" for row in rows)
    return ", ".join(map(number, rows))
