"""Completion by the shell: the options that install it, and the words for arguments."""

from __future__ import annotations

import os
from pathlib import Path

import typer

from flexdyn.errors import InputError

VARIABLE = "_FLEXDYN_COMPLETE"
"""Set by the shell when it asks for words."""
SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")


def asked() -> bool:
    """Whether this process was started by a shell to complete a word."""
    return VARIABLE in os.environ


def install() -> None:
    """Write the script for the running shell to the place where that shell reads it.

    Raises:
        InputError: the shell is not known.
    """
    from typer._completion_shared import install as write

    shell, path = write(shell=_shell("--install-completion"), prog_name="flexdyn", complete_var=VARIABLE)
    typer.echo(f"completion for {shell} is installed in {path}; it works in the next terminal")


def print_script() -> None:
    """Print the script.

    Raises:
        InputError: the shell is not known.
    """
    from typer._completion_shared import get_completion_script

    shell = _shell("--show-completion")
    typer.echo(get_completion_script(prog_name="flexdyn", complete_var=VARIABLE, shell=shell))


def models(incomplete: str) -> list[str]:
    """Names of shipped models and known robots; if none fits, the shell completes files."""
    from flexdyn.model.model_file import shipped_models
    from flexdyn.robot import robot_names

    return [name for name in sorted({*shipped_models(), *robot_names()}) if name.startswith(incomplete)]


def effect_names(incomplete: str) -> list[str]:
    """Names of effects."""
    from flexdyn.effects import catalogue

    return [name for name in catalogue() if name.startswith(incomplete)]


def examples(incomplete: str) -> list[str]:
    """Names of examples."""
    from flexdyn.cli.examples import EXAMPLES

    return [name for name in EXAMPLES if name.startswith(incomplete)]


def _shell(option: str) -> str:
    """The shell that runs this process, else the user's own."""
    try:
        import shellingham

        name = str(shellingham.detect_shell()[0])
    except Exception:  # no parent shell, or no such library
        name = Path(os.environ.get("SHELL", "")).name
    if name not in SHELLS:
        remedy = f"run it in one of {', '.join(SHELLS)}"
        raise InputError("the shell is not known", key=option, value=name or None, remedy=remedy)
    return name
