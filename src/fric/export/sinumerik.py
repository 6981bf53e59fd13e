"""The target ``sinumerik``: machine data of the friction compensation at reversals, fitted to the GMS reversal.

At a reversal the compensation adds a pulse to the velocity reference of the speed controller (Siemens, SINUMERIK
840D sl, Function Manual Basic Functions, K3, friction compensation with a constant or adaptive value):

``dn(t) = dn(a)·exp(-(t - t_0)/T)``, and behind a controller K_p, K_i ``u(t) = K_p·dn·e + K_i·dn·T·(1 - e)``

with ``e = exp(-(t - t_0)/T)``: a decay of K_p/K_i turns it into a step of voltage. The amplitude follows the
acceleration at the reversal: it rises to its maximum at ACCEL1, stays until ACCEL2, falls to its minimum at ACCEL3.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from math import inf

import numpy as np

from fric.arrays import Real
from fric.contour import circularity
from fric.control.scheme import PAPER_SCHEMES
from fric.errors import FricError
from fric.estimate import Estimate, as_filed
from fric.export.base import ExportedPart, Files, Target, render
from fric.export.c import name_of
from fric.flaws.prediction import HELD_AS_PULSE
from fric.notice import Notice
from fric.reference import Reference, circle
from fric.search import simplest
from fric.simulate.axis import run_axis
from fric.simulate.contour_run import PLACES, SLOW, Chance
from fric.simulate.machine import Axis, Machine
from fric.units import rotates

RADIUS = 0.03  # Radius of the circles for the fit of the pulse [m]
FEEDS = (0.1, 0.03, 0.01)  # Feeds of these circles [m/s]: accelerations at the reversal from 0.0033 to 0.33 m/s²
WINDOW = 0.05  # Time after the fastest reversal in which the rise of friction gives the start of the search [s]
DECAYS = np.geomspace(0.004, 0.2, 12)  # Trial decays [s]
SHARES = np.array([1.0, 0.9, 1.1, 0.8, 1.2, 0.7, 1.3, 0.6, 0.5, 0.4])
"""Trial amplitudes over that of the fastest reversal's rise, nearest first, which decides ties."""
ACCURACY = 5e-9  # Accuracy of the simulated circles [m]


@dataclass(frozen=True)
class Pulse:
    """The adaptive characteristic: amplitudes [m/s] and decay [s]."""

    largest: float  # largest, smallest: amplitude between the first two accelerations, and beyond the third [m/s]
    smallest: float
    decay: float  # Time in which the pulse falls to 1/e [s]
    a_1: float  # a_1, a_2, a_3: where the amplitude has risen, begins to fall, and has fallen [m/s²]
    a_2: float
    a_3: float

    def amplitude(self, a: Real | float) -> Real:
        """Return the amplitude [m/s] at accelerations a [m/s²], of the same shape."""
        at, values = [0.0, self.a_1, self.a_2, self.a_3], [0.0, self.largest, self.largest, self.smallest]
        return np.asarray(np.interp(a, at, values))


def through_controller(part: ExportedPart, decay: float, t: Real) -> Real:
    """Return the response of the speed controller to a velocity pulse of 1 m/s [V], at times t after the reversal."""
    left = np.exp(-t / decay)
    return part.K_p * left + part.K_i * decay * (1 - left)


@lru_cache(len(FEEDS) + 1)
def _asked(feed: float, sampling: float) -> tuple[Reference, Reference]:
    """Return a circle that is simulated repeatedly."""
    return circle(RADIUS, feed, 2, sampling)


def rise_of(part: ExportedPart) -> Real:
    """Return the rise of friction after the fastest reversal, as a voltage, shape (n,)."""
    motion, _ = _asked(FEEDS[0], part.sampling)
    reversals = np.flatnonzero(np.diff(np.sign(motion.velocity)) != 0) + 1
    n = int(reversals[np.abs(motion.acceleration[reversals]) > 0.99 * FEEDS[0] ** 2 / RADIUS][-1])  # at full feed
    F = part.model.replay(motion.time, motion.position, motion.velocity)
    heading = float(np.sign(motion.velocity[n + 1]))
    return part.gain / part.K_f * heading * (F[n : n + int(WINDOW * part.sampling)] - F[n - 1])


def flat(amplitude: float, decay: float) -> Pulse:
    """Return a pulse of the same amplitude [m/s] at all `FEEDS`."""
    least, *_, most = sorted(feed**2 / RADIUS for feed in FEEDS)
    return Pulse(amplitude, amplitude, decay, 0.5 * least, 2 * most, 4 * most)


def glitches_of(axis: Axis, part: ExportedPart, advance: Callable[[], None]) -> Callable[..., float]:
    """Return a function of pulse, feed [m/s] and the encoder's place between two counts: the glitch [m] of a circle.

    Of 30 mm, by simulation, once for each: with the pulse, or, where it is None, with the friction model fed forward.
    ``advance`` is called after each.
    """

    @cache
    def left_over(pulse: Pulse | None, feed: float, place: float = axis.encoder.place) -> float:
        motion, other = _asked(feed, part.sampling)
        scheme, placed = PAPER_SCHEMES["c" if part.model.name == "gms" else "b"], axis.placed(place)
        if pulse is not None:
            scheme = replace(scheme, friction=None, blocks=("reversal-pulse",))
            at_once = replace(axis.nominal_friction, lead=0.0)
            placed = replace(placed, nominal_friction=at_once, blocks={"reversal-pulse": as_block(part, pulse)})
        run = run_axis(placed, motion, scheme, accuracy=ACCURACY)
        advance()
        quadrants = circularity(run.position, other.position, RADIUS).quadrants
        return max(abs(quadrants[0]), abs(quadrants[2]))

    return left_over


def fitted(part: ExportedPart, left_over: Callable[..., float]) -> tuple[Pulse, list[float]]:
    """Return the characteristic with the least error on the circles of `FEEDS`, and the best amplitude of each [m/s].

    By simulation. For each decay the amplitude follows from the friction model after the fastest reversal; then
    amplitudes are tried about it at each feed. The characteristic passes through the best of each, or is flat,
    whichever is better over all feeds beyond chance; ``left_over`` as of `glitches_of`.
    """
    rise = rise_of(part)
    t = np.arange(len(rise)) / part.sampling

    def begun(decay: float) -> Pulse:
        pulse = through_controller(part, decay, t)
        return flat(as_filed(max(float(pulse @ rise / (pulse @ pulse)), 0.0)), decay)

    def least(pulses: Iterable[Pulse], chance: float = 0.0) -> Pulse:
        """Return the first pulse of least sum; slow circles are skipped if fast ones already exceed it."""
        best, bound = flat(0.0, 1.0), inf
        for pulse in pulses:
            total = 0.0
            for feed in FEEDS:
                total += left_over(pulse, feed)
                if total >= bound:
                    break
            else:
                best, bound = pulse, total - chance
        return best

    best = least(map(begun, map(float, DECAYS[::-1])))  # long pulses are usual: they leave little early
    places = np.array([[left_over(best, feed, n / PLACES) for feed in FEEDS] for n in range(PLACES)])
    chance = Chance(tuple(places.sum(axis=1))).half
    tried = [flat(float(share) * best.largest, best.decay) for share in SHARES]
    alone = [
        tried[simplest([left_over(pulse, feed) for pulse in tried], Chance(tuple(each)).half)].largest
        for feed, each in zip(FEEDS, places.T, strict=True)
    ]
    plain = least(tried, chance)
    fast, middle, slow = (feed**2 / RADIUS for feed in FEEDS)
    adaptive = Pulse(max(alone), min(alone[0], max(alone)), best.decay, plain.a_1, plain.a_2, plain.a_3)
    if alone[2] < adaptive.largest:
        adaptive = replace(adaptive, a_1=min(slow * adaptive.largest / alone[2], middle))
    if alone[0] < adaptive.largest:
        adaptive = replace(adaptive, a_2=middle, a_3=fast)
    return least((plain, adaptive), chance), alone


def as_block(part: ExportedPart, pulse: Pulse) -> dict[str, float]:
    """Return the values of the block ``reversal-pulse`` that is equivalent to the machine data."""
    return {
        "slow": part.K_p * pulse.largest, "middle": part.K_p * pulse.largest, "fast": part.K_p * pulse.smallest,
        "slow_at": pulse.a_1, "middle_at": pulse.a_2, "fast_at": pulse.a_3, "decay": pulse.decay, "straight": 1.0,
        "integral": part.K_p / part.K_i if part.K_i else 0.0, "table": 0.0,
    }  # fmt: skip


def sinumerik_files(
    part: ExportedPart, *, machine: Machine, advance: Callable[[], None], instead: list[Notice]
) -> Files:
    """Return machine data as assignments, and a page with the simulated glitches; `instead` gets what they leave."""
    if rotates(part.motion):
        raise FricError("the target sinumerik is for linear axes", hint="Export to c or st.")
    left_over = glitches_of(machine.axis(part.axis), part, advance)
    pulse, alone = fitted(part, left_over)
    idle = replace(pulse, largest=0.0, smallest=0.0)
    table = []
    for feed in FEEDS:
        places = [n / PLACES for n in range(PLACES)] if feed < SLOW else [0.0]  # where it depends on these
        glitches = (tuple(left_over(by, feed, place) for place in places) for by in (idle, pulse, None))
        left = (f"{Chance(found, 0.0).text()} µm" for found in glitches)
        table.append(f"| {1e3 * feed:g} mm/s | {' | '.join(left)} |")
    pulsed, fed = (Estimate(left_over(program, FEEDS[0]), "m") for program in (pulse, None))
    instead.append(HELD_AS_PULSE.found(feed=Estimate(FEEDS[0], "m/s"), pulsed=pulsed, model=part.model.name, fed=fed))
    accelerations = np.array(FEEDS) ** 2 / RADIUS
    given = pulse.amplitude(accelerations)
    fits = list(zip(accelerations, 6e4 * np.array(alone), 6e4 * given, strict=True))  # in mm/min
    flat = float(np.ptp(given)) == 0.0
    page = render("sinumerik.md.j2", part=part, name=name_of(part), glitches=table, fits=fits, flat=flat)
    return {f"{name_of(part)}.mpf": render("sinumerik.mpf.j2", part=part, pulse=pulse), "README.md": page}


TARGET = Target(
    "sinumerik", "machine data of friction compensation at reversals", sinumerik_files,
    frozenset({"machine", "advance", "instead"}),
)  # fmt: skip
