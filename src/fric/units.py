"""Units, parsed at the edge: every number inside fric is a float in SI (rad and N·m for a rotary axis).

A *dimension* is the quantity of a number (``force``, ``velocity``, …). Its SI unit depends on the motion of the
axis: a force is in N on a linear axis and a torque in N·m on a rotary axis. Where a drive logs it in another unit (A, %
    of rated, V, counts), that is the unit of all forces of the axis, without conversion to newtons: the mass is in
    A·s²/m, the force constant in A/V. Where it logs no other effort, that is its input as well, and the force constant
    is 1.
"""

import re
from collections.abc import Sequence
from functools import cache
from math import ceil, inf, isfinite, log10
from typing import TYPE_CHECKING, Any, Literal, get_args

from fric.errors import FricError, names, printable

if TYPE_CHECKING:
    import pint

Motion = Literal[
    "linear", "rotary", "linear/A", "rotary/A", "linear/%", "rotary/%", "linear/V", "rotary/V", "linear/count",
    "rotary/count", "linear/N*m", "linear/N/N", "rotary/N*m/N*m", "linear/A/A", "rotary/A/A", "linear/%/%",
    "rotary/%/%", "linear/V/V", "rotary/V/V", "linear/count/count", "rotary/count/count", "linear/N*m/N*m",
]  # fmt: skip
"""Motion of an axis, followed by a slash and the unit of its forces if the drive logs them in its units, and by another
slash and that unit where the force is the drive's input."""
MOTIONS: tuple[Motion, ...] = get_args(Motion)

SI_UNITS: dict[str, tuple[str, str]] = {  # by dimension: linear, rotary
    "time": ("s", "s"), "frequency": ("Hz", "Hz"), "position": ("m", "rad"), "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"), "force": ("N", "N*m"), "input": ("V", "V"), "angle": ("rad", "rad"),
    "ratio": ("1", "1"), "mass": ("kg", "kg*m^2"), "viscous": ("N*s/m", "N*m*s/rad"), "stiffness": ("N/m", "N*m/rad"),
    "force rate": ("N/s", "N*m/s"), "force per input": ("N/V", "N*m/V"), "rate": ("1/s", "1/s"),
    "acceleration per input": ("m/(s^2*V)", "rad/(s^2*V)"), "position per input": ("m/V", "rad/V"),
    "velocity gain": ("V*s/m", "V*s/rad"), "position gain": ("V/m", "V/rad"), "small length": ("m", "rad"),
    "energy": ("J", "J"),
}  # fmt: skip
PLAIN: tuple[Motion, ...] = ("linear", "rotary")  # Motions with forces in SI
OF_FORCE = {"force": "", "mass": "*s^2/{m}", "viscous": "*s/{m}", "stiffness": "/{m}", "force rate": "/s",
            "force per input": "/V", "energy": "*{m}"}  # fmt: skip
"""Dimensions that contain a force, with the suffix of their unit."""
OF_INPUT = {dimension for dimension, (unit, _) in SI_UNITS.items() if "V" in unit}
LARGEST_GAIN = 1e5  # Largest ratio of amplitudes that means anything of a loop: 100 dB
LARGEST_PEAK = 10.0  # Largest M_s that a loop is designed for: it is then 0.1 from the point −1
_EVERYDAY: dict[tuple[str, str], float] = {  # Common units by their SI unit, to load Pint more seldom; a test compares
    ("ms", "s"): 1e-3, ("us", "s"): 1e-6, ("µs", "s"): 1e-6, ("100 ns", "s"): 1e-7,  # of stamps of Windows
    ("kHz", "Hz"): 1e3, ("mm", "m"): 1e-3, ("um", "m"): 1e-6,
    ("µm", "m"): 1e-6, ("mm/s", "m/s"): 1e-3, ("um/s", "m/s"): 1e-6, ("µm/s", "m/s"): 1e-6, ("mN", "N"): 1e-3,
    ("kN", "N"): 1e3, ("mN*m", "N*m"): 1e-3, ("mV", "V"): 1e-3, ("N/um", "N/m"): 1e6, ("N/µm", "N/m"): 1e6,
}  # fmt: skip
MOST_LETTERS = 60  # Largest length of a unit
_STEP = re.compile(  # A drive's, as ``0.1 rpm``, ``100ns``; or a count's, as ``0.25 um``
    r"((?=[\d.]*[1-9])(?:\d{0,3}\.\d{1,9}|\d{1,9})(?= )|0?\.0{0,8}1|10{0,8})(?: |(?=[A-DF-Za-df-zµ]))([^\s\d].*)"
)
_POWER = re.compile(r"(\*\*|\^)[-+]?\d{1,2}(\.\d{1,3})?(?![\d.^]|\*\*)")  # A small exponent that has no exponent itself
_SIGNS = re.compile(r"[\w\s*/^().+\-·°%‰²³⁻¹⁺'\"]*")  # Signs of a unit; Pint passes over others, and takes $mm for mm
_SPELLED = {  # Units as headers spell them that Pint does not know
    **dict.fromkeys(["U/min", "Upm", "RPM", "min-1", "r/min", "tr/min", "giri/min", "rev/min"], "rpm"),
    "Volt": "V", "Volts": "V", **dict.fromkeys(["Sek", "Sek.", "sek"], "s"),
    **dict.fromkeys(["Arms", "Apk", "Amps", "Amp"], "A"),
}  # fmt: skip
_WRITTEN: dict[str, str] = dict(re.findall(r"(\S+)=(\S+)", (  # Units in Russian and Chinese
    "мкс=us мс=ms с=s мин=min мкм=um мм=mm см=cm м=m нм=nm кН=kN мН=mN Н=N мВ=mV В=V мА=mA А=A Гц=Hz кГц=kHz град=deg "
    "рад=rad об=rev 秒=s 毫秒=ms 微秒=us 毫米=mm 微米=um 米=m 牛=N 牛顿=N 牛米=N*m 伏=V 安=A 度=deg 转=rev"
)))  # fmt: skip
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = {  # Units that people read with a prefix, unlike others (rad, kg, N·s/m, …)
    "m", "N", "V", "s", "Hz", "m/s", "m/V", "N*m", "J", "N/m", "N*m/rad", "N/s", "N*m/s", "N*m*s/rad", "A", "A/m",
    "A/rad", "A/s", "A*s/m", "A*s/rad", "A/V",
}  # fmt: skip


def rotates(motion: str) -> bool:
    """Return whether an axis is rotary."""
    return motion.startswith("rotary")


def drive_unit(motion: str) -> str:
    """Return the drive's unit of forces; empty if they are in N or N·m."""
    return motion.partition("/")[2].partition("/")[0]


def is_effort(motion: str) -> bool:
    """Return whether the force of an axis is the input of its drive as well."""
    return motion.count("/") == 2


def of_force(motion: Motion) -> Motion:
    """Return a motion without its input: that of files of friction, which hold none."""
    unit = drive_unit(motion)
    return motion if not is_effort(motion) else next(
        name for name in MOTIONS if name in {f"{motion.partition('/')[0]}/{unit}", motion.partition("/")[0]}
        and si_unit("force", name) == unit
    )  # fmt: skip


def of_effort(motion: Motion) -> Motion:
    """Return a motion whose force is the drive's input."""
    unit = drive_unit(motion) or si_unit("force", motion)
    return next(name for name in MOTIONS if name == f"{motion.partition('/')[0]}/{unit}/{unit}")


def kinds_of(motion: Motion | None) -> tuple[Motion, ...]:
    """Return the motions that agree with a stated motion: those in the drive's units, where none is stated."""
    return tuple(
        name for name in MOTIONS if name == motion or (motion in {None, name.partition("/")[0]} and not is_effort(name))
    )


def in_units_of(motion: Motion, unit: str | None) -> Motion:
    """Return a motion with forces in the drive's unit, where the unit of a force, or of its scale, is such a unit."""
    plain = (unit or "").partition(" ")[2] if is_scale(unit or "") else unit
    return next((name for name in kinds_of(motion) if converts(plain, "force", name)), motion)


def is_scale(unit: str) -> bool:
    """Return whether a text says what a logged unit is, as ``0.1 %`` does, and is no unit, as ``1/min`` is."""
    number, _, rest = unit.partition(" ")
    return bool(rest) and number.replace("-", "").replace("+", "").replace("e", "").replace(".", "").isdigit()


def words_of(motion: str) -> str:
    """Return a motion for people: ``rotary/A`` is a rotary axis with forces in A."""
    plain, unit = motion.partition("/")[0], drive_unit(motion)
    return f"{plain} (force{' and input' * is_effort(motion)} in {unit})" if unit else plain


@cache
def si_unit(dimension: str, motion: Motion = "linear") -> str:
    """Return the SI unit of a dimension on a linear or rotary axis, as it is written in files."""
    drive = drive_unit(motion)
    if is_effort(motion) and dimension in OF_INPUT:
        return "1" if dimension == "force per input" else SI_UNITS[dimension][rotates(motion)].replace("V", drive)
    if drive and dimension in OF_FORCE:
        return drive + OF_FORCE[dimension].format(m="rad" if rotates(motion) else "m")
    return SI_UNITS[dimension][rotates(motion)]


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    import pint  # 290 ms: only when a unit is met that is not SI already

    try:
        return pint.UnitRegistry(cache_folder=":auto:")
    except OSError:  # it cannot be written; or it was made by another installation, and names files that are no more
        return pint.UnitRegistry()


@cache
def factor(unit: str, dimension: str, motion: Motion = "linear") -> float:
    """Return the factor that takes a number in ``unit`` to the SI unit of ``dimension``."""
    si = si_unit(dimension, motion)
    if unit.strip() == si:
        return 1.0
    if step := _STEP.fullmatch(unit):
        return float(step[1]) * factor(step[2], dimension, motion)
    contains = OF_FORCE.keys() | OF_INPUT if is_effort(motion) else OF_FORCE
    if dimension in contains and drive_unit(motion) in {"%", "count"}:  # a share, or a number, is of any dimension
        if dimension == "force" and unit.strip() in {"percent", "counts"}:
            return 1.0
        raise FricError(f"{dimension} cannot be in '{unit}' where it is logged in {drive_unit(motion)}",
                        hint=f"Give it in {si}.")  # fmt: skip
    if (unit.strip(), si) in _EVERYDAY:
        return _EVERYDAY[unit.strip(), si]
    registry = _registry()
    import pint

    spelled = _spelled(unit)
    try:
        if si in {"rad", "rad/s"}:
            spelled = _of_an_angle(unit, spelled, dimension)
        return float(registry.Quantity(1.0, spelled).to(si).magnitude)
    except pint.DimensionalityError:
        other: Motion = "linear" if rotates(motion) else "rotary"
        fits = registry.Quantity(1.0, spelled).check(registry.Unit(si_unit(dimension, other)).dimensionality)
        hint = f" (the axis is {motion}; is it {other}? Then say `motion: {other}`)" if fits else ""
        what = f"{dimension.removeprefix('small ')} cannot be in '{unit}': that unit measures {_measured(spelled)}"
        raise FricError(what, hint=f"Give a unit that converts to {si}{hint}.") from None
    except FricError:
        raise
    except Exception:  # as in `is_unit`: a bracket that is not closed raises Python's TokenError
        scale = f' A mapping says what one logged unit is as scale: "{unit}".' if unit[:1].isdigit() else ""
        hint = f"Give a unit that converts to {si}.{scale}"
        raise FricError(f"'{unit}' is not a unit that is known", hint=hint) from None


def converts(unit: str | None, dimension: str, motion: Motion = "linear") -> bool:
    """Return whether there is a unit, and it is a unit of a dimension."""
    if not unit:
        return False
    try:
        factor(unit, dimension, motion)
    except FricError:
        return False
    return True


def is_unit(text: str) -> bool:
    """Return whether a text is a known unit of any dimension."""
    registry = _registry()
    try:
        registry.Unit(_spelled(_STEP.sub(r"\2", text)))
    except Exception:  # Pint's parser passes on the exceptions of its tokenizer on a text that is no unit
        return False
    return bool(text.strip())


def _spelled(unit: str) -> str:
    """Spell a unit as Pint does: ``Nm`` is ``N*m``, ``U/min`` is ``rpm``; Pint evaluates powers of any size."""
    if len(unit) > MOST_LETTERS or not _SIGNS.fullmatch(unit) or re.search(r"\*\*|\^", _POWER.sub("", unit)):
        raise FricError(f"'{printable(unit, 40)}' is not a unit that is known", hint="Write it as in N*s/m or m/s^2.")
    plain = unit.strip().replace("·", "*").replace("²", "**2").replace("µ", "u").replace("μ", "u").replace("⁻¹", "**-1")
    if re.search(r"\bgrad\b", plain):
        raise FricError(f"'{unit}' is degrees in German, and gon elsewhere", hint="Write deg, or gon.")
    plain = re.sub(r"[^\W\d_a-zA-Z]+", lambda word: _WRITTEN.get(word[0], word[0]), plain)
    plain = re.sub(r"\bGra?d\b", "deg", plain)  # German degrees, which Pint takes for a thousand million radians
    plain = re.sub(r"\brevs?\b", "revolution", plain)
    return _SPELLED.get(plain, re.sub(r"\b([kmuc]?N)-?([mcu]?m)\b", r"\1*\2", plain))


def _of_an_angle(unit: str, spelled: str, dimension: str) -> str:
    """Refuse the units that would pass for radians only because an angle has no dimension."""
    if spelled in {"1/min", "min**-1"}:
        return "rpm"
    units = _registry().Quantity(1.0, spelled).units
    if "count" in str(units) or units in {_registry().Unit(u) for u in ("percent", "", "Hz", "1/s")}:
        hint = 'Write rad/s or rev/s, or give the angle of one logged unit as a scale, as in scale: "0.0879 mrad".'
        raise FricError(f"{dimension} cannot be in '{unit}': that does not say what angle it is", hint=hint)
    return spelled


def _measured(unit: str) -> str:
    """Name the dimension of a unit, for an error message: '[length]', '[mass] / [time] ** 2'."""
    dimensionality = _registry().Quantity(1.0, unit).dimensionality
    for dimension, units in SI_UNITS.items():
        for si in units:
            if si not in {"1", "rad"} and _registry().Unit(si).dimensionality == dimensionality:
                name = {"position": "length"}.get(dimension, "torque" if si == "N*m" else dimension)
                return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
    return "nothing that has a dimension" if not dimensionality else str(dimensionality)


@names
def parse(text: str | float, dimension: str, motion: Motion = "linear") -> float:
    """Parse a quantity such as ``"30 mm"`` to SI. A bare number is an error: units are explicit."""
    number, _, unit = str(text).strip().partition(" ")
    if not unit:
        unit = re.split(r"[\d.]", number)[-1]
        number = number.removesuffix(unit)
    si = si_unit(dimension, motion)
    try:
        value = float(number)
    except ValueError:
        value = None
    if value is None or not isfinite(value):
        kind = "quantity" if value is None else "finite quantity"
        raise FricError(f"'{text}' is not a {kind}", hint=f"Write a number and a unit, as in '1.5 {si}'.")
    if not unit and si != "1":
        meant = likely(number, dimension, motion)
        raise FricError(f"'{text}' has no unit", hint=f"Write the unit too, as in '{meant}'.")
    try:
        return value * (factor(unit, dimension, motion) if unit else 1.0)
    except FricError as error:
        plain = error.hint == f"Give a unit that converts to {si}."
        hint = f"Write '{likely(number, dimension, motion)}'." if plain else error.hint
        raise FricError(error.what, hint=hint) from None


_LIKELY: dict[tuple[str, Motion], tuple[tuple[str, float], ...]] = {  # Units people type, and the largest number likely
    ("position", "linear"): (("m", 1.0), ("mm", inf)),
    ("position", "rotary"): (("rad", 7.0), ("deg", inf)),
    ("small length", "linear"): (("m", 1e-4), ("mm", 0.02), ("um", inf)),  # of an encoder, a glitch
    ("small length", "rotary"): (("rad", 1e-4), ("deg", inf)),
    ("velocity", "linear"): (("m/s", 2.0), ("mm/s", 1e3), ("mm/min", inf)),
    ("velocity", "rotary"): (("rad/s", 50.0), ("deg/s", 1e3), ("rpm", inf)),
    ("acceleration", "linear"): (("m/s^2", 50.0), ("mm/s^2", inf)),
    ("time", "linear"): (("s", 0.1), ("ms", inf)),
    ("angle", "linear"): (("rad", 1.6), ("deg", inf)),
}


def likely(number: float | str, dimension: str, motion: Motion = "linear") -> str:
    """Return a number with its likely unit by the size of machines: 100 of a velocity is ``100 mm/s``."""
    units = _LIKELY.get((dimension, "rotary" if rotates(motion) else "linear"), ((si_unit(dimension, motion), inf),))
    number = number if float(number) else 1  # a size is no 0
    return f"{number} {next(unit for unit, most in units if abs(float(number)) <= most)}"


@names
def parse_gain(text: str | float, above: float = 0.0, most: float = LARGEST_GAIN) -> float:
    """Return a ratio of amplitudes: of a text in decibels, as ``"6 dB"``, or a number, which is the ratio."""
    words = str(text).strip()
    number = words[:-2] if words[-2:].lower() == "db" else words
    try:
        value = float(number)
        ratio = value if number == words else 10 ** (value / 20)
    except (ValueError, OverflowError):
        ratio = 0.0
    if ratio and isinstance(text, str) and number == words:
        raise FricError(f"'{text}' has no unit", hint=f"Write decibels, as in '{words} dB'.")
    if not above < ratio <= most * (1 + 1e-12):
        what = f"'{text}' is not a gain" + (f" above {above:g}" if above else "") + f", {most:g} at most"
        raise FricError(what, hint="Write decibels, as in '6 dB'.")
    return ratio


def prefixed(value: float, unit: str) -> tuple[float, str]:
    """Return the factor and the unit in which people read a value: ``prefixed(2.2e-5, "m") == (1e6, "µm")``."""
    shown = unit.replace("*", "·").replace("^2", "²")
    if unit not in _PREFIXED or not value or not isfinite(value):
        return 1.0, shown if isfinite(value) and unit != "1" else ""
    if unit == "N/m":  # contacts are given in N/µm
        return 1e-6, "N/µm"
    if unit == "m":  # machine tools are drawn in mm and µm
        scale, prefix = (1e-3, "m") if abs(value) >= 0.9995e-3 else (1e-6, "µ")
    else:
        scale, prefix = next(((s, p) for s, p in _PREFIXES if abs(value) >= s * 0.9995), _PREFIXES[-1])
    return 1.0 / scale, prefix + shown


def readable(value: float, unit: str, digits: int = 3) -> str:
    """Return a value for people: ``readable(2.2e-5, "m") == "22 µm"``; a dash for a value that is no number."""
    scale, shown = prefixed(float(f"{value:.{digits}g}"), unit)
    return f"{significant(value * scale, digits)} {shown}".rstrip()


def known_digits(value: float, ci95: Sequence[float | None] | None) -> int:
    """Return how many digits of a value its 95 % interval leaves: 3 where it is known to 10 %, else 2."""
    low, high = (inf if limit is None else limit for limit in ci95 or (value, value))
    return 3 if abs(high - low) < 0.2 * abs(value) or low == high == value else 2


def microns(length: float | None, digits: int = 1, sign: str = "") -> str:
    """Return a length [m] in µm: ``microns(9.13e-6) == "9.1"``; a dash for a glitch of a scheme that could not run."""
    return "–" if length is None or not isfinite(length) else f"{length * 1e6:{sign}.{digits}f}"


def significant(value: float, digits: int = 3) -> str:
    """Return a number with a given count of significant digits, without an exponent where that reads better."""
    text = f"{value:.{digits}g}" if isfinite(value) else "–"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e6 else text


def short_of_1(value: float) -> str:
    """Return a share with four digits, or with so many more that it is not shown as 1: ``0.99998``."""
    if not 0.9 < value < 1.0 - 1e-9:
        return significant(value, 4)
    return f"{value:.{max(4, ceil(-log10(1.0 - value)))}f}"
