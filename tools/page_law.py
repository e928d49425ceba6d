"""Build the law of the page: `src/fascicle/export/page/law.wasm.gz` and `law.json`.

For each choice of laws a muscle of symbols is traced to three functions of its constants: `at`
solves for what depends on pressure alone (free strain, onset, collapse, and a state), `force` and
`shape` take that state to a strain. CasADi writes them as C and clang compiles them to WebAssembly
(on Debian: `apt-get install clang lld wasi-libc`). `make page` runs
it; most of its time goes to the elastica.
"""

import argparse
import gzip
import itertools
import json
import re
import subprocess
import tempfile
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fascicle import Muscle
from fascicle.core.module import tree_leaves, tree_replace
from fascicle.export.page_law import MANIFEST, MODULE, POINTS, function_key, general_muscle
from fascicle.export.symbols import symbols


# of the laws of the tension all but `elastic_braid`, which searches for the fibers' stretch at each
# step of each other search, ten times the operations. Published fits have rigid ends
TENSIONS = ("klute_hannaford", "ideal", "kothera2009", "tondu_lopez", "meller2014")
PUBLISHED = ("bolen", "bolen_20", "sarosi", "sarosi_10", "sarosi_20_400", "martens2017",
             "martens2017_20")  # fmt: skip
LAWS: list[tuple[str, str, str]] = [
    ("elastica", "klute_hannaford", "rigid"),  # first: it takes longest to compile
    *itertools.product(["kim2021"], TENSIONS, ["rigid", "compliant"]),
    *itertools.product(["kim2021"], PUBLISHED, ["rigid"]),
]


def trace(laws: tuple[str, str, str], name: str) -> tuple[str, list[Any], dict]:
    """Key of the `laws`, three functions of CasADi with a `name`, and their sizes."""
    buckling, tension, ends = laws
    muscle = Muscle(0.12, 6e-3, 1e-3, 0.5, tension=tension, buckling=buckling, ends=ends)
    general, constants = general_muscle(muscle), []

    def symbol(leaf: Any) -> Any:
        """A new symbol; in an array where the `leaf` is a table's row."""
        constants.append(ca.SX.sym(f"c{len(constants)}"))
        if not np.ndim(leaf):
            return constants[-1]
        row = np.empty(1, object)
        row[0] = constants[-1]
        return row

    functions = symbols()
    general = tree_replace(general, [symbol(leaf) for leaf in tree_leaves(general)])
    P, eps = ca.SX.sym("P"), ca.SX.sym("eps")
    state = general.law.at(P)
    leaves = tree_leaves(state)
    indices = [
        i for i, leaf in enumerate(leaves) if isinstance(leaf, ca.SX) and not leaf.is_valid_input()
    ]
    summary = (
        state.column.free_strain, state.collapse_strain, state.onset,
        general.law.blocked_force(P),  # not used by `law.js`, which has it from `force`
    )  # fmt: skip
    outputs = functions.resolve(*map(ca.SX, summary), *(leaves[i] for i in indices))
    row = ca.vertcat(*constants)
    at = ca.Function(f"{name}_at", [row, P], [ca.vertcat(*outputs[:4]), ca.vertcat(*outputs[4:])])

    state_symbols = {i: ca.SX.sym(f"s{i}", leaves[i].shape) for i in indices}
    state = tree_replace(state, [state_symbols.get(i, leaf) for i, leaf in enumerate(leaves)])
    inputs = [row, P, ca.vertcat(*state_symbols.values()), eps]
    functions = symbols()
    force = ca.Function(f"{name}_force", inputs, functions.resolve(state.force(eps)[0]))
    functions = symbols()
    line = state.shape(eps, POINTS)
    steps = [ca.diff(x) for x in (line.z, line.y)]
    arc_strain = 1 - ca.sum1(ca.sqrt(steps[0] ** 2 + steps[1] ** 2)) / general.length
    tube = (
        state.deflection(eps), general.braid.radius_at(arc_strain),
        general.braid.angle_at(arc_strain),
    )  # fmt: skip
    outputs = functions.resolve(*map(ca.densify, (line.z, line.y, ca.vertcat(*tube))))
    shape = ca.Function(f"{name}_shape", inputs, outputs)
    sizes = {"name": name, "constants": len(constants), "state": inputs[2].numel()}
    return function_key(muscle), [at, force, shape], sizes


_CHOICES = """
static double choose(double condition, double x) { return condition != 0 ? x : 0; }
static double both(double x, double y) { return (x != 0) & (y != 0); }
static double either(double x, double y) { return (x != 0) | (y != 0); }
"""


def code_of(function: Any) -> str:
    """C of a `function` of CasADi as straight lines, for which clang takes a fortieth of the time:
    thousands of `?`, `&&` and `||` are calls, to be inlined later, and no pointer is null.
    """
    generator = ca.CodeGenerator(f"{function.name()}.c", {"with_header": False})
    generator.add(function)
    code = generator.dump()
    for pattern, text in (
        (r"arg\[(\d)\]\? arg\[\1\]\[(\d+)\] : 0", r"arg[\1][\2]"),
        (r"if \(res\[(\d)\]!=0\) ", ""),
        (r"\((a\d+)\?(a\d+):0\)", r"choose(\1, \2)"),
        (r"\((a\d+)&&(a\d+)\)", r"both(\1, \2)"),
        (r"\((a\d+)\|\|(a\d+)\)", r"either(\1, \2)"),
    ):
        code = re.sub(pattern, text, code)
    return _CHOICES + code


def compile_module(sources: dict[str, str]) -> bytes:
    """Module of WebAssembly of C `sources`, each of the one function that names it."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor() as pool:

        def compile_object(name: str) -> str:
            path = Path(folder, f"{name}.c")
            path.write_text(sources[name], encoding="utf-8")
            _run_clang("-O1", "-c", str(path), "-o", str(path.with_suffix(".o")))
            return str(path.with_suffix(".o"))

        objects = list(pool.map(compile_object, sources))
        flags = ("--no-entry", "--strip-all", *(f"--export={x}" for x in [*sources, "__heap_base"]))
        module = Path(folder, "law.wasm")
        linking = ("-nostdlib", *(f"-Wl,{flag}" for flag in flags))
        _run_clang(*linking, *objects, "-o", str(module), "-lm", "-lc")
        return module.read_bytes()


def _run_clang(*arguments: str) -> None:
    subprocess.run(["clang", "--target=wasm32-wasi", *arguments], check=True)  # noqa: S603, S607 the compiler


def main() -> None:
    """Trace, compile and write the module; `--only kim2021` for a quick trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="laws whose key contains this text")
    text = parser.parse_args().only
    warnings.simplefilter("ignore")  # of a law that was published for another muscle
    entries, sizes_by_formulas, sources = {}, {}, {}
    for i, laws in enumerate(law for law in LAWS if text in "/".join(law)):
        name = f"law{i:02}"
        key, functions, sizes = trace(laws, name)
        texts = {function.name(): code_of(function) for function in functions}
        formulas = "".join(texts.values()).replace(name, "")
        if (
            formulas not in sizes_by_formulas
        ):  # laws that differ by the defaults of their constants are one
            sizes_by_formulas[formulas] = sizes
            sources |= texts
        entries[key] = sizes_by_formulas[formulas]
        print(key, entries[key]["name"], *(function.n_nodes() for function in functions))
    data = compile_module(sources)
    MODULE.write_bytes(gzip.compress(data, 9, mtime=0))  # equal formulas give an equal file
    MANIFEST.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    print(f"{len(data)} bytes, {MODULE.stat().st_size} compressed")


if __name__ == "__main__":
    main()
