"""Exported compensation on exported axes, driven by a real LinuxCNC: its planner, its PID, its threads.

LinuxCNC runs without a screen and without realtime. What makes a session the same from run to run: each arc starts from
rest behind a dwell, and a gate holds axes and compensation on the command until an arc moves. The plant computes in
sub-steps of nominal length, so that the jitter of the computer does not enter.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fric.contour import Circularity, circularity
from fric.errors import FricError
from fric.export.base import Files
from fric.export.linuxcnc import COMPONENTS, linuxcnc_files
from fric.export.rendering import identifier, render
from fric.export.select import compensation_of, machine_of
from fric.reference import Reference
from fric.simulate.axis import run_axis
from fric.simulate.contour_run import pair

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.control.scheme import Scheme
    from fric.simulate.machine import Machine

TAIL = 200
"""Periods for which a record goes on after an arc."""
SECONDS = 400.0
"""After which a session is ended."""
NOBODY = "65534"
"""User and group under which LinuxCNC runs, where fric runs as root: LinuxCNC refuses root."""


@dataclass(frozen=True)
class Arc:
    """One arc in LinuxCNC, and the same loop simulated along the reference that LinuxCNC's planner gave.

    Parameters
    ----------
    scheme
        What was switched on.
    feed
        Speed along the arc [m/s].
    direction
        1 counter-clockwise, -1 clockwise.
    measured, simulated
        What was left of the circle, in LinuxCNC and by simulation.
    """

    scheme: Scheme
    feed: float
    direction: int
    measured: Circularity
    simulated: Circularity

    @property
    def difference(self) -> float:
        """The largest difference of a quadrant's glitch between both [m]."""
        return max(abs(a - b) for a, b in zip(self.measured.quadrants, self.simulated.quadrants, strict=True))


def trial_schemes(scheme: Scheme) -> list[Scheme]:
    """Return what a trial of a scheme switches on: nothing, its feedforward, and all of it."""
    made = [replace(scheme, name="none", title="none", friction=None, blocks=())]
    ahead = tuple(b.name for b in scheme.block_types if b.kind == "feedforward")
    if scheme.blocks != ahead and scheme.feeds_forward:
        made.append(replace(scheme, name="feedforward", title="feedforward", blocks=ahead))
    return [*made, scheme]


def bench_files(machine: Machine, scheme: Scheme, feeds: Sequence[float], radius: float) -> Files:
    """Return the files of a bench: components of both axes, configuration, program, and what runs it.

    Raises
    ------
    FricError
        When the machine has no two axes for a circle, or something cannot be exported.
    """
    names = pair(machine)
    rate = machine.axis(names[0]).cascade.sampling
    files: dict[str, str | bytes] = {}
    axes = []
    for name in names:
        axis = machine.axis(name)
        for part in (compensation_of(machine, name, scheme), machine_of(machine, name)):
            files |= {f: text for f, text in linuxcnc_files(part).items() if f.endswith((".c", ".h", ".comp"))}
        made = f"fric_{identifier(name)}_"
        axes.append(
            {
                "name": identifier(name),
                "K_v": axis.cascade.K_v,
                "K_p": axis.cascade.K_p / 1e3,
                "K_i": axis.cascade.K_i / 1e3,
                "limit": min(axis.cascade.limit, 1e6),
                "plant": made + COMPONENTS["machine"],
                "compensation": made + COMPONENTS["compensation"],
            }
        )  # fmt: skip
    fastest, edge = max(feeds), radius / sqrt(2)
    values = {
        "axes": axes, "machine": machine.name, "tail": TAIL, "period_ns": round(1e9 / rate), "reach": 1e3 * radius * 4,
        "speed": f"{2e3 * fastest:.9g}", "acceleration": f"{6e3 * fastest**2 / radius + 1e3 * fastest * 10:.9g}",
        "radius": f"{1e3 * radius:g}", "start": repr(-1e3 * edge), "offset": repr(1e3 * edge),
        "circles": [(f"{feed * 6e4:.9g}", 2 if feed > 0.05 else 1) for feed in feeds],
    }  # fmt: skip
    for file in ("bench.ini", "bench.hal", "fric_arc.comp", "circle.ngc", "session.py"):
        files[file] = render(f"bench/{file}.j2", **values)
    return files | {"bench.tbl": "", "bench.var": ""}


def require_linuxcnc() -> None:
    """Raise a `FricError` where LinuxCNC is not installed, or its components may not be."""
    for word, package in (("linuxcnc", "linuxcnc-uspace"), ("halcompile", "linuxcnc-uspace-dev")):
        if shutil.which(word) is None:
            raise FricError(f"a trial needs {word}, which is not installed", hint=f"apt-get install {package}.")
    if os.geteuid() != 0:
        raise FricError(
            "a trial installs components into LinuxCNC's own folder, which needs root", hint="Run it with sudo."
        )


def try_in_linuxcnc(
    machine: Machine,
    scheme: Scheme,
    folder: Path,
    *,
    feeds: Sequence[float] = (0.1, 0.01),
    radius: float = 0.03,
    advance: Callable[[], None] = lambda: None,
) -> list[Arc]:
    """Run circles in LinuxCNC with a scheme switched on by and by, and the same loops in simulation.

    Parameters
    ----------
    machine
        The machine: its axes are the plant, its controllers' beliefs the compensation.
    scheme
        What is exported.
    folder
        Where the bench is written and its records are left.
    feeds, radius
        Speeds [m/s] and radius [m] of the circles; each is run clockwise and counter-clockwise.
    advance
        Called after each session.

    Raises
    ------
    FricError
        When LinuxCNC is not installed, a component does not build, a session fails, or rows of its record are lost.
    """
    require_linuxcnc()
    for name, content in bench_files(machine, scheme, feeds, radius).items():
        file = folder / name
        file.write_text(content) if isinstance(content, str) else file.write_bytes(content)
    for component in sorted(folder.glob("*.comp")):
        done = subprocess.run(["halcompile", "--install", component.name], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            text = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr[-200:])
            raise FricError(f"halcompile refuses the component: {text}", where=str(component))
    chosen = trial_schemes(scheme)

    def session(one: Scheme) -> list[Arc]:
        trace = _recorded(machine, one, scheme, folder)
        arcs = _arcs(machine, one, trace, feeds, radius)
        advance()
        return arcs

    with ThreadPoolExecutor(2) as pool:
        return [arc for arcs in pool.map(session, chosen) for arc in arcs]


def _recorded(machine: Machine, on: Scheme, exported: Scheme, folder: Path) -> NDArray[np.float64]:
    """Run a session in namespaces of its own, and return its record, one row a period."""
    place = folder / f"session-{identifier(on.name)}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    for name in ("bench.ini", "bench.hal", "circle.ngc", "session.py", "bench.tbl", "bench.var"):
        shutil.copy(folder / name, place)
    (place / "home").mkdir()
    (place / "session.py").chmod(0o755)
    pins = [
        f"ff.{identifier(name)}.{pin}={int(value)}"
        for name in pair(machine)
        for pin, value in (("gain", on.feeds_forward), ("enable-observer", on.observer or not exported.observer))
    ]
    for one in [place, *place.rglob("*")]:
        os.chown(one, int(NOBODY), int(NOBODY))
    # In a process namespace of its own: LinuxCNC ends every other LinuxCNC that it sees.
    script = (
        'mount --bind "$1" /mnt && mount -t tmpfs none /tmp && chmod 1777 /tmp && cd /mnt && exec setpriv '
        f"--reuid {NOBODY} --regid {NOBODY} --clear-groups env -u DISPLAY RUNTESTS=1 HOME=/mnt/home "
        f'FRIC_SECONDS={SECONDS:g} FRIC_PINS="$2" linuxcnc /mnt/bench.ini'
    )
    words = ["unshare", "--ipc", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"]
    words += ["bash", "-c", script, "_", str(place.resolve()), ",".join(pins)]
    done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=SECONDS + 60)
    (place / "log.txt").write_text(done.stdout + done.stderr)
    lost, trace = place / "lost.txt", place / "trace.txt"
    if not (lost.exists() and trace.exists()):
        text = [line for line in (done.stdout + done.stderr).splitlines() if line.startswith("session:")]
        raise FricError(
            f"LinuxCNC did not finish: {text[0] if text else done.stderr.strip()[-160:]}", where=str(place / "log.txt")
        )
    return read_trace(trace, int(lost.read_text()))


def read_trace(trace: Path, lost: int) -> NDArray[np.float64]:
    """Return the record of a session, shape (n, 16): a row counter, and what bench.hal samples.

    Raises
    ------
    FricError
        When rows were lost, by the sampler's own count or by the counter in the rows.
    """
    rows = np.loadtxt(trace, ndmin=2)
    if lost or not len(rows) or np.any(np.diff(rows[:, 0]) != 1):
        raise FricError(
            f"the sampler lost rows ({lost} overruns)", where=str(trace), hint="Run the trial alone on the computer."
        )
    return rows


def _arcs(
    machine: Machine, scheme: Scheme, rows: NDArray[np.float64], feeds: Sequence[float], radius: float
) -> list[Arc]:
    line = rows[:, 15].astype(int)
    starts = np.flatnonzero((line != 0) & (np.append(0, line[:-1]) != line))
    ends = [s + int(np.argmin(line[s:] == line[s])) if (line[s:] != line[s]).any() else len(line) for s in starts]
    found = []
    asked = [(feed, direction) for feed in feeds for direction in (-1, 1)]
    if len(starts) != len(asked):
        raise FricError(f"the record holds {len(starts)} arcs, and {len(asked)} were run", where=scheme.name)
    for (feed, direction), first, last in zip(asked, starts, ends, strict=True):
        arc = 1e-3 * rows[first:last]
        simulated = []
        for n, name in enumerate(pair(machine)):
            axis = machine.axis(name)
            motion = (np.ascontiguousarray(arc[:, column + n]) for column in (1, 3, 5))
            simulated.append(run_axis(axis, Reference(axis.cascade.sampling, *motion), scheme).position)
        found.append(
            Arc(
                scheme, feed, direction, circularity(arc[:, 7], arc[:, 8], radius),
                circularity(simulated[0], simulated[1], radius),
            )
        )  # fmt: skip
    return found


def trial_document(arcs: Sequence[Arc]) -> list[dict[str, Any]]:
    """Return circles in LinuxCNC as plain values: glitch and quadrants [m], measured and simulated."""
    return [
        {
            "scheme": arc.scheme.name,
            "velocity": arc.feed,
            "direction": arc.direction,
            "glitch": arc.measured.glitch,
            "quadrants": list(arc.measured.quadrants),
            "simulated": list(arc.simulated.quadrants),
            "difference": arc.difference,
        }
        for arc in arcs
    ]
