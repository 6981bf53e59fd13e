"""Learning of a repeated circle: round by round in simulation, or from a measured circle to the next."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from fric.circles.learn import Learned, LearnedFeedforward, Learning, circles_to_learn, learn_from
from fric.circles.learn import learn as learn_rounds
from fric.circles.measured import MeasuredCircle
from fric.documents.base import provenance
from fric.documents.bundled import located
from fric.documents.circle_findings import LearnedFeedforwardDocument, LearningDocument
from fric.documents.machine_files import read_machine
from fric.errors import FricError
from fric.io.circle import choose_circles, read_feedforward, write_feedforward
from fric.io.run import read_run_provenance, write_runs
from fric.results.base import DataFrame, Result
from fric.results.given import Advance, bounded, path_of, quantity, silent
from fric.results.kinds import CircleLike, MachineFile, Quantity, SchemeName
from fric.results.text import Piece, Table
from fric.simulate.circle import Circle
from fric.simulate.machine import Machine
from fric.units import readable
from fric.verb import Kind, verb


@dataclass(frozen=True, eq=False, repr=False)
class LearnResult(Result, schema=LearningDocument, of="found"):
    """A circle that was learned in simulation."""

    found: Learned  # The rounds

    def report(self) -> list[Piece]:
        """Return the glitch of each round, and of other circles: medians, with the chance of one run."""
        found, test = self.found, self.found.circle
        rows = [
            [
                circle.run.scheme.title,
                *(chance.text(digits=2) for chance in (*circle.run.glitches, circle.run.chance())),
            ]
            for circle in found.rounds
        ]
        title = f"{found.machine.name}: {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}; glitches in µm"
        pieces: list[Piece] = [Table(["round", "+x", "+y", "-x", "-y", "glitch"], rows, title)]
        carried = [
            [f"{readable(radius, 'm')} at {readable(feed, 'm/s')}", f"{glitch * 1e6:.2f}"]
            for radius, feed, glitch in found.carried
        ]
        return [*pieces, "", Table(["carried over to", "glitch µm"], carried)]

    def to_frame(self) -> DataFrame:
        """Return the glitch [m] by round."""
        import pandas as pd

        return pd.DataFrame({"glitch": self.found.glitches}).rename_axis("round")

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write a run file with a run for each round; its traces hold the feedforward."""
        made = json.dumps(provenance() | {"machine": self.found.machine.name})
        write_runs(Path(path), [circle.run for circle in self.found.rounds], made, force=force)


@dataclass(frozen=True, eq=False, repr=False)
class LearnedTable(Result, schema=LearnedFeedforwardDocument, of="table"):
    """The feedforward of the next round, from a measured circle."""

    table: LearnedFeedforward  # The feedforward

    def report(self) -> list[Piece]:
        """Return the feedforward by axis."""
        test = self.table.test
        rows = [[name, f"{abs(array).max():.3f}", str(len(array))] for name, array in self.table.voltage.items()]
        title = f"feedforward for {readable(test.radius, 'm')} at {readable(test.feed, 'm/s')}"
        return [Table(["axis", "largest V", "samples"], rows, title)]

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write the feedforward file."""
        write_feedforward(Path(path), self.table, json.dumps(provenance()), force=force)


@verb
def learn(
    given: Annotated[CircleLike, Kind(metavar="MACHINE.yaml|CIRCLE.h5")],
    *,
    rounds: Annotated[int | None, Kind(least=1, most=1000)] = None,
    velocity: Annotated[Quantity, "velocity"] = "100 mm/s",
    radius: Annotated[Quantity, "position"] = "30 mm",
    clockwise: bool = False,
    observer: bool = True,
    machine: MachineFile | None = None,
    before: Annotated[Path | str | None, Kind(metavar="TABLE.h5")] = None,
    scheme: SchemeName | None = None,
    share: float | None = None,
    bandwidth: Annotated[Quantity | None, "frequency"] = None,
    advance: Advance = silent,
) -> LearnResult | LearnedTable:
    """Learn the voltage to feed forward against friction on a repeated circle, without a friction model.

    With a machine all rounds are simulated, and the result is tried at another feed and radius, where it does not hold.
    With a recorded circle the result is the feedforward of the next circle.

    Parameters
    ----------
    given
        A machine; or a recorded circle. The machine file goes with ``rounds``; a circle test, or its file, with
        ``machine``.
    rounds
        In simulation: circles to learn from.
    velocity
        In simulation: feed along the circle.
    radius
        In simulation: radius of the circle.
    clockwise
        In simulation: turn clockwise.
    observer
        In simulation: switch the disturbance observer on.
    machine
        Of a circle: its machine; a run file names it. Learning uses its nominal plants.
    before
        Of a circle: the feedforward that it was run with.
    share
        Share of a round's correction to learn; by default set by the feed.
    bandwidth
        Highest frequency to learn; by default set by the feed.

    Raises
    ------
    FricError
        When a channel or the machine is missing, or there is nothing to learn from.
    """
    corner = quantity(bandwidth, "frequency")
    if rounds is not None:
        subject = read_machine(path_of("a machine file", given))
        feed = bounded("speed", velocity)
        test = Circle(bounded("radius", radius), feed, direction=-1 if clockwise else 1)
        how = Learning.at(feed, share, corner)
        advance(0, total=circles_to_learn(rounds))
        return LearnResult(learn_rounds(subject, test, rounds, how, observer=observer, done=advance))
    subject = _ran_on(given) if machine is None else read_machine(machine)
    circle = given if isinstance(given, MeasuredCircle) else choose_circles([path_of("a circle", given)], scheme)[0]
    how = Learning.at(circle.feed, share, corner)
    last = None if before is None else read_feedforward(Path(before))
    return LearnedTable(learn_from(circle, subject, how, last))


def _ran_on(given: Any) -> Machine:
    """Return the machine that a run file was simulated on; raise if the circle does not name it or its file is gone."""
    made = {} if isinstance(given, MeasuredCircle) else read_run_provenance(path_of("a circle", given))
    origin = made.get("origin")
    path, files = (origin.get("path"), origin.get("nominal_files")) if isinstance(origin, dict) else ("", ())
    if not (path and isinstance(path, str) and isinstance(files, list)):
        raise FricError("the circle does not say on which machine it was run", hint="Name it with `machine=`.")
    return read_machine(located(Path(path), "machine"), nominal_files=[str(file) for file in files])
