"""What some commands do around their verbs, beside what the table says: by hand, interrupted, or of two verbs."""

from typing import Any

import typer

import fric
from fric.cli.command import READ_MACHINE, Command
from fric.cli.console import ERR, OUT, Interruption, interruption
from fric.output import refuse_existing

READ_IDENTIFIED = "fric.documents.identified:read_identified"


def gms(command: Command, given: dict[str, Any]) -> None:
    """Identify a GMS model, with ``--interactive`` by the knots that were chosen on a page."""
    if given.pop("interactive"):
        refuse_existing(given["output"], given.get("plot"), force=given["force"])
        given |= {"blocks": "auto", "knots": _by_hand(given)}
    command.end(command.call(given), given)


def _by_hand(given: dict[str, Any]) -> str:
    """Serve a page to move the knots on; return them as ``--knots`` takes them, which is printed, too."""
    from fric.report.knots import KnotPage

    records = fric.read(*given["logs"])
    settings = {name: given[name] for name in ("static", "plant", "cycles") if name in given}
    start = fric.identify_gms(records, blocks=given["blocks"], knots=given["knots"], refine=False, **settings)

    def again(knots: Any) -> fric.GMSResult:
        return fric.identify_gms(records, blocks="auto", knots=list(knots), refine=False, **settings)

    page = KnotPage(start, again)
    ERR.print(f"move the knots at {page.address} ; Ctrl-C ends without writing", markup=False)
    unit = "um" if start.fit.motion == "linear" else "urad"
    chosen = ", ".join(f"{knot * 1e6:.6g} {unit}" for knot in page.serve())
    ERR.print(f"the same again: --knots '{chosen}'", markup=False)
    return chosen


def block(command: Command, given: dict[str, Any]) -> None:
    """Design a block, or list which there are."""
    if given["name"] == "list":
        from fric.control import blocks

        for kind in blocks().values():
            linear = "linear" if kind.linear else "not linear"
            OUT.print(f"{kind.name}  {kind.kind}, {linear}; asks for: {kind.asks}")
        return
    if "plant" not in given:
        raise typer.BadParameter("PLANT.yaml is missing")
    command.end(command.call(given), given)


def circle(command: Command, given: dict[str, Any]) -> None:
    """Run circles; of many machines those that are done are kept when they are interrupted."""
    many, identified = given.get("machines"), given.pop("from_intervals")
    if many is None and (identified or not given.keys().isdisjoint({"spread", "workers", "scheduler"})):
        raise typer.BadParameter("--spread, --from-intervals, --workers and --scheduler go with --monte-carlo")
    if "measured" in given and not identified:
        raise typer.BadParameter("--measured goes with --monte-carlo and --from-intervals")
    if "friction_model" in given and identified:
        raise typer.BadParameter("--friction-model does not go with --from-intervals")
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
