"""The command `fric`: its groups, and how errors reach the user."""

from __future__ import annotations

import errno
import os
import signal
import sys
from types import FrameType

import typer

import fric
from fric.cli import (
    auto,
    compare,
    design,
    diagnose,
    example,
    export,
    identify,
    ingest,
    inspect,
    learn,
    manual,
    plan,
    report,
    reproduce,
    schema,
    simulate,
    tune,
    validate,
)
from fric.cli.console import ERR, prepare_streams
from fric.cli.group import Group
from fric.errors import FricError

app = typer.Typer(
    name="fric",
    cls=Group,
    help="Identify a drive's friction from its logs; see which compensation leaves how large a glitch.",
    no_args_is_help=True,
    rich_markup_mode=None,  # Rich's help costs 80 ms
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fric {fric.__version__}")
        raise typer.Exit


app.command()(auto.auto)
app.command()(ingest.ingest)
app.command()(inspect.inspect)
app.command()(report.report)
app.command()(schema.schema)
app.command()(reproduce.reproduce)
app.command()(plan.plan)
app.add_typer(design.app)
app.add_typer(identify.app)
app.command()(compare.compare)
app.command()(diagnose.diagnose)
app.command()(tune.tune)
app.command()(learn.learn)
app.command()(validate.validate)
app.add_typer(simulate.app)
app.command()(export.export)
app.command()(example.example)
app.command("help")(manual.manual)


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    pass


class _InterruptedError(BaseException):
    """Ctrl-C, or a polite kill: passes through every handler of errors, and outputs are cleaned up on its way."""


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise _InterruptedError(number)


def main() -> None:
    """Run the command line; a `FricError` is told on standard error and ends with exit status 1, Ctrl-C with 130."""
    prepare_streams()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except FricError as error:
        _tell(str(error), 1)
    except OSError as error:
        if error.filename is not None or error.errno not in _FULL:
            raise
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - nothing is flushed there at the end
        _tell(f"standard output cannot be written: {error.strerror}", 1)
    except _InterruptedError as interrupted:
        _tell("interrupted\nOutputs that were not finished are not there.", 128 + int(interrupted.args[0]))


_FULL = (errno.ENOSPC, errno.EPIPE, errno.EIO, errno.EDQUOT)


def _tell(error: str, status: int) -> None:
    try:
        ERR.print("[bold red]error:[/]", end=" ")
        ERR.print(error, markup=False)
    except OSError:  # standard error is full, too: the status is left
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    sys.exit(status)


if __name__ == "__main__":
    main()
