import pytest


@pytest.fixture
def refusal():
    """Dotted keys of the value for which `read` refuses the text of a file, in one line that begins
    with the file's name; empty for a text that is no TOML.
    """

    def refused(read, text):
        with pytest.raises(ValueError, match=r"^t\.toml: .{,500}$") as error:
            read(text, "t.toml")
        return getattr(error.value, "argument", "")

    return refused
