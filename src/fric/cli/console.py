"""What commands print: tables and words for people through Rich, JSON for programs, warnings on standard error."""

import codecs
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from io import TextIOWrapper
from itertools import count
from pathlib import Path
from textwrap import fill
from time import monotonic
from types import FrameType
from typing import TYPE_CHECKING, Any

from fric.errors import FricError, clean, printable
from fric.output import refuse_ending, refuse_existing, together
from fric.process import heard

if TYPE_CHECKING:
    from rich.console import Console

    from fric.results.base import Result

# Rich is imported where it is first needed: `fric --help` prints nothing through it, and it costs 50 ms.


@dataclass
class Stream:
    """Standard output or standard error, written through Rich."""

    stderr: bool  # Whether it is standard error

    @cached_property
    def console(self) -> "Console":
        """Rich's console; a file takes lines of any length."""
        from rich.console import Console

        wide = self.stderr or sys.stdout.isatty()
        return Console(stderr=self.stderr, highlight=False, soft_wrap=True, width=None if wide else 1000)

    def print(self, *things: Any, markup: bool = True, end: str = "\n") -> None:
        """Print as Rich does, with its markup or without."""
        self.console.print(*(clean(item) if isinstance(item, str) else item for item in things), markup=markup, end=end)

    def say(self, text: str, lead: str = "", style: str = "bold yellow") -> None:
        """Print a sentence behind a word; a terminal's lines break between words, but a command stays whole."""
        if lead:
            self.print(f"[{style}]{lead}[/]", end=" ")
        if self.console.is_terminal and "fric " not in text and "\n" not in text:
            room = self.console.width - len(lead) - bool(lead)
            bound = re.sub(r"(?<=\d) (?=[^\W\d]|%)", "\xa0", text)  # a number and its unit
            text = fill(bound, room, break_long_words=False, break_on_hyphens=False).replace("\xa0", " ")
        self.print(text, markup=False)


SPELLED = str.maketrans({"≤": "<=", "≥": ">=", "−": "-", "Δ": "Delta", "⁻": "-", "¹": "1", "σ": "sigma", "α": "alpha"})
"""Replacements of characters that an encoding lacks."""


def prepare_streams() -> None:
    """Allow writing to any standard output: of a narrow encoding (cp1252), or closed."""
    codecs.register_error("spelled", _spelled)
    for name in ("stdout", "stderr"):
        if (stream := getattr(sys, name)) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - it lives as long as we do
        elif isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="spelled")


def _spelled(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    text = error.object[error.start : error.end].translate(SPELLED)
    return text.encode(error.encoding, "replace").decode(error.encoding), error.end


MOST_CHARACTERS = 1000  # Characters of a warning at most
EVERY = 20.0  # Time between two lines of progress in a pipe [s]

OUT, ERR = Stream(stderr=False), Stream(stderr=True)


def finish(
    make: Callable[[Any], "Result"], output: Path | None = None, plot: Path | None = None, *, json: bool = False,
    force: bool = False, doing: str = "", also: Mapping[Path | None, Callable[[Any], Any]] | None = None,
    into: Path | None = None, writes: str = "YAML", worded: Callable[[str], str] = str,
) -> Any:  # fmt: skip
    """Make the result of a command, write and plot it, print report or JSON and the warnings; return the result.

    make: Makes the result; its argument is the progress callback.
    output, into, plot: File, or folder, that the result is saved to, and file of its figure; ``NAME=FILE`` names it.
    doing: What a progress bar says meanwhile.
    writes: Format of ``output``, as `fric.output.FORMATS` calls it.
    worded: Replaces arguments by options in a warning.
    """
    from fric.documents.base import warned
    from fric.results.base import plain, told_alone

    figures = {path: draw for path, draw in (also or {}).items() if path is not None}
    view, plot = named(plot)
    written = [path for path in (output, plot, *figures) if path is not None]
    refuse_ending(output, writes)
    for figure in (plot, *figures):
        refuse_ending(figure, "a figure")
    refuse_existing(*written, force=force)
    with progress(doing) as advance:
        result = make(advance)
    document = warned(result.warnings) | result.document if json else {}
    with together(*written) as made:
        if plot is not None:
            result.plot(plot, view=view, force=force)
            made.append(plot)
        for path, draw in figures.items():
            from fric.figures.style import save_figure

            save_figure(draw(result), path, force=force)
            made.append(path)
        for place in (output, into):
            if place is not None:
                result.save(place, force=force)
    written += [into] if into is not None else []
    if json:
        print_json(document)
    else:
        for piece in result.report():
            if isinstance(piece, str):
                OUT.say(printable(worded(piece), 10 * MOST_CHARACTERS))
            else:
                OUT.print(piece if OUT.console.is_terminal else plain([piece]), markup=False)  # a pipe without blanks
        if written:
            OUT.print(f"wrote {' and '.join(map(str, written))}", markup=False)
    for warning in told_alone(result.warnings):
        ERR.say(printable(worded(warning), MOST_CHARACTERS), warning.head)
    return result


def named(plot: Path | None) -> tuple[str | None, Path | None]:
    """Split ``NAME=FILE`` into the name of a figure and its file."""
    found = re.fullmatch(r"([a-z][a-z-]*)=(.+)", str(plot or ""))
    return (found[1], Path(found[2])) if found else (None, plot)


def print_json(document: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output."""
    import json

    text = json.dumps(document, ensure_ascii=False, indent=2, allow_nan=False)
    sys.stdout.write("".join(c if c.isprintable() or c == "\n" else json.dumps(c)[1:-1] for c in text) + "\n")


@contextmanager
def progress(description: str) -> Iterator[Any]:
    """Show a progress bar on standard error, or lines where that is no terminal; gives a function to advance it."""
    if not sys.stderr.isatty():
        from threading import Event, Thread

        start, over, done, whole, step = monotonic(), Event(), 0, 0, ""

        def tell(steps: int = 1, *, total: int | None = None) -> None:
            nonlocal done, whole
            done, whole = done + steps, total or whole

        def begin(name: str) -> None:
            nonlocal step
            step = f" ({name})" if name else step

        def tick() -> None:
            with suppress(OSError, ValueError):  # standard error may be closed meanwhile
                while not over.wait(EVERY):
                    share = f"{100 * done // whole} %, " if whole else ""
                    ERR.print(f"{description}: {share}{monotonic() - start:.0f} s{step}", markup=False)

        Thread(target=tick, daemon=True).start()
        with heard(begin), ExitStack() as ended:
            ended.callback(over.set)
            yield tell
        return
    import logging

    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn("line"), TextColumn("{task.description}"), BarColumn(20), TextColumn("{task.fields[counted]}"),
        TimeElapsedColumn(), TextColumn("{task.fields[within]}"),
    )  # fmt: skip
    with Progress(*columns, console=ERR.console, transient=True) as bar:
        task, step, trials = bar.add_task(description, total=None, within="", counted=""), "", count(1)

        def listen(begun: str) -> None:
            nonlocal step, trials
            step, trials = (f"{begun} ", count(1)) if begun else (step, trials)
            bar.update(task, within=step if begun or step.endswith("% ") else f"{step}trial {next(trials)}")

        def advance(steps: int = 1, *, total: int | None = None) -> None:
            bar.update(task, total=total, advance=steps)
            if whole := bar.tasks[task].total:
                bar.update(task, counted=f"{bar.tasks[task].completed:.0f}/{whole:.0f}")

        compiling, kernels = logging.Handler(), logging.getLogger("fric.kernels")
        compiling.emit = lambda _: bar.update(task, within="compiling, in the first run alone")  # type: ignore[method-assign, assignment]
        kernels.addHandler(compiling)
        kernels.setLevel(logging.INFO)
        _BARS.append(bar)
        try:
            with heard(listen):
                yield advance
        finally:
            _BARS.remove(bar)
            kernels.removeHandler(compiling)


_BARS: list[Any] = []  # Progress bars that are drawn


def asker(given: Mapping[str, Any]) -> Callable[[Any], None] | None:
    """Return a function that asks in the terminal; None without a terminal, or for JSON."""
    return ask if sys.stdin.isatty() and sys.stderr.isatty() and not given["json"] else None


def ask(question: Any) -> None:
    """Print a question with pictures and answers, and read the answer; Enter is the first."""
    with paused():
        lines, line = question.lines(drawn=ERR.console.encoding.lower().startswith("utf")), ""
        ERR.print("\n".join(printable(text, MOST_CHARACTERS) for text in lines), markup=False)
        while not (line and question.take(line)):
            numbers = f"1 to {len(question.choices)}, " if len(question.choices) > 1 else ""
            ERR.print("That is not an answer. " * bool(line) + f"{numbers}or Enter for 1: ", end="")
            if not (line := sys.stdin.readline()):
                ERR.print("")
                raise FricError("a question was not answered", hint="Give --assume for the likeliest meaning or --map.")


@contextmanager
def paused() -> Iterator[None]:
    """Stop the bars meanwhile."""
    for bar in _BARS:
        bar.stop()
    yield
    for bar in _BARS:
        bar.start()


class Interruption:
    """Whether Ctrl-C was pressed, or SIGTERM received."""

    status = 0  # 128 and the number of the signal, as a shell gives it

    def __call__(self) -> bool:
        """Say whether it did."""
        return self.status > 0


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Record the first Ctrl-C or SIGTERM instead of raising it; the second is raised as usual.

    An exception at an arbitrary place would leave locks held that other threads wait for.
    """
    interrupted = Interruption()
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def catch(number: int, frame: FrameType | None) -> None:
        interrupted.status = 128 + number
        for number, handler in before.items():
            signal.signal(number, handler)

    for number in before:
        signal.signal(number, catch)
    try:
        yield interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
