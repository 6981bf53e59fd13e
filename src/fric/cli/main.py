"""The command `fric`: its groups, and how errors reach the user."""

import errno
import gc
import os
import re
import signal
import sys
import warnings
from types import FrameType
from typing import Any

import typer

import fric
from fric.cli.command import EXAMPLES, UsageError, command_of, group
from fric.cli.commands import COMMANDS
from fric.cli.console import ERR, MOST_CHARACTERS, prepare_streams
from fric.errors import FricError, near, of_path, printable, reworded
from fric.process import now

app = group(
    "fric", "Identify a drive's friction from its logs, and compare the glitch under each compensation.", COMMANDS,
    add_completion=True, context_settings={"help_option_names": ["-h", "--help"]},
)  # fmt: skip


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fric {fric.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    pass


OBJECTS = 100_000  # New objects after which garbage is looked for: at the usual 700 imports, without any, take 0.1 s


class _InterruptedError(BaseException):
    """Ctrl-C or SIGTERM: passes through every handler of errors, so that outputs are cleaned up."""


HELD = ("numba", "llvmlite")
"""Libraries that no exception out of nowhere may strike: it is lost in a finalizer or a callback of theirs, ends in
another error where compiled code asked for what is unpickled, or frees memory twice."""
_STRUCK: list[int] = []  # Signals that were raised: a library written in C that one strikes may end in a SystemError
AGAIN = 0.01  # After which time an interrupt that struck one of them is tried again [s]


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise where that is safe; else let a timer ask again."""
    while frame is not None:
        if frame.f_code.co_name == "__del__" or frame.f_globals.get("__name__", "").partition(".")[0] in HELD:
            signal.signal(signal.SIGALRM, lambda _, later: _interrupt(number, later))
            signal.setitimer(signal.ITIMER_REAL, AGAIN)
            return
        frame = frame.f_back
    _STRUCK.append(number)
    raise _InterruptedError(number)


COMMAS = "Several values of an option are written with commas, as 'a,b'"


def main() -> None:
    """Run the command line; a `FricError` is told on standard error and ends with exit status 1, Ctrl-C with 130."""
    gc.set_threshold(OBJECTS)
    prepare_streams()
    os.environ.pop("MPLBACKEND", None)  # figures are saved, not shown, and a name that is none ends Matplotlib
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # what libraries say of their own code; of data fric warns itself
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)
    try:
        try:
            now()  # Matplotlib would end at one that is none
            sys.exit(app(standalone_mode=False))
        except UsageError as error:
            _end_of_usage(error)
        finally:
            sys.stdout.flush()
            gc.freeze()  # the process ends: no garbage is looked for once more
    except FricError as error:
        place = sys.argv.index(error.where) if error.where in sys.argv[3:] else 2
        second = sys.argv[place - 2].startswith("--") and not os.path.exists(error.where)  # value of an option
        _fail(f"{error} {COMMAS}." if second else str(error), 1)
    except OSError as error:
        if error.filename is None and error.errno == errno.ENOENT:
            _fail("the folder that this was started in is not there any more\nChange to another.", 1)
        if isinstance(found := of_path(error), FricError):
            _fail(str(found), 1)
        if error.filename is not None or error.errno not in _FULL:
            raise
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - nothing is flushed there at the end
        _fail(f"standard output cannot be written: {error.strerror}\nSend it to another file or disk.", 1)
    except (_InterruptedError, SystemError):
        if not _STRUCK:
            raise
        _fail("interrupted\nOutputs that were not finished are not there.", 128 + _STRUCK[-1])


def _end_of_usage(error: Any) -> None:
    """Print what is wrong in a command line, in its words, or the help of a group without a command."""
    message = reworded(error.message)
    if type(error).__name__ == "NoArgsIsHelpError":  # a group alone: its help, as it is
        sys.stderr.write(f"{message}\n")
        sys.exit(error.exit_code)
    if message.startswith("Got unexpected extra"):
        message += f". {COMMAS}"
    if hasattr(error, "possibilities") and error.ctx.parent is None:
        error.possibilities, message = None, f"{message}. Options of a command follow its name"
    given, *choices = (re.findall("'(.*?)'", text) or [text] for text in message.split(" is not one of "))
    use = getattr(getattr(error, "param", None), "help", None)
    if choices:
        use, message = None, f"{message} {near(given[-1], choices[0])}".rstrip()
    error.message = printable(": ".join(filter(None, (message, use))), MOST_CHARACTERS)
    if not message and (known := EXAMPLES.get(command_of(error.ctx))):
        error.message += f"\nExample: fric {known[0]}"
    error.show()
    sys.exit(error.exit_code)


_FULL = (errno.ENOSPC, errno.EFBIG, errno.EPIPE, errno.EIO, errno.EDQUOT)


def _fail(error: str, status: int) -> None:
    try:
        what, *more = error.split("\n", 2)
        ERR.say(what, "error:", "bold red")
        for text in more:  # the hint, and a form
            ERR.say(text)
    except OSError:  # standard error is full, too: the status is left
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    sys.exit(status)


if __name__ == "__main__":
    main()
