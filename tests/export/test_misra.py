"""cppcheck's addon for MISRA C:2012 has no findings in exported C, and finds those of a bad file."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from fric.export.c import c_files
from tests.export.parts import DIRECTED, exportable, part, scheme_part, typical

pytestmark = pytest.mark.skipif(not shutil.which("cppcheck"), reason="cppcheck is not installed")

BAD = """
#include <stdlib.h>
int f(int a) { int *p = malloc(4); if (a) return 1; *p = a; goto end; end: return p ? 07 : a++ + a; }
"""


def _findings(*files: Path) -> list[str]:
    words = ["cppcheck", "--addon=misra", "--std=c99", "--enable=style", "--quiet", "--template={id} {file}:{line}"]
    done = subprocess.run([*words, *map(str, files)], capture_output=True, text=True, check=True)
    return [line for line in done.stderr.splitlines() if line.startswith("misra") and "use_" not in line]


def test_the_checker_finds_what_a_bad_file_does(tmp_path: Path) -> None:
    (tmp_path / "bad.c").write_text(BAD)
    assert len({line.split()[0] for line in _findings(tmp_path / "bad.c")}) >= 8


@pytest.mark.parametrize(
    "names", [["static"], pytest.param(exportable(), marks=pytest.mark.long(15))], ids=["static", "all"]
)
def test_exported_c_has_no_findings(names: list[str], tmp_path: Path) -> None:
    # in single precision, and as a machine beside the compensation, only one of each kind: the structure is the same
    users = []
    for single in (False, True):
        named = ["gms"] if single else names
        made = [part(typical(name)) for name in named]
        made += [part(typical(name), "machine") for name in named if name == "gms" or name in DIRECTED]
        for n, one in enumerate(
            [*made, scheme_part("c" if single else "f")]
        ):  # each an axis of its own, for names are compared too
            for name, text in c_files(replace(one, axis=f"a{n}{single:d}"), single=single).items():
                (tmp_path / name).write_text(str(text))
                if name.endswith(".c"):
                    users.append(_user(name[:-2], one.role, "float" if single else "double"))
    (tmp_path / "use_all.c").write_text("".join(users))
    assert _findings(*tmp_path.rglob("*.c")) == []


def _user(name: str, role: str, real: str) -> str:
    """A program that calls all that is exported: a function that nobody calls from outside would be a finding."""
    step = f"{name}_inputs_t in = {{0}};\n    {real} v = {name}_step(&self, &in, 0);"
    if role == "machine":
        step = f"{name}_step(&self, 0, 0);\n    {real} v = self.position;"
    return f"""#include "{name}.h"
{real} use_{name}(void);
{real} use_{name}(void)
{{
    {name}_t self;
    {name}_reset(&self{", 0" if role == "machine" else ""});
    {step}
    return v + {name}_friction(&self, 0, 0, 0);
}}
"""
