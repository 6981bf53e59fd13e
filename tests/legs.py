"""The tests' other settings, in turns: processors, last bits, Pythons, and the oldest libraries that are allowed.

`python -m tests.legs` runs all legs, `python -m tests.legs avx2 python3.13` those, and `python -m tests.legs turn` a
sixth of the files of one: which leg and which sixth follows from the number of commits, so that 54 commits run all.
What a leg needs and this computer lacks is said, and is no failure.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
KEPT = ROOT / ".venv" / "legs"
"""Where each leg keeps what it compiles, and its environments."""
NUDGED = ("tests/identify", "tests/circles", "tests/planning", "tests/test_docs.py")
NUMERIC = ("tests/records", "tests/simulate", "tests/paper", "tests/results", *NUDGED)
"""Tests whose numbers come from fits and simulations, and those of them that a loop hangs on."""
NUDGES = range(1, 6)
PARTS = 6  # of a leg's files, of which a commit in CI runs one

WIDTHS = {"X86_V3": 2, "AVX2": 2, "FMA3": 2, "FMA4": 2, "AVX": 1, "F16C": 1}
"""The width of NumPy's vector instructions by name: 1 are AVX, 2 AVX2; what is newer than these counts as 3."""
GLIBC = {3: ("AVX512F", "AVX512VL", "AVX512BW", "AVX512DQ", "AVX512CD"), 2: ("AVX2", "FMA", "FMA4"), 1: ("AVX",)}
"""What the C library calls the instructions of a width: its sine and exponential look for them."""
PROCESSORS = {
    "avx2": ("Haswell", 2, "haswell"),
    "sandybridge": ("Sandybridge", 1, "sandybridge"),
    "old": ("Prescott", 0, "nehalem"),
}
"""BLAS' kernels, the width of instructions that is left, and what Numba compiles for."""


class Lacking(Exception):  # noqa: N818 - it is no error
    """What this computer does not have for a leg."""


def numpys(width: int) -> str:
    """Return the vector instructions of NumPy's that are wider than a width, as NPY_DISABLE_CPU_FEATURES takes them."""
    old = {"SSE", "SSE2", "SSE3", "SSSE3", "SSE41", "SSE42", "POPCNT", "X86_V2"}
    found = dict(np.show_config(mode="dicts") or {}).get("SIMD Extensions", {}).get("found", [])
    off = os.environ.get("NPY_DISABLE_CPU_FEATURES", "").split()  # which are not found, and a child would have again
    return " ".join(name for name in [*found, *off] if (0 if name in old else WIDTHS.get(name, 3)) > width)


def processor(name: str) -> dict[str, str]:
    """Return the environment in which libraries compute as on another processor."""
    if platform.machine() != "x86_64":
        raise Lacking("a processor of the kind x86-64")
    kernels, width, compiles_for = PROCESSORS[name]
    hwcaps = ",".join(f"-{one}" for wide, ones in GLIBC.items() if wide > width for one in ones)
    return {
        "OPENBLAS_CORETYPE": kernels, "NPY_DISABLE_CPU_FEATURES": numpys(width),
        "GLIBC_TUNABLES": f"glibc.cpu.hwcaps={hwcaps}", "NUMBA_CPU_NAME": compiles_for, "NUMBA_CPU_FEATURES": "",
        "NUMBA_CACHE_DIR": str(KEPT / name),
    }  # fmt: skip


def files(paths: tuple[str, ...], part: int) -> list[str]:
    """Return every sixth file of tests below some paths, in the order of their names."""
    found = [
        file for path in paths for file in ([ROOT / path] if path.endswith(".py") else (ROOT / path).rglob("test_*.py"))
    ]
    return sorted(str(file.relative_to(ROOT)) for file in found)[part::PARTS]


def numeric(paths: tuple[str, ...], settings: Callable[[], dict[str, str]], part: int | None = None) -> None:
    """Run tests of this environment's under other settings: all of some paths, or a sixth of their files."""
    environment = os.environ | {"FRIC_LONG_SECONDS": "0"} | settings()
    chosen = paths if part is None else files(paths, part)
    words = [sys.executable, "-m", "pytest", "-n", "auto", "--dist", "worksteal", *chosen]
    subprocess.run(words, cwd=ROOT, env=environment, check=True)


def interpreter(version: str) -> str:
    """Return a Python of a version that runs here, on PATH or among those of pyenv."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    kept = sorted(map(str, pyenv.glob(f"{version}.*/bin/python{version}")))
    for one in filter(None, [shutil.which(f"python{version}"), *kept]):
        if subprocess.run([one, "-c", "import venv"], capture_output=True, check=False).returncode == 0:
            return one
    raise Lacking(f"Python {version}")


def installed(name: str, version: str, *, lowest: bool = False) -> None:
    """Install the wheel for another Python, with the newest or the oldest libraries, and run the README's session."""
    folder = KEPT / name
    shutil.rmtree(folder, ignore_errors=True)
    chosen = interpreter(version)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", folder / "wheel", ROOT], check=True)
    subprocess.run([chosen, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    (wheel,) = (folder / "wheel").glob("*.whl")
    words = [str(wheel)]
    if lowest:
        project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        words += [one.replace(">=", "==") for one in project["dependencies"]]
    python = folder / "venv" / "bin" / "python"
    subprocess.run([*pip, "--python", python, "install", *words], check=True)
    environment = os.environ | {"FRIC_WHEEL_PYTHON": str(python), "NUMBA_CACHE_DIR": str(folder / "cache")}
    pytest = [sys.executable, "-m", "pytest", "-n", "0", "-m", "long", "tests/test_wheel.py"]
    subprocess.run(pytest, cwd=ROOT, env=environment, check=True)


NUMERICS: dict[str, Callable[..., None]] = {
    **{name: partial(numeric, NUMERIC, partial(processor, name)) for name in PROCESSORS},
    "threads": partial(numeric, NUMERIC, lambda: {"OMP_NUM_THREADS": "2"}),
    **{f"nudge-{n}": partial(numeric, NUDGED, partial(dict, FRIC_NUDGE=str(n))) for n in NUDGES},
}
"""Legs of numeric tests, by name, of which each has its turn; `part` takes a sixth of the files."""
LEGS: dict[str, Callable[[], None]] = NUMERICS | {
    **{f"python{one}": partial(installed, f"python{one}", one) for one in ("3.12", "3.13", "3.14")},
    "lowest": partial(installed, "lowest", "3.11", lowest=True),
}
"""What a leg does, by name."""


def commits() -> int:
    """Return how many commits lead to the one that is checked out; 0 where git does not say."""
    told = subprocess.run(["git", "rev-list", "--count", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    return int(told.stdout or 0)


def whose_turn(count: int) -> tuple[str, int]:
    """Return the leg whose turn it is after so many commits, and the sixth of its files."""
    part, leg = divmod(count, len(NUMERICS))
    return list(NUMERICS)[leg], part % PARTS


def run(legs: dict[str, Callable[[], None]]) -> dict[str, str]:
    """Run legs; return what came of each."""
    told = {}
    for name, leg in legs.items():
        print(f"== {name}", flush=True)
        try:
            leg()
            told[name] = "passed"
        except Lacking as lacking:
            told[name] = f"skipped: this computer does not have {lacking}"
        except subprocess.CalledProcessError as failed:
            told[name] = f"FAILED: {' '.join(map(str, failed.cmd[1:6]))} ended with {failed.returncode}"
    return told


def main() -> None:
    """Run the legs that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="LEG", help=f"of {', '.join(LEGS)}; turn: by the number of commits")
    legs: dict[str, Callable[[], None]] = {}
    for name in parser.parse_args().names or LEGS:
        if name == "turn":
            leg, part = whose_turn(commits())
            legs[f"{leg}, part {part + 1} of {PARTS}"] = partial(NUMERICS[leg], part=part)
        elif name in LEGS:
            legs[name] = LEGS[name]
        else:
            parser.error(f"no leg is called {name}")
    told = run(legs)
    for name, what in told.items():
        print(f"leg {name}: {what}")
    sys.exit(any(what.startswith("FAILED") for what in told.values()))


if __name__ == "__main__":
    main()
