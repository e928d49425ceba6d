"""What a file doesn't say, and whoever reads it must: asked for in Python's words, in fields for
others.
"""

from typing import Any


class Asked(ValueError):  # noqa: N818 as `Refused`
    """A file that can't be read until something is given with it.

    - `before`, `after`: the line around what is asked for [-].
    - `argument`: of `load`, that would say it [-].
    - `role`, `value`: key and value of it, where it is a table [-].
    """

    def __init__(
        self, before: str, argument: str, role: str = "", value: str = "", after: str = ""
    ):
        """**Arguments:** the fields [-]."""
        self.before, self.argument, self.role, self.value = before, argument, role, value
        self.after = after
        python = f'{argument} {{"{role}": "{value}"}}' if role else argument
        super().__init__(f"{before}{python}{after}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.before, self.argument, self.role, self.value, self.after)
