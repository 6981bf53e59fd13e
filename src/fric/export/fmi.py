"""The target ``fmi``: co-simulation units of FMI 2.0 and 3.0 with sources, and a binary if there is a compiler."""

import platform
import shutil
import subprocess
import sys
import tempfile
import uuid
from pathlib import Path

from fric.errors import FricError
from fric.export.base import ROLES, ExportedPart, Files, Target, archived, render
from fric.export.c import c_files, c_values


def fmi_files(part: ExportedPart) -> Files:
    """Return two units of a part: NAME-fmi2.fmu and NAME-fmi3.fmu."""
    values = c_values(part)
    name = values["name"]
    plain = {str(name): str(text) for name, text in c_files(part).items()}
    made: dict[str, str | bytes] = {}
    for version in (2, 3):
        token = "{" + str(uuid.uuid5(uuid.NAMESPACE_OID, f"{version}{values['definitions']}")) + "}"
        more = values | {"guid": token}
        sources = plain | {f"{name}_fmi{version}.c": render(f"fmi{version}.c.j2", **more)}
        content = {"modelDescription.xml": render(f"fmi{version}.xml.j2", **more)}
        content |= {f"sources/{file}": text for file, text in sources.items()}
        if version == 3:
            content["sources/buildDescription.xml"] = render("fmi3_build.xml.j2", name=name)
        packed = {file: text.encode() for file, text in content.items()} | _compiled(name, sources, version)
        made[f"{name}-fmi{version}.fmu"] = archived(packed)
    return made


def _compiled(name: str, sources: dict[str, str], version: int) -> dict[str, bytes]:
    """Return a shared library for this computer by its path in a unit; none without a compiler."""
    if (compiler := shutil.which("cc")) is None or not sys.platform.startswith("linux"):
        return {}
    machine = platform.machine().replace("AMD64", "x86_64")
    folder = "linux64" if version == 2 else f"{machine}-linux"
    with tempfile.TemporaryDirectory() as place:
        for file, text in sources.items():
            (Path(place) / file).write_text(text)
        words = [compiler, "-std=c99", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", f"{name}_fmi{version}.c"]
        done = subprocess.run([*words, "-o", f"{name}.so", "-lm"], cwd=place, capture_output=True, text=True)
        if done.returncode:
            what = f"the compiler refuses the unit: {done.stderr.splitlines()[0]}"
            raise FricError(what, where=f"{name}_fmi{version}.c")
        return {f"binaries/{folder}/{name}.so": (Path(place) / f"{name}.so").read_bytes()}


TARGET = Target("fmi", "co-simulation units of FMI 2.0 and 3.0, with sources", fmi_files, parts=ROLES)
