"""Whether a circle that was learned shows that the friction model has the wrong shape."""

from collections import defaultdict
from collections.abc import Iterable

from fric.circles.measured import MeasuredCircle
from fric.circles.next_circle import measured_glitch
from fric.control.scheme import PAPER_SCHEMES, Scheme
from fric.estimate import Estimate
from fric.flaws.circle import MODEL_SHAPE
from fric.notice import Notice

LEARNED = "learned"
"""What a scheme feeds forward that feeds forward what was learned."""
CLEARLY = 0.6
"""Share of the glitch under the best model that learning leaves at most, where that says something of the model."""


def wrong_shape(circles: Iterable[tuple[Scheme, float]]) -> list[Notice]:
    """Return that learning leaves clearly less of one circle than any model with pre-sliding, where it does.

    What is learned needs no model of friction. Where it leaves `CLEARLY` less than what a model leaves that was tuned
    to circles, the machine's friction has another shape than the model can take.

    circles: Schemes, and the glitch that each left of the circle [m].
    """
    learned, modelled = [], []
    for scheme, glitch in circles:
        if scheme.friction == LEARNED:
            learned.append(glitch)
        elif scheme.friction not in {None, "static"}:
            modelled.append(glitch)
    if not learned or not modelled or not min(learned) < CLEARLY * min(modelled):
        return []
    return [MODEL_SHAPE.found(learned=Estimate(min(learned), "m"), model=Estimate(min(modelled), "m"))]


def wrong_shape_measured(tests: Iterable[MeasuredCircle]) -> list[Notice]:
    """Return the same of measured circles, those of one radius and feed together; what was on is what they say."""
    known = {**PAPER_SCHEMES, LEARNED: Scheme(LEARNED, LEARNED, friction=LEARNED)}
    alike = defaultdict(list)
    for test in tests:
        if test.scheme in known and not test.is_ball_bar:
            alike[test.radius, test.feed].append((known[test.scheme], measured_glitch(test)))
    return [notice for circles in alike.values() for notice in wrong_shape(circles)]
