import pytest

from refusing import refuses_at


@pytest.fixture
def refusal():
    """Dotted keys of the value for which `read` refuses the text of a file, in one line that begins
    with the file's name; empty for a text that is no TOML.
    """

    def refused(read, text):
        with refuses_at("t.toml: ") as error:
            read(text, "t.toml")
        return getattr(error.value, "argument", "")

    return refused
