"""Knowledge of a machine for a prediction: identified parameters and measured circles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fric.circles.measured import MeasuredCircle
from fric.circles.next_circle import LeftOver, distrusts, observers_distrust
from fric.circles.prediction import Prediction, predicted
from fric.documents.identified import IdentifiedMachine
from fric.errors import FricError
from fric.flaws.prediction import CIRCLE_UNUSED
from fric.notice import Notice
from fric.simulate.contour_run import pair
from fric.simulate.monte_carlo import MonteCarlo


@dataclass(frozen=True)
class KnownMachine:
    """The distribution that machines are drawn from, and the circles that they are fitted to."""

    identified: IdentifiedMachine  # The machine with the intervals of what was identified
    tests: Sequence[MeasuredCircle]  # Measured circles
    left: LeftOver | None  # What the machine's models leave of them; None without any
    unused: tuple[Notice, ...] = ()  # Why a circle could not be used

    @classmethod
    def of(
        cls, identified: IdentifiedMachine, tests: Sequence[MeasuredCircle], axes: Sequence[str] | None, seed: int
    ) -> KnownMachine:
        """Return the knowledge of a machine from its identified parameters and measured circles."""
        machine, left, unused = identified.machine, None, []
        for test in tests:
            try:  # one that lacks a channel still judges, and completes nothing
                names = axes or [name for name in pair(machine) if name in machine.axes]
                left = LeftOver.of([*(left.tests if left else ()), test], machine, names, seed)
            except FricError as error:
                unused.append(CIRCLE_UNUSED.found(why=str(error).replace("\n", " ")))
        return cls(identified, tests, left, tuple(unused))

    def drawn(self) -> dict[str, Any]:
        """Return the distribution that a study draws its machines from."""
        return self.identified.drawn() | {"completion": self.left}

    def prediction(self, many: MonteCarlo) -> Prediction:
        """Return the prediction for the schemes by the machines that were run, and whether to trust it."""
        study, notices = many.study, self.identified.machine.warnings
        whole = self.left(study.machine) if self.left else study.machine
        records = [record for group in self.left.records.values() for record in group] if self.left else []
        measured = [test.where for test in self.left.tests] if self.left else ()
        return predicted(
            many, widened=self.identified.widened, measured=measured,
            distrust=(*self.unused, *distrusts(whole, notices, self.tests, records, study.circle)),
            of_schemes=observers_distrust(study.schemes, notices),
        )  # fmt: skip
