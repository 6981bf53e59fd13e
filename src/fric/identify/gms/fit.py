"""An identified GMS model, the records that it was identified from, and warnings about what they do not determine."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain

import numpy as np

from fric.arrays import Mask, Real
from fric.estimate import Covariance, Estimate
from fric.flaws import blocks
from fric.flaws.channel import FIRST_BLOCK_UNRESOLVED
from fric.flaws.drift import FRICTION_DIFFERS, REST_RAISES_FRICTION
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms.virgin_curve import Blocks, Choice, HysteresisCycles, VirginCurve
from fric.notice import Notice
from fric.records.inspection import RESOLVED, cycle_energies, energy_changes, energy_per_cycle
from fric.records.prepared import Prepared
from fric.units import Motion, si_unit


@dataclass(frozen=True)
class Replay:
    """One record, measured against replayed."""

    record: Prepared  # The record as it was prepared; its ``used`` are the samples that the fit used
    replayed: Real  # The model's force along the motion, with the terms of the record [N], shape (n,)
    held_out: Mask  # Samples after the chosen cycles, which the fit did not see, shape (n,)
    own: Real  # Coefficients of the terms of the record, in the order of `Preparation.own`, shape (m,)

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.record.name

    @property
    def kind(self) -> str:
        """``presliding`` or ``sliding``."""
        return "sliding" if self.record.slides else "presliding"

    @property
    def energy(self) -> Estimate | None:
        """Energy lost per cycle [J], over all whole cycles from the first one in the fit; None in sliding."""
        if self.record.slides:
            return None
        reversals = self.record.reversals[self.record.reversals >= int(np.argmax(self.record.used))]
        return energy_per_cycle(cycle_energies(self.record.motion.position, self.record.force, reversals))

    @property
    def rmse(self) -> float:
        """Residual over the samples used [N]."""
        return self._rms(self.record.used)

    @property
    def rmse_held_out(self) -> float | None:
        """Residual over held-out samples [N]; None without any."""
        return self._rms(self.held_out) if self.held_out.any() else None

    def _rms(self, chosen: Mask) -> float:
        return float(np.sqrt(np.mean((self.record.force - self.replayed)[chosen] ** 2)))


@dataclass(frozen=True)
class GMSFit:
    """An identified GMS model, and the records that it was identified from."""

    axis: str  # axis, motion: the axis
    motion: Motion
    static: StaticMap  # The static map whose F_s is the unit of alpha; F_c = F_s at the plateau where none was given
    static_given: bool  # False where the plateau replaces a static map
    alpha: Estimate  # alpha, k, C: the parameters, one value a block in the order of slip displacements
    k: Estimate
    C: Estimate
    alpha_sum: Estimate  # Σ alpha before it was normalised: the level of the records relative to the static map
    # curve, hysteresis, blocks: the measured virgin curve, the records it is from, and the piecewise-linear fit
    curve: VirginCurve
    hysteresis: tuple[HysteresisCycles, ...]
    blocks: Blocks
    choice: Choice | None  # How the number of blocks was chosen; None where the user gave it
    asked: int | None  # Number of blocks that the user requested; None where the criterion chose it
    knots_given: bool  # knots_given, refined: true where the user gave the knots; where the parameters are from replay
    refined: bool
    records: tuple[Replay, ...]  # Each record, measured against replayed
    covariance: Covariance | None  # Covariance of the parameters; None where they were not refined by replay
    # Standard deviation of the ``level`` [1] and the ``offset`` [N] of records, where seen
    between_records: Mapping[str, Estimate]
    warnings: tuple[Notice, ...]  # Warnings: what the data do not determine

    @property
    def model(self) -> GMS:
        """The model for output: alpha sums to 1, and F_s is that of the static map."""
        assert isinstance(self.alpha.value, tuple)
        assert isinstance(self.k.value, tuple)
        return GMS(self.static, self.alpha.value, self.k.value, float(self.C))

    @property
    def rmse(self) -> float:
        """Residual over all samples used [N]."""
        rest = [(replay.record.force - replay.replayed)[replay.record.used] for replay in self.records]
        return float(np.sqrt(np.mean(np.concatenate(rest) ** 2)))

    @property
    def curve_rmse(self) -> float:
        """Misfit of the model to the measured virgin curve, over equal steps of displacement [N]."""
        z = np.linspace(0.0, float(self.curve.displacement[-1]), 501)[1:]
        level = float(self.alpha_sum) if self.static_given else 1.0
        found = Blocks(np.asarray(self.k.value), self.model.slip_displacements * level)
        return float(np.sqrt(np.mean((self.curve(z) - found(z)) ** 2)))

    @property
    def reason(self) -> str:
        """Reason for the number of blocks, in a sentence."""
        count = len(self.blocks)
        if self.choice is not None:
            return self.choice.reason
        if self.asked in {None, count}:
            return f"{count} blocks, as the user said"
        return f"{count} blocks: of the {self.asked} that were asked for, the others would have no stiffness"

    @property
    def method(self) -> str:
        """Method of identification, in a line."""
        start = (
            "concave piecewise-linear virgin curve" if self.choice or not self.knots_given else "eq. (6) at given knots"
        )
        refined = ", refined by replay of all records" if self.refined else ""
        return f"{start}{refined}; intervals by leaving out cycles, and by the repeatable misfit"


INERTIA = 0.1  # Share of inertia in the force above which a sine is too fast
HOLLOW = 0.02  # Share of F_s by which a virgin curve is below a concave curve, beyond its error, that gives a warning
LEVEL = 0.03  # Deviation of Σ alpha from 1 that gives a warning


def notices_of(fit: GMSFit, *, sliding_logged: bool, plant_given: bool) -> Iterator[Notice]:
    """Yield the warnings of a fit."""
    metre, newton, F_s = si_unit("position", fit.motion), si_unit("force", fit.motion), fit.static.F_s
    if not fit.static_given:
        yield blocks.NO_STATIC_MAP.found(F_s=Estimate(F_s, newton))
    yield from _saturation(fit, metre, newton)
    if fit.asked not in {None, len(fit.blocks)}:
        yield blocks.FEWER_BLOCKS.found(why=fit.reason)
    step = max(cycle.record.motion.step for cycle in fit.hysteresis)
    first = float(fit.model.slip_displacements[0])
    if first < RESOLVED * step:
        yield FIRST_BLOCK_UNRESOLVED.found(slip=Estimate(first, metre), step=Estimate(step, metre))
    shares = {cycle.record.name: cycle.record.done.inertia_share or 0.0 for cycle in fit.hysteresis}
    fast = {name: share for name, share in shares.items() if share > INERTIA}
    for name, share in fast.items():
        yield blocks.SINE_TOO_FAST.found(f"record '{name}'", share=share, slower=float(np.sqrt(share / INERTIA)))
    if loaded := [cycle.record.name for cycle in fit.hysteresis if cycle.loaded]:
        yield blocks.BEGINS_LOADED.found(records=loaded)
    if fit.C.assumed:
        why = (
            "pre-sliding records do not determine it"
            if not sliding_logged
            else "no static map is given"
            if not fit.static_given
            else "the fit was not refined by replay"
            if not fit.refined
            else "the sliding record does not determine it to a factor of ten (is the plant that of the log?)"
        )
        C = Estimate(float(fit.C), si_unit("force rate", fit.motion))
        yield blocks.C_ASSUMED.found(C=C, why=why, logged=sliding_logged)
    elif not plant_given:
        yield blocks.C_WITHOUT_PLANT.found()
    if fit.curve.saturates and abs(float(fit.alpha_sum) - 1.0) > LEVEL:
        yield blocks.LEVEL_DIFFERS.found(level=float(fit.alpha_sum))
    if abs(fit.curve.mismatch) > LEVEL * F_s + fit.curve.mismatch_half:
        flaw = REST_RAISES_FRICTION if fit.curve.mismatch > 0 else FRICTION_DIFFERS
        yield flaw.found(by=Estimate(abs(fit.curve.mismatch), newton))
    where, hollow = fit.curve.hollow
    if hollow > HOLLOW * F_s and not fast:  # inertia makes it hollow too
        sizes = {"slip": Estimate(where, metre), "hollow": Estimate(hollow, newton)}
        yield blocks.LOST_MOTION.found(**sizes, share=hollow / F_s)
    if len(fit.curve.cycles) < 2:
        yield blocks.ONE_CYCLE.found()
    cycled = [r for r in fit.records if r.kind == "presliding"]
    changes = (energy_changes(r.record, r.replayed, r.record.used | r.held_out) for r in cycled)
    yield from chain.from_iterable(changes)


def _saturation(fit: GMSFit, metre: str, newton: str) -> Iterator[Notice]:
    if fit.curve.saturates:
        return
    extent, end = float(fit.curve.displacement[-1]), float(fit.curve.force[-1])
    force = Estimate(end, newton)
    if not fit.static_given:
        amplitude = Estimate(3.0 * extent, metre)
        yield blocks.NEVER_SLIDES.found(force=force, names="F_s", slope=0.0, amplitude=amplitude, static=True)
        return
    amplitude = Estimate(max(1.5 * float(fit.model.slip_displacements[-1]), 2.0 * extent), metre)
    missing = Estimate(max(fit.static.F_s - end, 0.0), newton)
    found = {"extent": Estimate(extent, metre), "force": force, "missing": missing}
    yield blocks.NEVER_SATURATES.found(**found, amplitude=amplitude)
