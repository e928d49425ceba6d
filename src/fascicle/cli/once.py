"""A command whose options stand once each, save those that are meant to be repeated.

Without it the last of two would win, and the first go unheard.
"""

import copy
from typing import Any

from typer.core import TyperCommand

from .problems import UserError


_LIST = "LIST"  # what an option is called in the help that takes several values between commas


class Once(TyperCommand):
    """A command that refuses an option which is there twice; flags may be."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments [-], once none of their options is there twice."""
        if not ctx.resilient_parsing:
            self._check(ctx, list(args))
        return super().parse_args(ctx, args)

    def _check(self, ctx: Any, args: list[str]) -> None:
        params = self.get_params(ctx)
        single = [one for one in params if one.param_type_name == "option" and _single(one)]
        # read as if all of them could be repeated: then none of their values is lost
        parser = type(self.make_parser(ctx))(ctx)
        for one in params:
            read = copy.copy(one)
            if one in single:
                read.multiple = True
            read.add_to_parser(parser, ctx)
        given, _, _ = parser.parse_args(args=args)
        for one in single:
            refuse_repeated(max(one.opts, key=len), given.get(one.name), one.metavar == _LIST)


def refuse_repeated(option: str, values: Any, listed: bool) -> None:
    """Refuse more than one of the `values` [-] of an `option` [-]; `listed`: whether it takes a
    list [-].
    """
    if not isinstance(values, list) or len(values) < 2:
        return
    often = "twice" if len(values) == 2 else f"{len(values)} times"
    remedy = f"give one list, {','.join(values)}" if listed else "give it once"
    raise UserError(f"{option} is there {often}: {remedy}.")


def _single(option: Any) -> bool:
    return not (option.multiple or option.is_flag or option.count)
