"""Build the law of the page: `src/fascicle/export/page/law.wasm.gz` and `law.json`.

For each choice of laws a muscle of symbols is traced to three functions of its constants: `at`
solves for what depends on pressure alone (free strain, onset, collapse, and a state), `force` and
`shape` take that state to a strain. CasADi writes them as C and clang compiles them to WebAssembly
(on Debian: `apt-get install clang lld wasi-libc`). `make page` runs it; it
takes some minutes, nearly all for the elastica.
"""

import argparse
import gzip
import itertools
import json
import subprocess
import tempfile
import warnings
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from fascicle import Muscle
from fascicle.core.module import tree_leaves, tree_replace
from fascicle.export.page_law import MANIFEST, MODULE, POINTS, function_key, general_muscle
from fascicle.export.symbols import symbols


# laws of the tension whose free strain and pull take few operations, for a bowed muscle's arc too
TENSIONS = ("klute_hannaford", "ideal", "kothera2009", "tondu_lopez", "meller2014")
LAWS: list[tuple[str, str, str]] = [
    *itertools.product(["kim2021"], TENSIONS, ["rigid", "compliant"]),
    ("elastica", "klute_hannaford", "rigid"),
]
OUTPUTS = ("at", "force", "shape")


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
        state.column.free_strain, state.collapse, state.onset, general.law.blocked_force(P),
    )  # fmt: skip
    outputs = functions.resolve(*map(ca.SX, summary), *(leaves[i] for i in indices))
    row = ca.vertcat(*constants)
    at = ca.Function(f"{name}_at", [row, P], [ca.vertcat(*outputs[:4]), ca.vertcat(*outputs[4:])])

    kept = {i: ca.SX.sym(f"s{i}", leaves[i].shape) for i in indices}
    state = tree_replace(state, [kept.get(i, leaf) for i, leaf in enumerate(leaves)])
    inputs = [row, P, ca.vertcat(*kept.values()), eps]
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


def main() -> None:
    """Trace, compile and write the module; `--only kim2021` for a quick trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="laws whose key contains this text")
    text = parser.parse_args().only
    warnings.simplefilter("ignore")  # of a law that was published for another muscle
    code, entries = ca.CodeGenerator("law.c", {"with_header": False}), {}
    for i, laws in enumerate(law for law in LAWS if text in "/".join(law)):
        key, functions, sizes = trace(laws, f"law{i}")
        for function in functions:
            code.add(function)
        entries[key] = sizes
        print(key, *(function.n_nodes() for function in functions))
    with tempfile.TemporaryDirectory() as folder:
        source, binary = Path(folder) / "law.c", Path(folder) / "law.wasm"
        source.write_text(code.dump(), encoding="utf-8")
        exports = [f"{entry['name']}_{output}" for entry in entries.values() for output in OUTPUTS]
        flags = ("--no-entry", "--strip-all", *(f"--export={x}" for x in [*exports, "__heap_base"]))
        subprocess.run(  # noqa: S603 the compiler
            ["clang", "--target=wasm32-wasi", "-O1", "-nostdlib",  # noqa: S607
             *(f"-Wl,{flag}" for flag in flags), str(source), "-o", str(binary), "-lm", "-lc"],
            check=True,
        )  # fmt: skip
        data = binary.read_bytes()
    MODULE.write_bytes(gzip.compress(data, 9, mtime=0))  # equal formulas give an equal file
    MANIFEST.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    print(f"{len(data)} bytes, {MODULE.stat().st_size} compressed")


if __name__ == "__main__":
    main()
