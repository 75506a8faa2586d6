"""The commands put together."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from flexdyn.checks import check_known
from flexdyn.cli import completion
from flexdyn.cli.failures import ProgramInterrupted
from flexdyn.cli.options import flag

INSTALLS = "Let the shell complete commands, options and names, from its next start on."
SHOWS = "Print what --install-completion would install."


class Commands(TyperGroup):
    """The group of all commands; an unknown one is answered with the most similar name."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command that the first argument names.

        Raises:
            InputError: there is none.
        """
        if args:
            check_known(args[0], self.commands, "no such command", value=args[0])
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that was found.

        Raises:
            ProgramInterrupted: Ctrl-C.
        """
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise ProgramInterrupted from None


def build() -> Any:
    """The click command of the whole program."""
    from flexdyn.cli.batch import batch
    from flexdyn.cli.compare import compare, compare_models
    from flexdyn.cli.diagnose import DiagnoseCommand, diagnose
    from flexdyn.cli.doctor import doctor
    from flexdyn.cli.effects import effects
    from flexdyn.cli.example import example
    from flexdyn.cli.info import info
    from flexdyn.cli.new import new
    from flexdyn.cli.paper import paper
    from flexdyn.cli.play import play
    from flexdyn.cli.plot import plot
    from flexdyn.cli.simulate import simulate

    app = typer.Typer(
        cls=Commands,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode="markdown",
        help="Simulate robot arms with elastic joints, compare them with measurements, and name missing effects.",
        epilog="Exit codes: 0 done, 2 an input is wrong (one line on stderr says which), 1 a fault of flexdyn.",
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_program)
    for command in (info, new, effects, simulate, play, plot, compare, compare_models, batch, paper, example, doctor):
        app.command()(command)
    app.command(cls=DiagnoseCommand)(diagnose)
    if completion.asked():
        from typer.completion import get_completion_inspect_parameters

        get_completion_inspect_parameters()  # lets typer answer the known shells
    return typer.main.get_command(app)


def _print_version() -> None:
    from flexdyn import __version__

    typer.echo(f"flexdyn {__version__}")


def _program(
    version: Annotated[bool, flag("--version", "Print the version and stop.", _print_version)] = False,
    install_completion: Annotated[bool, flag("--install-completion", INSTALLS, completion.install)] = False,
    show_completion: Annotated[bool, flag("--show-completion", SHOWS, completion.print_script)] = False,
) -> None:
    """Take the options that come before any command."""
