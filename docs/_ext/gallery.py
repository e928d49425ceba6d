"""A grid of pages with the first picture of each:

    ```{gallery}
    gallery/length
    ```

The pictures are those that the pages' own cells draw.
"""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class Pages(nodes.General, nodes.Element):
    """Names of the pages, until all pages are read."""


class Gallery(SphinxDirective):
    """The grid."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Its place, and the names of its pages."""
        return [Pages("", names=[line.strip() for line in self.content if line.strip()])]


def resolve(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """Put links with titles and pictures in the place of the names."""
    for place in list(doctree.findall(Pages)):
        grid = nodes.container(classes=["gallery"])
        for name in place["names"]:
            title = app.env.titles[name].astext()
            picture = next(app.env.get_doctree(name).findall(nodes.image)).deepcopy()
            picture.attributes.pop("width", None)
            picture["alt"] = ""  # the title beside it says the same
            address = app.builder.get_relative_uri(docname, name)
            link = nodes.reference("", "", picture, nodes.inline(title, title), internal=True)
            link["refuri"] = address
            grid += nodes.paragraph("", "", link)
        place.replace_self(grid)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.add_node(Pages)
    app.add_directive("gallery", Gallery)
    app.connect("doctree-resolved", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
