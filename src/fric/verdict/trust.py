"""Whether what would be exported may be trusted: what the verdict says of it, by its files and by simulated circles."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from fric.control.scheme import NONE, Scheme
from fric.errors import FricError
from fric.flaws.prediction import NOTHING_SIMULATED, SCHEME_SATURATES
from fric.notice import Notice, once
from fric.simulate.circle import Circle, run_circle
from fric.simulate.contour_run import pair
from fric.simulate.machine import Machine
from fric.verdict.decide import decide, reasons_against
from fric.verdict.evidence import Evidence, candidates_of


def trust_of(
    machine: Machine,
    name: str,
    scheme: Scheme,
    notices: Iterable[Notice],
    disagreements: Sequence[Notice] = (),
    *,
    compared: bool = False,
    drawn: Sequence[Evidence] = (),
) -> tuple[list[Notice], list[Notice]]:
    """Return what speaks against putting a scheme on an axis, and what the verdict doubts besides.

    What is wrong in the files that the machine is made of speaks against it, and a measured circle that is not as
    predicted. Where the axis is one of a circle's, the circle is simulated at 100 and at 10 mm/s: what the verdict has
    against the scheme at one of them, or a drive that saturates, does too. Besides, the verdict doubts what it has no
    machines drawn for, and no measured circle.

    machine, name, scheme: The machine, its axis, and what would be switched on.
    notices: What the files that the machine is made of say of themselves.
    disagreements, compared: Where measured circles are not as predicted; whether any was held against the machine.
    drawn: What the scheme, and none, left on machines that were drawn around this one, by circle.
    Raises FricError: When the scheme asks for what the axis does not have, or the loop with it is not stable.
    """
    given = Evidence(
        axes=(name,), resolution=machine.axis(name).encoder.resolution, compared=compared, disagreements=disagreements,
        notices=[notice for notice in notices if notice.severity == "wrong"],
    )  # fmt: skip
    try:
        on_circle = name in pair(machine)
    except FricError:
        on_circle = False
    against: list[Notice] = []
    for feed in (0.1, 0.01) if on_circle else ():
        runs = [run_circle(machine, one, Circle(feed=feed), only=name) for one in (replace(NONE, gain=None), scheme)]
        alone, with_it = candidates_of(runs)
        exact = machine.is_nominal([scheme.friction], [name])
        given = replace(given, candidates=(alone, with_it), exact=exact)
        where = f"axis {name} at {1e3 * feed:g} mm/s"
        against += [one.at(where) for one in reasons_against(with_it, given)]
        if with_it.warnings and not alone.warnings:
            against.append(SCHEME_SATURATES.found(where, how=str(with_it.warnings[0])))
    for one in drawn:
        against += reasons_against(next(c for c in one.candidates if not c.scheme.bare), one)
    reasons = [notice for one in drawn or (given,) for notice in decide(one).why]
    why = [one for one in once(reasons) if on_circle or one.code != NOTHING_SIMULATED.code]
    wrong = [one for one in why if one.severity == "wrong"]
    return list(once([*wrong, *against])), [one for one in why if one.severity != "wrong"]
