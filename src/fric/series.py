"""Checks of foreign series of numbers at construction, so that consumers need none."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fric.errors import FricError
from fric.units import Motion, rotates, si_unit
from fric.verb import refused

if TYPE_CHECKING:
    from fric.arrays import Real

LARGEST: Mapping[str, float] = {"time": 1e11, "velocity": 1e6, "ratio": 1e12}  # Values in SI that no machine reaches
LINEAR, OTHERWISE = 1e6, 1e9  # The same of the position of a linear axis [m], and of dimensions `LARGEST` does not name
SMALLEST = 1e-20  # Least magnitude in SI of a measured series that is not 0 throughout
CLOSEST = 1e-9  # Least mean time between samples [s]


def largest(dimension: str, motion: Motion = "linear") -> float:
    """Return the magnitude in SI that no value of a dimension reaches on a machine."""
    return LINEAR if dimension == "position" and not rotates(motion) else LARGEST.get(dimension, OTHERWISE)


def doubles(given: Any) -> "Real | None":
    """Return numbers as doubles in a row of memory, of any shape; None where they are no real numbers.

    Compiled loops take no array that is read-only, as those of a pandas Series are, or that has gaps.
    """
    import numpy as np  # which the help of a command does without

    try:
        with np.errstate(over="ignore"):  # of a wider float, which is then no number
            other = given is None or np.ma.is_masked(given) or hasattr(given, "units")  # holes, or not in SI
            other = other or np.asarray(given).dtype.kind in "cmM"  # complex numbers or dates
            return None if other else np.require(given, np.float64, ["C", "W", "E"])
    except (TypeError, ValueError, OverflowError):
        return None


def real(given: Any, called: str, name: str) -> "Real":
    """Return numbers as `doubles` does; raise a `FricError` that names the argument where they are none."""
    if (found := doubles(given)) is None:
        raise refused(called, f"{name} as numbers", given)
    return found


def keep(holder: Any, dimensions: Mapping[str, str], where: str, *, motion: Motion = "linear", least: int = 2) -> None:
    """Keep the series of a dataclass as arrays of doubles.

    dimensions: Names of its series, and the dimension of each. An optional series that is None is left out.
    Raises FricError: Where a series is no row of numbers, is shorter than ``least`` or not as long as the others, holds
        a value that is no number or that no machine reaches, or ``time`` does not rise throughout.
    """
    found: dict[str, Real] = {}
    for name, dimension in dimensions.items():
        if (given := getattr(holder, name)) is None and getattr(type(holder), name, holder) is None:
            continue
        if given is None:
            raise FricError(f"there is no {name}", where=where, hint="Log it, or map its column.")
        if (values := doubles(given)) is None or values.ndim != 1:
            raise refused(type(holder).__name__, f"{name} as an array of numbers, shape (n,)", given)
        require_plausible(name, values, dimension, where, motion=motion)
        found[name] = values
        object.__setattr__(holder, name, values)
    lengths = {name: len(values) for name, values in found.items()}
    if len(set(lengths.values())) > 1:
        text = ", ".join(f"{name} {n}" for name, n in lengths.items())
        raise FricError(f"the columns differ in length ({text})", where=where, hint="Give each a value a sample.")
    if lengths and (n := min(lengths.values())) < least:
        raise FricError(f"has {n} values of {next(iter(lengths))}", where=where, hint=f"It needs {least} at least.")
    if "time" in found:
        require_rising(found["time"], where)


def require_plausible(name: str, values: "Real", dimension: str, where: str, *, motion: Motion = "linear") -> None:
    """Raise a `FricError` if a value is no number or beyond all machines, or all are too small (in SI units)."""
    import numpy as np

    most, unit = largest(dimension, motion), si_unit(dimension, motion)
    size = max(-values.min(), values.max()) if values.size else 0.0
    if size == 0.0 or SMALLEST <= size <= most:
        return
    n = int(np.argmin(np.abs(values) <= most))
    what = f"reaches {values.flat[n]:.3g} {unit}, which no machine does, at sample {n}"
    if not np.isfinite(values.flat[n]):
        what = f"is not a number at sample {n}"
    elif size < SMALLEST:
        what = f"stays below {size:.3g} {unit}, which nothing measures"
    hint = "Look at its unit; or ingest the log again with `bad_cells='drop'`, which leaves such samples out."
    raise FricError(f"the {name} {what}", where=where, hint=hint)


def require_rising(time: "Real", where: str) -> None:
    """Raise a `FricError` where times [s] do not rise from sample to sample, or faster than any log does."""
    import numpy as np

    steps, digit = np.diff(time), float(np.spacing(np.abs(time).max(initial=0.0)))
    least = max(CLOSEST, 4.0 * digit)
    if len(steps) and not (steps.min() >= digit and time[-1] - time[0] >= least * len(steps)):
        n = int(np.argmin(steps >= digit))
        what = f"at sample {n + 1}" if steps.min() < digit else f"by {least:.2g} s a sample (log it from 0)"
        raise FricError(f"the time does not run forward {what}", where=where, hint="Export the log again.")
