"""Sphinx: Markdown pages, executed; docstrings in the same Markdown; no outside request."""

import html
import logging
import os
import re
import sys
from pathlib import Path
from typing import Any

from fascicle import __version__
from fascicle.plot.theme import DARK, LIGHT, MONO, SANS, Colors


HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent / "tests")]

from quick import compile_fast  # noqa: E402 stands beside the tests


# pages share what they and the tests compile, and a rebuild compiles nothing
os.environ.setdefault("JAX_PLATFORMS", "cpu")
compile_fast(HERE.parent)
logging.getLogger("traitlets").setLevel(logging.ERROR)


def _furo(colors: Colors) -> dict[str, str]:
    """The theme's variables [-], from the colors that explorer, reports and figures have, too."""
    return {
        "font-stack": SANS,
        "font-stack--monospace": MONO,
        "color-foreground-primary": colors.ink,
        "color-foreground-secondary": colors.soft,
        "color-background-primary": colors.paper,
        "color-background-secondary": colors.raised,
        "color-background-border": colors.line,
        "color-brand-primary": colors.accent,
        "color-brand-content": colors.accent,
        "color-brand-visited": colors.accent,
    }


project = "fascicle"
author = "the fascicle maintainers"
copyright = "the fascicle maintainers, Apache-2.0"
release = version = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx-mathjax-offline",
    "muscle_catalog",  # _ext: sections of the measured muscles, from their files
    "laws",  # _ext: tables of the laws, from what they declare
    "public",  # _ext: entries of public names, from the packages
    "docstrings",  # _ext: Markdown docstrings, and the way back from a function to its equation
    "pages",  # _ext: executed in a warm kernel, the long ones first
    "gallery",  # _ext: a grid of pages with the first picture of each
    "live_page",  # _ext: the muscle that the first page shows at work
    "offline",  # _ext: a page that would ask another server fails the build
]
exclude_patterns = ["_build", "_ext", "_templates", "jupyter_execute"]
nitpicky = True
nitpick_ignore_regex = [
    # bases and fields from elsewhere, whose pages are on another server
    ("py:.*", r"(equinox|jax|jaxtyping|numpy|collections|typing|types|abc|builtins)\..*"),
]

# beside a page stand its sections: the hundreds of names under them are found by the search, and
# took a third of the time to write all pages
toc_object_entries = False

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
math_number_all = False

nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_execution_show_tb = True
if tags.has("short"):  # `tags` is Sphinx's own
    # the longest pages, whose parts other tests run: `make docs` executes them
    nb_execution_excludepatterns = [
        *("calibrate.md", "control.md", "design.md", "dynamics.md"),
        *("how-to/mujoco.md", "how-to/plc.md", "how-to/train.md"),
    ]
nb_merge_streams = True
nb_render_image_options = {"width": "90%"}

autodoc_default_options = {"members": True, "member-order": "bysource"}
# the docstrings say type and unit in words
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autoclass_content = "both"

html_theme = "furo"
templates_path = ["_templates"]
html_sidebars = {
    "**": [
        "sidebar/brand.html", "versions.html", "sidebar/search.html", "sidebar/scroll-start.html",
        "sidebar/navigation.html", "sidebar/scroll-end.html",
    ]
}  # fmt: skip
# where the site will be, such as "https://example.org/fascicle/0.2.0/": pictures of links (Open
# Graph) need a full address, and are left out without one
html_baseurl = os.environ.get("DOCS_URL", "")
html_title = f"fascicle {release}"
html_copy_source = False
html_show_sphinx = False
html_static_path = ["_static"]
html_css_files = ["equations.css", "site.css"]
html_theme_options = {
    "navigation_with_keys": True,
    **{
        f"{name}_css_variables": _furo(colors)
        for name, colors in (("light", LIGHT), ("dark", DARK))
    },
}


def setup(app: Any) -> None:
    """Let pages be read side by side: this extension, which doesn't say so, only copies files."""
    app.extensions["sphinx-mathjax-offline"].parallel_read_safe = True
    app.connect("html-page-context", add_open_graph)


def add_open_graph(app: Any, page: str, _: str, context: dict[str, Any], __: Any) -> None:
    """Add the tags that other sites show of a link to a page."""
    properties = {
        "site_name": "fascicle",
        "type": "website",
        "title": context.get("title") or "fascicle",
        "description": "Models of fluidic artificial muscles (McKibben muscles) and their bundles.",
    }
    if html_baseurl:
        properties["url"] = html_baseurl + app.builder.get_target_uri(page)
        properties["image"] = f"{html_baseurl}_static/readme.png"
        properties["image:alt"] = "Fig. 9 of the paper, reproduced"
    for name, value in properties.items():
        tag = (
            f'<meta property="og:{name}" content="{html.escape(re.sub("<[^>]+>", "", value))}" />\n'
        )
        context["metatags"] = context.get("metatags", "") + tag
