"""Exported C under hostile inputs, built with sanitizers of addresses and undefined behaviour, by both compilers."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from fric.export.base import ExportedPart
from fric.export.c import c_files
from tests.export.parts import EXPORTED, exportable, part, scheme_part, typical

CALLS = 1_000_000
WORDS = ["-O1", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
DRIVER = """
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static uint64_t seed = 88172645463325252u;
static uint64_t draw(void) {{ seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17; return seed; }}
static {real} hostile(void) {{
    static const double odd[] = {{0.0, -0.0, 1e300, -1e300, 1e12, 5e-324, 1e-12, 1.0, -1.0, 10.0, 1e30, 1e-3}};
    uint64_t what = draw() % 100, bits = draw();
    double some = (double)(int64_t)(draw() % 2000001) * 1e-6 - 1.0;
    if (what < 1) return ({real})NAN;
    if (what < 2) return ({real})(bits % 2 ? INFINITY : -INFINITY);
    if (what < 3) {{ double any; memcpy(&any, &bits, sizeof any); return fabs(any) < 3e38 ? ({real})any : 1; }}
    if (what < 5) {{ double any = odd[bits % 12]; return fabs(any) < {most} ? ({real})any : 1; }}
    return ({real})(some * pow(10.0, -(double)(bits % 9)));
}}
static {real} lasting(void) {{ return draw() % 8 ? ({real})2.5e-4 : hostile(); }}
int main(void) {{
    {name}_t self;
    {name}_reset(&self{begin});
    for (long n = 0; n < {calls}; ++n) {{
        if (self.fault || draw() % 50 == 0) {name}_reset(&self{at});
        if (draw() % 4 == 0) {{
            {real} force = {name}_friction(&self, hostile(), hostile(), lasting());
            if (!isfinite(force)) {{ printf("a force that is no number\\n"); return 2; }}
        }}
        {step}
    }}
    return 0;
}}
"""
COMPENSATION = """
        {name}_inputs_t in = {{hostile(), hostile(), hostile(), hostile(), hostile(), hostile(), hostile()}};
        {real} volts = {name}_step(&self, &in, lasting());
        if (!isfinite(volts)) {{ printf("a voltage that is no number\\n"); return 2; }}"""
MACHINE = """
        {name}_step(&self, hostile(), lasting());
        if (!isfinite(self.position)) {{ printf("a position that is no number\\n"); return 2; }}"""


def parts() -> Iterator[tuple[str, ExportedPart, bool]]:
    """Yield what is exported, by a name, and whether in single precision."""
    for single in (False, True):
        for model in exportable():
            for role in ("compensation", "machine"):
                yield f"{model}, {role}, {'single' if single else 'double'}", part(typical(model), role), single  # type: ignore[arg-type]
        for scheme in EXPORTED:
            for axis in "xy":
                made = scheme_part(scheme, axis)
                if not (single and made.blocks):  # which is refused
                    yield f"scheme {scheme} of {axis}, {'single' if single else 'double'}", made, single


def quiet(one: ExportedPart, single: bool, compiler: str, folder: Path, calls: int) -> str:
    """Run an exported part; return what a sanitizer or the driver said."""
    files = c_files(one, single=single)
    for file, text in files.items():
        (folder / file).write_text(str(text))
    (name,) = (file[:-2] for file in files if file.endswith(".c"))
    real, machine = "float" if single else "double", one.role == "machine"
    words = {"name": name, "real": real, "calls": calls, "most": "3e38" if single else "1e301"}
    step = (MACHINE if machine else COMPENSATION).format(**words)
    ends = {"begin": ", 0" if machine else "", "at": ", hostile()" if machine else ""}
    driver = folder / "driver.c"
    driver.write_text(f'#include "{name}.c"\n' + DRIVER.format(**words, **ends, step=step))
    build = [compiler, "-std=c99", *WORDS, str(driver), "-o", str(folder / "run"), "-lm"]
    made = subprocess.run(build, capture_output=True, check=False)
    assert made.returncode == 0, made.stderr.decode()
    ran = subprocess.run([folder / "run"], capture_output=True, text=True, check=False)
    return f"{ran.stdout}{ran.stderr}"[:2000] or ("" if ran.returncode == 0 else f"status {ran.returncode}")


@pytest.mark.long(300)
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_a_million_hostile_calls_of_each_part_are_quiet(compiler: str, tmp_path: Path) -> None:
    if not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")
    (tmp_path / "empty.c").write_text("int main(void) { return 0; }\n")
    empty = [compiler, *WORDS, str(tmp_path / "empty.c"), "-o", str(tmp_path / "empty")]
    if subprocess.run(empty, capture_output=True, check=False).returncode:
        pytest.skip(f"the sanitizers of {compiler} are not installed")
    found = {name: quiet(one, single, compiler, tmp_path, CALLS) for name, one, single in parts()}
    assert {name: said for name, said in found.items() if said} == {}
