"""A command whose options stand once each, save those that are meant to be repeated, and whose
outputs don't collide with what it reads.

Without it the last of two would win, and the first go unheard.
"""

import copy
from typing import Any

from typer.core import TyperCommand

from .collisions import FOLDERS, OUTPUTS, check_collisions
from .problems import UserError


_LIST = "LIST"  # what an option is called in the help that takes several values between commas


class Once(TyperCommand):
    """A command that refuses an option which is there twice; flags may be."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments [-], once none of their options is there twice."""
        if not ctx.resilient_parsing:
            self._check(ctx, list(args))
        rest = super().parse_args(ctx, args)
        if not ctx.resilient_parsing:
            self._check_outputs(ctx)
        return rest

    def _check_outputs(self, ctx: Any) -> None:
        outputs, filled, inputs = dict(ctx.obj or {}), [], []
        for one in self.get_params(ctx):
            value = ctx.params.get(one.name)
            if isinstance(value, str) and one.metavar in OUTPUTS:
                option = max(one.opts, key=len)
                outputs[option] = value
                if value.endswith(".zarr") or (one.metavar in FOLDERS and self.name != "export"):
                    filled.append(option)
            elif isinstance(value, str | list):
                inputs += [value] if isinstance(value, str) else map(str, value)
        flags = next((one.opts for one in self.get_params(ctx) if one.name == "overwrite"), [])
        overwrite = bool(ctx.params.get("overwrite"))
        check_collisions(inputs, outputs, filled, overwrite, min(flags, key=len, default=""))

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
