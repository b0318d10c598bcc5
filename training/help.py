"""Help of the commands: a flag is shown without a value, which it does not take."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup, TyperOption


class Commands(TyperGroup):
    """A group of commands; its flags and theirs are shown as ``--flag`` in place of ``--flag <bool>``."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Options of the group itself."""
        return _without_values(super().get_params(ctx))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of a name; None if there is none."""
        command = super().get_command(ctx, cmd_name)
        if command is not None:
            _without_values(command.get_params(ctx))
        return command


def _without_values(params: list[Any]) -> list[Any]:
    for param in params:
        if isinstance(param, TyperOption) and param.is_bool_flag:
            param.metavar = ""
    return params
