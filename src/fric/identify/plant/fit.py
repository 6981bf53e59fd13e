"""What a fit of eq. (1) to frequency responses found."""

from dataclasses import dataclass

from fric.arrays import Complex, Mask, Real
from fric.drive.plant import LinearPlant, hold_delay
from fric.estimate import Estimate
from fric.identify.plant.frequency_response import MeasuredResponse
from fric.identify.plant.response_fit import Solution
from fric.notice import Notice
from fric.units import Motion


@dataclass(frozen=True)
class ResponseFit:
    """One measured response and eq. (1) fitted to it alone.

    Parameters
    ----------
    measured
        The response.
    used
        Which of its lines were sure enough, shape (n,).
    solution
        A, ln B, T_d of this response alone.
    hold
        Sampling rate of the hold in front of the plant [Hz]; None for a continuous response.
    stand_off
        Frequencies of lines that stand off all others, and had no part in the fit [Hz].
    """

    measured: MeasuredResponse
    used: Mask
    solution: Solution
    hold: float | None
    stand_off: tuple[float, ...] = ()

    def model(self, frequency: Real) -> Complex:
        """Return the fitted response [m/V] at frequencies [Hz], shape (n,)."""
        return self.solution.response(frequency, self.hold)

    def of(self, solution: Solution, frequency: Real, *, friction: bool = True) -> Complex:
        """Return what another solution shows of this experiment [m/V], shape (n,), with friction or without."""
        values = solution.values.copy()
        values[2] = max(values[2], 0.0 if self.hold is None else hold_delay(self.hold))
        reversing = (self.measured.reversing or 0.0) if friction else 0.0
        return solution.form.response(values, frequency, self.hold, reversing)


@dataclass(frozen=True)
class FrictionInfluence:
    """What Coulomb friction adds to A: ``A_seen = A + F_c/M·gain``, its describing function along each motion.

    Parameters
    ----------
    gains
        Equivalent gain of a unit Coulomb friction along each motion [s/m], shape (r,); 0 where it never reverses.
    seen
        A fitted to each response alone [1/s], shape (r,).
    half
        Half the 95 % interval of each, shape (r,).
    differs
        Whether the responses tell of friction; False also where it could not be compared.
    compared
        Whether there were two amplitudes to compare.
    coulomb
        F_c/M [m/s²], where it was fitted.
    """

    gains: Real
    seen: Real
    half: Real
    differs: bool
    compared: bool
    coulomb: Estimate | None = None


@dataclass(frozen=True)
class PlantFit:
    """The plant of eq. (1), identified from frequency responses.

    Parameters
    ----------
    axis, motion
        Name and motion of the axis.
    estimates
        A, B, T_d, and K_f where it is known.
    solution
        The fit of all responses together.
    responses
        Each response with its own fit.
    friction
        What friction does to A.
    hold
        Sampling rate of the hold [Hz]; None for a continuous response.
    transport
        What is left of T_d without half a sample of hold [s].
    second_mass
        Frequency, ratio and damping of a table on a spring, see `fric.drive.resonance`; None where none is seen.
    warnings
        What the data cannot tell.
    """

    axis: str
    motion: Motion
    estimates: dict[str, Estimate]
    solution: Solution
    responses: tuple[ResponseFit, ...]
    friction: FrictionInfluence
    hold: float | None
    transport: Estimate
    second_mass: dict[str, Estimate] | None = None
    warnings: tuple[Notice, ...] = ()

    @property
    def plant(self) -> LinearPlant:
        """Eq. (1) without what friction adds to A."""
        return self.solution.plant()
