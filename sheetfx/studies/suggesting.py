"""What every command does with the words that it is given: suggestions, repetitions, completion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from typer.core import TyperCommand, TyperGroup

from ..scenes import meant

Resumed = Annotated[bool, typer.Option("--resume", help="Keep what is in the folder, and run what is missing.")]


@dataclass(frozen=True)
class Completed:
    """What a word may become, with the attributes that shells are told."""

    value: str
    help: str | None = None
    type: str = "plain"


class Single(TyperCommand):
    """A command that refuses an option given twice, but for one that takes several values."""

    def parse_args(self, ctx, args):
        order = self.make_parser(ctx).parse_args(args=list(args))[2]
        for n, parameter in enumerate(order):
            if parameter.param_type_name == "option" and not parameter.multiple and parameter in order[:n]:
                ctx.fail(f"option {max(parameter.opts, key=len)} is given twice; leave one out")
        return super().parse_args(ctx, args)


def with_choices(choices: Callable[[], str]) -> type[Single]:
    """A kind of command whose help ends with what can be chosen, which is looked up when help is asked for."""
    class Listing(Single):
        def format_help(self, context, formatter):
            self.epilog = choices()
            super().format_help(context, formatter)

    return Listing


class Suggesting(TyperGroup):
    """A group of commands that asks whether another was meant."""

    def resolve_command(self, ctx, args):
        known = self.list_commands(ctx)
        if not ctx.resilient_parsing and args[0] not in known and not args[0].startswith("-"):
            ctx.fail(f"no command {args[0]!r}; {meant(args[0], known)}choose one of {', '.join(known)}")
        return super().resolve_command(ctx, args)


def scripts(incomplete: str) -> list[str]:
    """Python files and folders that begin with the typed text, for completion."""
    typed = Path(incomplete)
    folder = typed if incomplete.endswith("/") else typed.parent
    lead = "" if folder == Path() else f"{incomplete[:incomplete.rfind('/') + 1]}"
    if not folder.is_dir():
        return []
    found = [lead + f.name + ("/" if f.is_dir() else "") for f in folder.iterdir() if not f.name.startswith(".")
             and (f.suffix == ".py" or f.is_dir())]
    return sorted(name for name in found if name.startswith(incomplete))
