import re

import pytest

from fascicle.reports import Page, data_uri, prose, quotation, verdict


SVG = b'<svg xmlns="http://www.w3.org/2000/svg"/>'


def page() -> str:
    made = Page("A <title>")
    made.heading("First", "first")
    made.paragraph("1 < 2 & `code`", "lead")
    made.points(["one", "two"])
    made.links({"down": "#first"})
    made.picture(SVG, "svg", 'a "picture"', 0.088)
    made.table(("claim", "verdict"), [("a", verdict("holds"))])
    made.files(["figure.csv"])
    return made.text("the end")


def test_text_is_escaped():
    text = page()
    assert "<h1>A &lt;title&gt;</h1>" in text
    assert "1 &lt; 2 &amp; <code>code</code>" in text
    assert 'alt="a &#34;picture&#34;"' in text


def test_no_sign_hides_wherever_it_stands():
    made = Page("a\u202e")
    made.paragraph("b\x1b\u2066")
    made.table(("c\u200b",), [("d\u202e",)])
    made.files(["gpj\u202e.exe"])
    text = made.text("e\u2069")
    for shown in (
        "a\\u202e",
        "b\\x1b\\u2066",
        "c\\u200b",
        "d\\u202e",
        "gpj\\u202e.exe",
        "e\\u2069",
    ):
        assert shown in text
    assert text.encode()


def test_nothing_is_asked_for_from_outside():
    addresses = re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', page())
    assert addresses
    assert all(re.match(r"data:|#|figure\.csv$", address) for address in addresses)
    assert not re.search(r"@import|url\(|<script", page())


def test_a_picture_is_in_its_address():
    assert data_uri(b"abc", "png") == "data:image/png;base64,YWJj"
    assert data_uri(SVG, "svg") in page()


def test_a_file_is_in_its_address_and_is_saved_under_its_name():
    made = Page("t")
    made.downloads({"a.csv": b"x,y", 'b".json': b"{}"})
    text = made.text("")
    assert '<a download="a.csv" href="data:text/csv;base64,eCx5">a.csv</a>' in text
    assert 'download="b&#34;.json" href="data:application/json;base64,e30="' in text


@pytest.mark.parametrize("word", ["holds", "differs", "fails", "chosen", "by definition"])
def test_a_verdict_has_a_sign_beside_its_color(word):
    style = word.split()[-1].replace("definition", "defined")
    assert re.fullmatch(rf'<span class="{style}">\S\xa0{word}</span>', verdict(word))


def test_a_quotation_is_escaped():
    assert quotation("a < b") == "<q>a &lt; b</q>"


def test_a_lone_backtick_stays():
    assert prose("a ` b") == "a ` b"
