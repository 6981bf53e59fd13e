"""How sure what circles say of friction and plant is."""

from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.circles.nominal import parameters
from fric.circles.tune_bootstrap import recorded_again
from fric.circles.tune_fit import Fitted
from fric.circles.tune_identifiability import merged
from fric.circles.tune_instruments import Instruments, whole
from fric.circles.tuned import TunedEstimates
from fric.circles.voltage import COMPARED
from fric.drive.plant import Plant
from fric.estimate import Covariance, Estimate, Interval
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.identify.plant.covariance import score_covariance
from fric.records.resolution import lattice_step

STEP = 1e-4
SEEN = 0.08
"""Share of an encoder's step to which the slip of a block is known."""
OPEN = 20.0
"""Half of an interval of a logarithm from which on the data set no limit."""
UNITS = {"F_c": "N", "F_s": "N", "v_s": "m/s", "delta": "1", "sigma": "N*s/m", "alpha": "1", "k": "N/m", "C": "N/s"}


def tuned_estimates(found: Fitted, plant: Plant) -> TunedEstimates:
    """Return what was found with intervals: of the noise, however it hangs together, and of what the encoder shows.

    found: The fit. Of what it kept of the shape only the covariance of its coordinates depends.
    plant: The plant that it found.
    """
    left = recorded_again(found)
    coordinates = _covariance(found, left)[: len(found.x), : len(found.x)]
    found = whole(found)
    covariance = _covariance(found, left)
    names = found.balance.coordinates.names
    p = len(names)
    quantile = float(stdtrit(len(left), 0.975))
    slope, labels = _logarithms(found)
    spread = slope @ covariance @ slope.T
    # blocks that slip alike are told apart by nothing but where they were found: what tells of each where they do not
    wide, at_one = spread, merged(found)
    if at_one is not None:
        wide = slope @ _covariance(at_one, left) @ slope.T
    half = quantile * np.sqrt(np.maximum(np.maximum(np.diag(spread), np.diag(wide)), 0.0))
    halves = dict(zip(labels, half, strict=True))

    def within(name: str, value: float) -> Interval:
        ratio = float(np.exp(halves[name])) if halves[name] < OPEN else np.inf
        return value / ratio, value * ratio

    values = parameters(found.balance.coordinates.friction(found.x))
    fitted = {name for name, width in halves.items() if width > 1e-9}
    sections: dict[str, Estimate] = {}
    for name, value in values.items():
        if isinstance(value, tuple):
            keys = [f"{name}_{n}" for n in range(1, len(value) + 1)]
            known = any(key in fitted for key in keys)
            limits = tuple(within(key, one) for key, one in zip(keys, value, strict=True))
            sections[name] = Estimate(value, UNITS[name], limits if known else None, fixed=not known)
        else:
            known = name in fitted
            sections[name] = Estimate(value, UNITS[name], within(name, value) if known else None, fixed=not known)
    offsets, K_f = found.plant[2:], found.balance.K_f
    error = quantile * float(np.sqrt(covariance[p + 2, p + 2] / len(offsets) + np.var(offsets))) * K_f
    load = float(np.mean(offsets)) * K_f
    static = {name: sections[name] for name in STATIC_PARAMETERS}
    negative = None
    if side := found.balance.coordinates.sides(found.x):
        wider = (
            quantile * float(np.sqrt(covariance[names.index("side"), names.index("side")])) / 2
            if "side" in names
            else 0
        )
        sided = [
            {
                name: _scaled(one, sign * side / 2, wider) if name in ("F_c", "F_s") else one
                for name, one in static.items()
            }
            for sign in (1, -1)
        ]
        static, negative = sided[0], sided[1]
    static["offset"] = Estimate.around(load, "N", error)
    gms = {name: sections[name] for name in ("alpha", "k", "C")}
    of_plant = {
        "A": Estimate(plant.A, "1/s", within("A", plant.A) if plant.A > 0 else None),
        "B": Estimate(plant.B, "m/(s^2*V)", within("B", plant.B)),
        "T_d": Estimate(plant.T_d, "s", within("T_d", plant.T_d)),
        "K_f": Estimate(plant.K_f, "N/V", fixed=True),
    }
    of_friction = [n for n, label in enumerate(labels) if label not in ("A", "B", "T_d") and label in fitted]
    joint = Covariance.of([labels[n] for n in of_friction], spread[np.ix_(of_friction, of_friction)], "log")
    return TunedEstimates(static, negative, gms, of_plant, joint, coordinates)


def _scaled(one: Estimate, shift: float, wider: float) -> Estimate:
    """Return an estimate times e to the power of a shift, its interval wider by a share."""
    value = float(one) * float(np.exp(shift))
    if one.ci95 is None:
        return replace(one, value=value)
    low, high = (float(limit) * float(np.exp(shift)) for limit in np.ravel(one.ci95))
    return replace(one, value=value, ci95=(low * (1 - wider), high * (1 + wider)))


def _covariance(about: Fitted, left: list[Real]) -> Real:
    """Return the covariance of coordinates and plant, shape (p + 2 + circles,) square.

    Samples are thinned to four a period of the filter's corner: between them nothing new is told. Scores hang together
    (Newey and West), and the priors are off by what they allow. To that comes what the encoder shows.

    about: The fit, or a point beside it, whose derivatives count.
    left: What circles leave that are recorded again.
    """
    instruments = Instruments.of(about)
    weighed = instruments.weights * about.residual
    rows, residuals, lengths, start = [], [], [], 0
    for record, part in zip(about.balance.records, about.parts(), strict=True):
        every = max(int(record.rate / (8 * COMPARED)), 1)
        chosen = slice(start, start + len(part), every)
        # as many samples fewer weigh as much more
        rows.append(np.sqrt(every) * instruments.Z[chosen])
        residuals.append(np.sqrt(every) * weighed[chosen])
        lengths.append(len(residuals[-1]))
        start += len(part)
    Z = np.vstack(rows)
    scale = np.linalg.norm(Z, axis=0)
    scale[scale == 0] = 1.0
    scores = np.outer(scale, scale) * score_covariance(Z / scale, np.concatenate(residuals), lengths)
    scores += np.diag(instruments.power * instruments.prior)
    errors = _beyond(about, left) * np.array([instruments.error(one) for one in left])
    covariance = instruments.solved(instruments.solved(scores).T) + errors.T @ errors / len(errors)
    p = len(about.x)
    covariance[:p, :p] += np.diag(_of_the_encoder(about))
    return np.asarray(covariance)


def _beyond(about: Fitted, left: list[Real]) -> float:
    """Return how many times what repeats of the residual exceeds what circles leave that are recorded again.

    Least 1. What is more is no encoder of this step: its ripple, or friction of another shape, and errs as much more.
    """
    again = float(np.sqrt(np.mean([replace(about, residual=one).rms ** 2 for one in left])))
    repeats = max(about.rms**2 - (about.noise() or 0.0) ** 2, 0.0) ** 0.5
    return max(1.0, repeats / again) if again > 0 else 1.0


def _of_the_encoder(found: Fitted) -> Real:
    """Return variances of the stiffnesses' logarithms, shape (p,): a slip is as long as the encoder tells it."""
    coordinates = found.balance.coordinates
    model = coordinates.friction(found.x)
    step = max(lattice_step(record.raw[2]) or 0.0 for record in found.balance.records)
    variances = np.zeros(len(coordinates.names))
    shares = [SEEN * step * k / (alpha * model.static.F_s) for alpha, k in zip(model.alpha, model.k, strict=True)]
    for n, name in enumerate(coordinates.names):
        if name == "stiffness":
            variances[n] = shares[int(np.argmax(model.k))] ** 2
        elif name.startswith("k_"):
            variances[n] = shares[int(name[2:]) - 1] ** 2
    return variances


def _logarithms(found: Fitted) -> tuple[Real, list[str]]:
    """Return derivatives of the parameters' logarithms by coordinates and plant, and the parameters' names."""
    coordinates, p = found.balance.coordinates, len(found.x)
    total = p + len(found.plant)

    def all_of(x: Real, linear: Real) -> Real:
        model = parameters(coordinates.friction(x))
        flat = np.concatenate([np.atleast_1d(np.asarray(value, float)) for value in model.values()])
        m, a = linear[:2]
        tail = [max(a / m, 1e-12), 1 / m, coordinates.delay(x)]
        return np.log(np.maximum(np.concatenate([flat, tail]), 1e-300))

    here = all_of(found.x, found.plant)
    slope = np.zeros((len(here), total))
    for n in range(p):
        moved = found.x.copy()
        moved[n] += STEP
        slope[:, n] = (all_of(moved, found.plant) - here) / STEP
    for n in range(2):
        step = STEP * max(abs(found.plant[n]), 1e-9)
        linear = found.plant.copy()
        linear[n] += step
        slope[:, p + n] = (all_of(found.x, linear) - here) / step
    labels = []
    for name, value in parameters(coordinates.friction(found.x)).items():
        labels += [f"{name}_{n}" for n in range(1, len(value) + 1)] if isinstance(value, tuple) else [name]
    return slope, [*labels, "A", "B", "T_d"]
