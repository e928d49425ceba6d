"""What can't be, told in one line and in parts: the argument, the rule, the value, what to do."""

from numbers import Number
from typing import Any


class InvalidInputError(ValueError):
    """A value that breaks a rule, for people in a line, for programs in its fields.

    - `argument`: what the value was given for [-].
    - `rule`: that it breaks, in words [-].
    - `value`: it, the first one of many, in the line's unit; `None` where there is none to show.
    - `remedy`: what to do, in words [-]; empty where the rule says it.
    """

    def __init__(
        self, argument: str, rule: str, value: Any, remedy: str = "", shown: str | None = None
    ):
        """**Arguments:**

        - `argument`, `rule`, `value`, `remedy`: the fields [-].
        - `shown`: the value in the line, with its unit [-]; left out, as Python writes it; empty
          where the rule has it already.
        """
        self.argument, self.rule, self.value, self.remedy = argument, rule, value, remedy
        if shown is None:
            # a number without NumPy's name around it
            text = str(value) if isinstance(value, Number) else repr(value)
            shown = "" if value is None else text
        space = "" if rule.startswith((",", ":")) else " "
        got = f", got {shown}" if shown else ""
        then = f": {remedy}" if remedy else ""
        text = f"`{argument}`{space}{rule}{got}{then}"
        super().__init__(text if text.endswith("?") else f"{text}.")
        self._shown = shown

    def __reduce__(self) -> tuple[Any, ...]:
        # a worker's refusal comes back whole
        return type(self), (self.argument, self.rule, self.value, self.remedy, self._shown)


Refused = InvalidInputError  # its former name, in modules not yet renamed
