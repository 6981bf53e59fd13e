"""`fric identify gms`: knots that are moved by hand."""

from typing import Any

import fric
from fric.cli.command import Command
from fric.cli.console import ERR
from fric.output import refuse_existing


def gms(command: Command, given: dict[str, Any]) -> None:
    """Identify, with ``--interactive`` by the knots that were chosen on a page."""
    if given.pop("interactive"):
        refuse_existing(given["output"], given.get("plot"), force=given["force"])
        given |= {"blocks": "auto", "knots": by_hand(given)}
    command.end(command.call(given), given)


def by_hand(given: dict[str, Any]) -> str:
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
