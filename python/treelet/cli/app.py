"""The commands and the options they share."""

from __future__ import annotations

from typing import Annotated

import typer
from typer.core import TyperGroup

from treelet.cli.bench import bench
from treelet.cli.build import build
from treelet.cli.compare import compare
from treelet.cli.demo import demo
from treelet.cli.errors import reported, show_tracebacks
from treelet.cli.info import info
from treelet.cli.list import list_
from treelet.cli.render import render
from treelet.cli.validate import validate

_EPILOG = "Exit codes: 0 done, 1 a check failed, 2 bad input or usage."


class _Group(TyperGroup):
    """Lets --debug stand anywhere on the line: one adds it at the end, after a command has failed."""

    def parse_args(self, ctx, args):
        if "--debug" in args:
            args = ["--debug", *(argument for argument in args if argument != "--debug")]
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=_Group,
    help="Build bounding volume hierarchies over triangle meshes, trace rays, see what a tree is worth.",
    epilog=_EPILOG,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        import treelet

        typer.echo(f"treelet {treelet.__version__}")
        raise typer.Exit()


@app.callback()
def _shared_options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_print_version, is_eager=True)
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    show_tracebacks(debug)


app.command("demo")(reported(demo))
app.command("build")(reported(build))
app.command("info")(reported(info))
app.command("validate")(reported(validate))
app.command("render")(reported(render))
app.command("bench")(reported(bench))
app.command("compare")(reported(compare))
app.command("list")(reported(list_))
