r"""Tables and entries of the laws, made from what they declare: nobody lists them twice.

    ```{laws} tension
    ```

is a table of a kind's laws and their constants, `{law-modules}` the modules that hold them, and
`{law-abilities}` what each law of every kind can do.
"""

from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def table(kind: str) -> str:
    """The laws of a `kind` and the constants of each, as Markdown."""
    from fascicle.muscle import LAWS

    laws = LAWS[kind].values()
    rows = ["| law | in Python | source |", "|---|---|---|"]
    rows += [f"| `{law.name}` | `{kind}.{law.__name__}` | {law.source} |" for law in laws]
    own = [(law.name, one) for law in laws for one in (*law.constants(), *law.switches())]
    if own:
        rows += ["", "Numbers and choices of their own:", ""]
        rows += ["| law | key | what it is | left out | usual |", "|---" * 5 + "|"]
    rows += [f"| `{name}` | `{one.name}` | {_row(one)} |" for name, one in own]
    return "\n".join(rows)


def modules(kind: str) -> list[str]:
    """Full names of the modules of a kind's laws, without that of its base class."""
    from fascicle.muscle import LAWS

    names = dict.fromkeys(law.__module__ for law in LAWS[kind].values())
    return [name for name in names if not name.endswith(f".{kind}")]


def abilities() -> str:
    """What every law can do, as Markdown."""
    from fascicle.muscle import LAWS

    heads = ("kind", "law", "shear", "braid share", "muscles")
    rows = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for kind, laws in LAWS.items():
        for law in laws.values():
            own = {one.name for one in (*law.constants(), *law.switches())}
            past = kind == "buckling"  # who bends
            can = (
                _yes("shear" in own) if past else "", _yes("braid_share" in own) if past else "",
                getattr(law, "reference_muscle", "") or "any",
            )  # fmt: skip
            rows.append("| " + " | ".join((kind.replace("_", " "), f"`{law.name}`", *can)) + " |")
    return "\n".join(rows)


def _yes(can: bool) -> str:
    return "yes" if can else "no"


def _row(one: Any) -> str:
    from fascicle.units import pretty

    if hasattr(one, "options"):
        names = " or ".join(f'`"{option}"`' for option in one.options)
        return f'{one.about} | `"{one.options[0]}"` | {names}'
    _, low, high, _ = one.bounds
    default, low, high = (pretty(x, one.dimension, 6) for x in (one.default, low, high))
    symbol = f"${one.symbol}$, " if one.symbol else ""
    source = f"; {one.source}" if one.source else ""
    return f"{symbol}{one.about}{source} | {default} | {low} to {high}"


class Laws(SphinxDirective):
    """A kind's table."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """The table."""
        return parse_markdown(self, table(self.arguments[0]))


class Abilities(SphinxDirective):
    """What every law can do."""

    def run(self) -> list[nodes.Node]:
        """The table."""
        return parse_markdown(self, abilities())


class Modules(SphinxDirective):
    """The modules of a kind's laws."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Their entries."""
        entries = (
            f"```{{eval-rst}}\n.. automodule:: {one}\n```" for one in modules(self.arguments[0])
        )
        return parse_markdown(self, "\n\n".join(entries))


def parse_markdown(directive: SphinxDirective, text: str) -> list[nodes.Node]:
    """Nodes of a Markdown `text` in the place of a `directive`."""
    node = nodes.Element()
    lines = StringList(text.splitlines(), directive.env.docname)
    directive.state.nested_parse(lines, directive.content_offset, node)
    return node.children


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_directive("laws", Laws)
    app.add_directive("law-modules", Modules)
    app.add_directive("law-abilities", Abilities)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
