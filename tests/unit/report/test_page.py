import re

import pytest
from jinja2 import UndefinedError

from fascicle.report.page import Picture, data_uri, downloads, prose, render


SVG = b'<svg xmlns="http://www.w3.org/2000/svg"/>'
TEMPLATE = """{% extends "page.html" %}
{% from "macros.html" import downloads, picture, points, table %}
{% block body %}
<p class="lead">{{ text | prose }}</p>
{{ points([text]) }}
{{ picture(image, 'a "picture"') }}
{{ table(("claim", text), [(text, verdict("holds"))]) }}
{{ downloads(files) }}
{% endblock %}
"""


@pytest.fixture
def page(tmp_path):
    (tmp_path / "test.html").write_text(TEMPLATE)

    def fill(text):
        files = downloads({"a.csv": b"x,y", 'b".json': b"{}"})
        image = Picture(data_uri(SVG, "svg"), 88)
        return render("test.html", tmp_path, title=text, text=text, image=image, files=files)

    return fill


def test_text_is_escaped(page):
    html = page("1 < 2 & `code`")
    assert "<h1>1 &lt; 2 &amp; `code`</h1>" in html
    assert html.count("1 &lt; 2 &amp; <code>code</code>") == 2
    assert 'alt="a &#34;picture&#34;"' in html
    assert prose("a ` b") == "a ` b"


def test_invisible_characters_are_escaped_everywhere(page):
    html = page("a\u202eb\x1bc\u200b")
    assert html.count("a\\u202eb\\x1bc\\u200b") == 6
    assert html.encode()


def test_a_page_loads_nothing_from_outside(page):
    html = page("t")
    addresses = re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', html)
    assert addresses
    assert all(address.startswith("data:") for address in addresses)
    assert not re.search(r"@import|url\(|<script", html)
    assert data_uri(SVG, "svg") in html
    assert '<a download="a.csv" href="data:text/csv;base64,eCx5">a.csv</a>' in html
    assert 'download="b&#34;.json" href="data:application/json;base64,e30="' in html


def test_a_missing_value_is_an_error(page):
    with pytest.raises(UndefinedError):
        render("design.html", title="t")
