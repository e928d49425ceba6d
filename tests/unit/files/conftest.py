import pytest


@pytest.fixture
def refusal():
    """Error with which `read` refuses the text of a file: one line, after the file's name."""

    def line(read, text):
        with pytest.raises(ValueError, match=r"^t\.toml: ") as refused:
            read(text, "t.toml")
        message = str(refused.value)
        assert "\n" not in message and len(message) < 500
        return message.removeprefix("t.toml: ")

    return line
