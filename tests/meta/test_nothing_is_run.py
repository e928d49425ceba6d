"""What a file holds is data: no module loads what could be run, or evaluates text."""

import ast
from pathlib import Path


SOURCE = Path(__file__).parents[2] / "src" / "fascicle"
LOADERS = {"pickle", "cloudpickle", "dill", "joblib", "marshal", "shelve", "runpy", "code"}
EVALUATORS = {"eval", "exec", "__import__", "compile"}


def offences(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [one.name for one in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""] if node.level == 0 else []
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in EVALUATORS:
                yield node.func.id
            continue
        elif isinstance(node, ast.keyword) and node.arg == "allow_pickle":
            if not (isinstance(node.value, ast.Constant) and node.value.value is False):
                yield "allow_pickle"
            continue
        else:
            continue
        yield from {name.split(".")[0] for name in names} & LOADERS


def test_no_module_can_run_what_it_reads():
    found = [
        (str(path.relative_to(SOURCE)), name)
        for path in SOURCE.rglob("*.py")
        for name in offences(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not found


def test_the_search_finds_what_it_looks_for():
    text = "import pickle\nfrom joblib import load\neval('1')\nnp.load(x, allow_pickle=True)"
    assert set(offences(ast.parse(text))) == {"pickle", "joblib", "eval", "allow_pickle"}
    assert not set(offences(ast.parse("np.load(x, allow_pickle=False)\nfrom .code import x")))
