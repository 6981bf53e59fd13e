"""Units: what no drive can be, by physics, is most often a unit that was taken for another.

Each bound is generous: from a micro-tribometer (µN, or rad) to an axis of 10 t nothing real comes near it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from fric.flaws.base import Flaw

Limits = tuple[float, float]
LIFT = "`with fric.lifted():`"  # How a user accepts a value beyond the bound


@dataclass(frozen=True)
class Bound:
    """The range in which a quantity of every real drive lies."""

    what: str  # The quantity, in words
    dimension: str  # Its dimension, see `fric.units`
    linear: Limits  # Least and greatest value of a linear axis in SI
    rotary: Limits  # The same of a rotary axis
    reason: str  # Why nothing real is beyond
    units: str  # What to check


BOUNDS: Mapping[str, Bound] = {
    "speed": Bound("the speed", "velocity", (0.0, 25.0), (0.0, 2e5),
        "linear motors reach 10 m/s, the fastest spindles 1e5 rad/s", "position and time"),
    "sampling": Bound("the sampling rate", "frequency", (0.0, 5e5), (0.0, 5e5),
        "drives log and close their loops at 100 kHz at most", "the time"),
    "travel": Bound("the travel by the position over that by the velocity", "ratio", (0.2, 5.0), (0.2, 5.0),
        "both are of one motion", "position, velocity and time"),
    "following": Bound("the travel of the position over that of its reference", "ratio", (5e-3, 200.0), (5e-3, 200.0),
        "an axis goes where it is asked to, more or less", "position and reference"),
    "scale": Bound("the slope of the position over its reference, which it follows,", "ratio", (0.2, 5.0), (0.2, 5.0),
        "an angle in degrees is 57 times one in rad, an inch 25 mm", "position and reference"),
    "stroke": Bound("the longest stroke", "position", (2e-6, 1e3), (1e-6, 1e9),
        "contacts, seals and belts yield by as much before they slide, and this is a map of sliding", "the position"),
    "radius": Bound("the radius of the circle", "position", (1e-5, 10.0), (1e-5, 10.0),
        "ball bars and grids measure circles of 10 µm to 0.6 m", "the radius"),
    "travel-limit": Bound("the stroke", "position", (1e-5, 100.0), (1e-3, 1e6),
        "the longest portals travel 100 m", "the stroke"),
    "acceleration": Bound("the acceleration", "acceleration", (1e-4, 1e3), (1e-4, 1e6),
        "no axis of a machine takes 100 times the acceleration of gravity", "the acceleration"),
    "tolerance": Bound("the tolerance", "small length", (1e-10, 1e-3), (1e-10, 1e-3),
        "a glitch is below 1 mm on any machine", "the tolerance"),
    "amplitude": Bound("the amplitude of a pre-sliding sine", "position", (0.0, 5e-2), (0.0, 100.0),
        "contacts, seals and belts yield by 2 mm at most before they slide", "the position"),
    "force-per-input": Bound("force over input", "force per input", (0.0, 1e5), (0.0, 1e5),
        "10 V would make a force of 100 t", "force and input"),
    "force-constant": Bound("the force over K_f times the input", "ratio", (1 / 30, 30.0), (1 / 30, 30.0),
        "the plant's force constant says what force a voltage makes", "force, input and the plant's K_f"),
    "friction": Bound("the friction", "force", (0.0, 5e4), (0.0, 5e4),
        "10 t sliding dry on steel take 50 kN", "the force"),
    "friction-over-mass": Bound("friction over moving mass", "acceleration", (0.0, 500.0), (0.0, 3e6),
        "friction of 50 times its own weight holds no drive", "force, input and position"),
    "viscous-over-mass": Bound("viscous friction over moving mass", "rate", (0.0, 1e4), (0.0, 1e5),
        "no friction brings an axis to rest within 0.1 ms", "position and time, of the log or of the plant"),
    "inertia": Bound("inertia over the logged force", "ratio", (0.0, 10.0), (0.0, 10.0),
        "no force can give a mass ten times the acceleration that it has for it",
        "position, time, force and the plant"),
    "damping": Bound("the drive's own damping over the logged force", "ratio", (0.0, 10.0), (0.0, 10.0),
        "a drive cannot move against ten times its force", "position, time, force and the plant"),
    "level": Bound("the force of the records over F_s of the static map", "ratio", (5e-3, 20.0), (5e-3, 20.0),
        "both are of one axis", "the force of either log"),
    "stribeck": Bound("v_s", "velocity", (0.0, 125.0), (0.0, 1e6),
        "the force falls from F_s to F_c at speeds that an axis reaches", "the velocity"),
    "viscous": Bound("the viscous friction", "viscous", (0.0, 1e12), (0.0, 1e12),
        "at 1 µm/s it would take the force of 100 t", "the force and the velocity"),
    "scatter-level": Bound("the scatter of friction between records", "ratio", (0.0, 20.0), (0.0, 20.0),
        "all records are of one axis", "the force"),
    "scatter-offset": Bound("the scatter of the offset between records", "force", (0.0, 5e4), (0.0, 5e4),
        "10 t sliding dry on steel take 50 kN", "the force"),
    "scatter-mass": Bound("the scatter of the mass between records", "mass", (0.0, 1e5), (0.0, 1e5),
        "axes weigh up to 100 t, what turns with them included", "force, input and position"),
    "slip": Bound("the travel up to sliding", "position", (0.0, 5e-3), (0.0, 10.0),
        "contacts, seals and belts yield by 2 mm at most before they slide", "the position"),
    "stiffness": Bound("the stiffness", "stiffness", (0.0, 5e10), (0.0, 1e10),
        "a guideway of 10 t yields by more than 50 N per nm, and so does a bar of steel", "force and position"),
    "mass": Bound("the moving mass K_f/B", "mass", (1e-7, 1e5), (1e-13, 1e5),
        "axes weigh from below a gram to 100 t, what turns with them included", "force, input and position"),
    "B": Bound("B", "acceleration per input", (1e-5, 1e5), (1e-4, 1e8),
        "{falls:what pushes counts the other way|a unit of input gives an axis between a millionth and ten "
        "thousand times the acceleration of gravity}",
        "input, position and time"),
    "A": Bound("A", "rate", (0.0, 1e5), (0.0, 1e5),
        "{falls:friction falls with speed, or a sign is turned|no mass comes to rest within 10 µs}",
        "position and time"),
    "T_d": Bound("T_d", "time", (0.0, 0.25), (0.0, 0.25), "no servo loop closes over a quarter second", "the time"),
}  # fmt: skip

IMPLAUSIBLE: Mapping[str, Flaw] = {  # Their mend is of the error: a warning has another, or none
    name: Flaw(
        f"implausible-{name}", "wrong", f"{bound.what} is {{value}}: {bound.reason}.",
        f"Look at the units of {bound.units}; where it is so, say {LIFT}.",
    )
    for name, bound in BOUNDS.items()
}  # fmt: skip
UNUSUAL: Mapping[str, Flaw] = {
    name: Flaw(
        f"unusual-{name}", "doubt", f"{BOUNDS[name].what} is {{value}}, and few machines are below {{usual}}.",
        f"Is the unit of {BOUNDS[name].units} right? If it is, lift the bound by {LIFT}.",
    )
    for name in ("friction", "speed", "sampling")
}  # fmt: skip
