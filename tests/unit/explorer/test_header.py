"""The header: what it says of a link or a file, and for how long."""

import pytest

import fascicle as fs
from fascicle.explorer.page import Header
from fascicle.explorer.state import Session, view_of
from fascicle.explorer.theme import LIGHT


@pytest.fixture
def header():
    session = Session(view_of(fs.example("kim2021_figure_6"), "kim2021_figure_6"))
    return Header(session, LIGHT)


def test_what_a_link_asked_for_in_vain_is_past_once_a_field_has_changed(header):
    header.message.show("link: `strain` can't be read.")
    header._session.change(tab="bundle")
    header._session.change(shown=dict(header._session.view.shown) | {"force": "lbf"})
    assert header.message.text
    header._session.change(strain=0.2)
    assert not header.message.text


def test_an_empty_file_is_refused(header):
    before = header._session.view
    header.file.param.update(value=None, filename="none.toml")  # as Panel tells of one
    assert "none.toml: the file is empty, 0 bytes." in header.message.text
    assert header._session.view is before


def test_a_file_is_not_saved_under_the_name_that_it_was_opened_by(header):
    assert header.save.filename == "kim2021_figure_6.toml"
    muscle = header._session.view.muscle
    for name in ("muscle.toml", "muscle_copy.toml", "my.muscle.toml", "odd name"):
        header._session.show(view_of(muscle, name))
        assert header.save.filename.endswith("_copy.toml") and header.save.filename != name
        header._session.show(view_of(muscle, f"{name}, changed"))
        assert header.save.filename.endswith("_changed.toml") and header.save.filename != name
    header._session.show(view_of(muscle, "../muscle.toml"))
    assert header.save.filename == "muscle_copy.toml"
