"""The target ``linuxcnc``: HAL components, and their wiring."""

from math import pi

from fric.export.base import ROLES, ExportedPart, Files, Target, identifier, render
from fric.export.c import c_files, c_values
from fric.units import rotates

COMPONENTS = {"compensation": "ff", "machine": "plant"}  # Ends of names, so that halcompile's C file is not the part's
JOINTS = {"x": 0, "y": 1, "z": 2, "a": 3, "b": 4, "c": 5}


def linuxcnc_files(part: ExportedPart) -> Files:
    """Return the component of a part with its C source; for compensation also the wiring and a page."""
    values = c_values(part)
    component = f"fric_{identifier(part.axis)}_{COMPONENTS[part.role]}"
    joint, scale = JOINTS.get(part.axis.lower(), 0), repr(pi / 180 if rotates(part.motion) else 1e-3)
    more = values | {"component": component, "joint": joint, "scale": scale}
    files = dict(c_files(part)) | {f"{component}.comp": render(f"{part.role}.comp.j2", **more)}
    if part.role == "compensation":
        files |= {f"{values['name']}{end}": render(f"axis{end}.j2", **more) for end in (".hal", ".ini")}
        files["README.md"] = render("linuxcnc.md.j2", **more)
    return files


TARGET = Target("linuxcnc", "a HAL component, its wiring and settings", linuxcnc_files, parts=ROLES)
