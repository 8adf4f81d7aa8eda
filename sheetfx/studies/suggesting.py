"""What every command does with the words that it is given: suggestions, repetitions, completion."""

from __future__ import annotations

from pathlib import Path

import click
from typer.core import TyperCommand, TyperGroup

from ..scenes import meant


class Single(TyperCommand):
    """A command that refuses an option given twice, but for one that takes several values."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        order = self.make_parser(ctx).parse_args(args=list(args))[2]
        for n, parameter in enumerate(order):
            if isinstance(parameter, click.Option) and not parameter.multiple and parameter in order[:n]:
                ctx.fail(f"option {max(parameter.opts, key=len)} is given twice; leave one out")
        return super().parse_args(ctx, args)


class Suggesting(TyperGroup):
    """A group of commands that asks whether another was meant."""

    def resolve_command(self, ctx, args):
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            if self.get_command(ctx, args[0]) is None:
                known = self.list_commands(ctx)
                ctx.fail(f"no command {args[0]!r}; {meant(args[0], known)}choose one of {', '.join(known)}")
            raise error


def scripts(incomplete: str) -> list[str]:
    """Python files and folders that begin with what is typed, for completion."""
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") else typed.parent
    lead = "" if folder == Path() else f"{incomplete[:incomplete.rfind('/') + 1]}"
    if not folder.is_dir():
        return []
    found = [lead + f.name + ("/" if f.is_dir() else "") for f in folder.iterdir() if not f.name.startswith(".")
             and (f.suffix == ".py" or f.is_dir())]
    return sorted(name for name in found if name.startswith(incomplete))
