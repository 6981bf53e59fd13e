"""The C that fric exports of a friction model, as the baseline of the compiled loops."""

from __future__ import annotations

import subprocess
from pathlib import Path

from fric.export.translate.c_code import Dialect, c_routines
from fric.export.translate.reader import Entry, read_program
from fric.friction import FrictionModel

REPLAY = """
static double step(double dz, double v, double dt, double *state, const double *parameters, int blocks)
{
    (void)blocks;
    return fric_step(dz, v, dt, state, parameters);
}

void replay(long n, const double *position, const double *velocity, const double *time, double *state,
            const double *parameters, int blocks, double *force)
{
    force[0] = step(0.0, velocity[0], 0.0, state, parameters, blocks);
    for (long i = 1; i < n; i++)
        force[i] = step(position[i] - position[i - 1], velocity[i], time[i] - time[i - 1], state, parameters, blocks);
}
"""


def write_step(model: FrictionModel, file: Path) -> None:
    """Write the exported step of a model, and a replay along a motion, as a C file."""
    entry = Entry("step", type(model).step, model.initial_state().size, model.packed().size)
    heads = "".join(f"#include <{head}.h>\n" for head in ("math", "stdbool", "stdint"))
    file.write_text(f"{heads}\n{c_routines(read_program(entry), Dialect('fric_'))}\n{REPLAY}")


def shared_library(source: Path, *, folder: Path, level: str = "-O2") -> Path:
    """Compile a C file, with the files of a folder to include, and return the library."""
    library = folder / f"{source.stem}.so"
    words = ["cc", "-std=c99", level, "-shared", "-fPIC", f"-I{folder}", str(source), "-o", str(library), "-lm"]
    subprocess.run(words, check=True)
    return library
