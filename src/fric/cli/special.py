"""Functions of commands that do more than call a verb: by hand, interruptible, or of two verbs."""

import sys
from collections.abc import Container
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

import fric
from fric.cli.command import READ_MACHINE, Command, UsageError, argument, found
from fric.cli.completion import topics, types
from fric.cli.console import ERR, OUT, Interruption, asker, finish, interruption, paused, print_json
from fric.errors import FricError, printable
from fric.output import refuse_existing, written
from fric.units import rotates


def schema(
    type_name: Annotated[str, argument("friction, mapping, plant, machine, …", metavar="TYPE", autocompletion=types)],
) -> None:
    """Print the JSON Schema of a document type."""
    print_json(fric.document_schema(type_name))


def manual(
    ctx: typer.Context,
    words: Annotated[
        list[str] | None,
        argument("A page, command, word or code of a warning; else all pages.", metavar="TOPIC", autocompletion=topics),
    ] = None,
) -> None:
    """Show a page of the documentation, the help of a command, or the meaning of a warning's code."""
    from fric.documents import bundled

    topic = " ".join(words or ())
    command: Any = ctx.find_root().command
    for word in words or ():
        command = getattr(command, "get_command", lambda *_: None)(ctx, word)
    if words and command is not None:
        command.main(["--help"], prog_name=f"fric {topic}")
    if not topic:
        pages = bundled.topics()
        wide = max(map(len, pages)) + 2
        for name, path in pages.items():
            with path.open(encoding="utf-8") as file:
                title = file.readline().removeprefix("# ")
            typer.echo(f"{name:{wide}}{title}", nl=False)
        return
    if sys.stdout.isatty():
        from pydoc import pager  # costs as much as all commands' own files

        pager(bundled.page(topic))
    else:
        typer.echo(bundled.page(topic), nl=False)


READ_IDENTIFIED = "fric.documents.machine_files:read_identified"
OF_CIRCLES = ("radius", "feed", "sampling", "instrument", "scheme", "clockwise")


def auto(command: Command, given: dict[str, Any]) -> None:
    """Run all steps, with a line for each above a progress bar."""
    made = command.end(command.call(given | {"say": ERR.say, "ask": _asks(given)}), given, doing="auto")
    if getattr(made, "page", made) is None:  # nothing was identified
        raise typer.Exit(1)


def ingest(command: Command, given: dict[str, Any]) -> None:
    """Read logs or circles, write the mapping that would be guessed, or list the formats."""
    from fric.io.ingest import keep_freed_memory

    if given["list_formats"]:
        finish(lambda _: fric.formats(), json=given["json"])
        return
    if "files" not in given:
        raise UsageError("FILE is missing: name the logs to read; `fric ingest --list` lists the formats")
    if "propose" in given:
        if "output" in given:
            raise UsageError("--propose writes a mapping and reads no log: leave out -o")
        _propose(given)
        return
    if "output" not in given:
        raise UsageError("say which log file to write: -o LOG.h5")
    keep_freed_memory()
    circles = fric.holds_circles(given.get("mapping"), given.get("kind"))
    command = _by(command, given, "fric.results.ingest:ingest_circles", circles, OF_INGEST, {"kind"})
    if not circles:
        given = given | {"ask": _asks(given)}
    command.end(command.call(given), given)


OF_INGEST = "logs that are no circles", "circles (`kind='circle'`)"
OF_PLAN = "a plan of all records", "the next record after a last result (`last=`)"


def _by(
    command: Command, given: dict[str, Any], second: str, so: bool, of: tuple[str, str], but: Container[str] = (),
    **changed: Any,
) -> Command:  # fmt: skip
    """Return the command, if so by its second verb; refuse an option of the other verb, which would say nothing.

    of: What the options of the two verbs go with, in words.
    """
    other = replace(command, verb=second, **changed)
    command, other = (other, command) if so else (command, other)
    for name in other.form.names:
        if not (name in command.form.names or name in but) and given.get(name) not in (None, other.form[name].default):
            raise FricError(f"`{name}=` is for {of[not so]} alone", hint="Leave it out.")
    return command


def _asks(given: dict[str, Any]) -> Any:
    """Return what asks: the terminal, or with ``--interactive`` a page."""
    if not given.pop("interactive"):
        return asker(given)
    from fric.io.questions import Review

    return Review(_on_page, asker(given))


def _on_page(guess: Any) -> Any:
    """Serve a page to state what columns are; return what is stated."""
    from fric.report.served import ColumnsPage

    page = ColumnsPage(guess)
    with paused():
        ERR.print(f"state what the columns are at {page.address} ; Ctrl-C ends without writing", markup=False)
        return page.serve()


def _propose(given: dict[str, Any]) -> None:
    from fric.documents.listings import ProposalDocument
    from fric.io.propose import proposal

    place, text = given["propose"], proposal(given["files"], join=given["join"])
    if not (printed := place == Path("-")):
        written(place, text, force=given["force"])
    if given["json"]:
        print_json(ProposalDocument.made({"output": str(place), "mapping": text}).tree())
    else:
        OUT.print(text, markup=False)
    if not (printed or given["json"]):
        OUT.print(f"wrote {printable(str(place))}: look at it, edit it, and give it with --map", markup=False)


def plan(command: Command, given: dict[str, Any]) -> None:
    """Plan all records, or after a last result the most useful further record."""
    last = "last" in given
    command = _by(command, given, "fric.results.plan:plan_next", last, OF_PLAN, doing="candidates")
    if not last and (lacks := [f"--{name}" for name in ("stroke", "feed") if name not in given]):
        for name in given.keys() & {"stroke", "feed"}:  # a value without a unit is refused first
            found("fric.results.base:bounded")("travel-limit" if name == "stroke" else "speed", given[name])
        raise UsageError(f'say what the axis may do, as --stroke "300 mm" --feed "100 mm/s": {lacks[0]} is missing')
    command.end(command.call(given), given)


def tune(command: Command, given: dict[str, Any]) -> None:
    """Tune, and write the result before it is reported: the report names the files."""
    make = command.call(given)

    def run(advance: Any) -> Any:
        made = make(advance)
        made.save(given["output"], force=given["force"])
        return made

    if not command.end(run, given, into=None).found.improves:
        raise typer.Exit(1)


def learn(command: Command, given: dict[str, Any]) -> None:
    """Learn on a machine in simulation, or from a recorded circle."""
    simulated, machine = "rounds" in given, "machine" in given
    if simulated == machine and (simulated or given["given"].suffix != ".h5"):
        if simulated and machine:
            raise UsageError("--rounds is for a machine that is simulated, and a circle was given: leave it out")
        raise UsageError("give a machine with --rounds, or a circle with --machine")
    command.end(command.call(given), given)


def export(command: Command, given: dict[str, Any]) -> None:
    """Export, and run circles in LinuxCNC in a folder beside the files."""
    beside, doing = ({"trial": given["output"] / "trial"}, "LinuxCNC") if given["try_it"] else ({}, "export")
    command.end(command.call(given | beside), given, doing=doing)


def gms(command: Command, given: dict[str, Any]) -> None:
    """Identify a GMS model, with ``--interactive`` by the knots that were chosen on a page."""
    if given.pop("interactive"):
        refuse_existing(given["output"], given.get("plot"), force=given["force"])
        given |= {"blocks": "auto", "knots": _by_hand(given)}
    command.end(command.call(given), given)


def _by_hand(given: dict[str, Any]) -> str:
    """Serve a page to move the knots on; return them as ``--knots`` takes them, which is printed, too."""
    from fric.report.served import KnotPage

    records = fric.read(*given["logs"])
    settings = {name: given[name] for name in ("static", "plant", "cycles") if name in given}
    start = fric.identify_gms(records, blocks=given["blocks"], knots=given["knots"], refine=False, **settings)

    def again(knots: Any) -> fric.GMSResult:
        return fric.identify_gms(records, blocks="auto", knots=list(knots), refine=False, **settings)

    page = KnotPage(start, again)
    ERR.print(f"move the knots at {page.address} ; Ctrl-C ends without writing", markup=False)
    unit = "um" if not rotates(start.fit.motion) else "urad"
    chosen = ", ".join(f"{knot * 1e6:.6g} {unit}" for knot in page.serve())
    ERR.print(f"the same again: --knots '{chosen}'", markup=False)
    return chosen


def block(command: Command, given: dict[str, Any]) -> None:
    """Design a block, or list which there are."""
    from fric.control import block_type, blocks

    if given["name"] == "list":
        if given.get("output") or "plant" in given:
            raise UsageError("`list` takes nothing else: name a block to design it")
        from fric.documents.listings import BlocksDocument

        if given["json"]:
            print_json(BlocksDocument.made({"blocks": [*blocks().values()]}).tree())
            return
        for kind in blocks().values():
            linear = "linear" if kind.linear else "not linear"
            OUT.print(f"{kind.name}  {kind.kind}, {linear}; asks for: {kind.asks}")
        return
    if "plant" not in given:
        block_type(given["name"])  # an error if there is none
        raise UsageError("PLANT.yaml is missing")
    command.end(command.call(given), given)


def circle(command: Command, given: dict[str, Any]) -> None:
    """Run circles; of many machines those that are done are kept when they are interrupted."""
    many, identified = given.get("machines"), given.pop("from_intervals")
    if many is None and (identified or not given.keys().isdisjoint({"spread", "workers", "scheduler"})):
        raise UsageError("--spread, --from-intervals, --workers and --scheduler go with --monte-carlo")
    if "friction_model" in given and identified:
        raise UsageError("--friction-model does not go with --from-intervals")
    make = command.call(given, READ_IDENTIFIED if identified else READ_MACHINE)
    interrupted: list[Interruption] = []

    def run(advance: Any) -> Any:
        if many is None:
            return make(advance)
        with interruption() as asked:
            interrupted.append(asked)
            return make(advance, interrupted=asked)

    try:
        made = command.end(run, given, also={given.get("plot_reversal"): lambda made: made.reversal_figure()})
    except fric.FricError as error:
        if not any(asked() for asked in interrupted):
            raise
        ERR.print(f"interrupted: {error}", markup=False)
        raise typer.Exit(interrupted[0].status) from None
    if made.cut_short:
        ERR.print(
            f"interrupted: {len(made.many)} of {many} machines are done, and are kept: "
            f"what --monte-carlo {len(made.many)} gives"
        )
        raise typer.Exit(interrupted[0].status)


def circle_map(command: Command, given: dict[str, Any]) -> None:
    """Run circles of a map; those that are done are kept when they are interrupted."""
    make = command.call(given)
    with interruption() as asked:
        made = command.end(lambda advance: make(advance, interrupted=asked), given)
    if made.cut_short:
        raise typer.Exit(asked.status)
