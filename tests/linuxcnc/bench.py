"""A bench on which a real LinuxCNC drives exported compensation on exported axes: its planner, its PID, its threads.

LinuxCNC runs without a screen and without realtime. What makes a session the same from run to run: a motion that is
recorded starts from rest behind a dwell, and a gate holds axes and compensation on the command until it begins. The
plant computes in sub-steps of nominal length, so that the jitter of the computer does not enter.
"""

import os
import re
import shutil
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

import fric
from fric.arrays import Indices, Real
from fric.control.scheme import NONE, Scheme
from fric.errors import FricError
from fric.export.base import compensation_of, identifier, machine_of
from fric.export.linuxcnc import COMPONENTS, linuxcnc_files
from fric.friction.stribeck import StaticMap
from fric.simulate.contour_run import pair
from fric.simulate.machine import Machine

TAIL = 200
"""Periods for which a record goes on after an arc."""
STILL = 60.0
"""Seconds in which nothing moves, after which a session is given up."""
NOBODY = "65534"
"""User and group under which LinuxCNC runs, where fric runs as root: LinuxCNC refuses root."""
CHANNELS = ("reference", "velocity", "acceleration", "position", "encoder", "input", "feedforward")
"""What the sampler writes of each axis, x before y: velocity and acceleration are those commanded, position is true."""


@dataclass(frozen=True)
class Program:
    """A program in G-code, and what LinuxCNC's planner may do along it.

    Parameters
    ----------
    text
        The program; it ends with M2.
    speed, acceleration
        Limits of each axis and of the path [m/s], [m/s²].
    travel
        How far each axis may be from 0 [m].
    whole
        Recording everything from the first motion on, dwells too; else each arc apart.
    """

    text: str
    speed: float
    acceleration: float
    travel: float
    whole: bool = True


@dataclass(frozen=True)
class Recording:
    """What the sampler wrote, one row a servo period.

    Parameters
    ----------
    rows
        A count of the periods; then each of `CHANNELS` of x and of y in mm and V; then the line of the program.
    sampling
        Rows a second [Hz].
    """

    rows: Real
    sampling: float

    def channel(self, name: str, axis: int) -> Real:
        """Return one of `CHANNELS` of the first or the second axis in SI, shape (n,)."""
        scale = 1.0 if name in ("input", "feedforward") else 1e-3
        return np.ascontiguousarray(scale * self.rows[:, 1 + 2 * CHANNELS.index(name) + axis])

    @property
    def line(self) -> Indices:
        """Line of the program at each row; 0 where none runs."""
        return self.rows[:, -1].astype(int)

    @property
    def time(self) -> Real:
        """Time of each row [s]."""
        return (self.rows[:, 0] - self.rows[0, 0]) / self.sampling


def render(template: str, **values: Any) -> str:
    """Return a template of this folder, filled."""
    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"), undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True, autoescape=False,
    )  # fmt: skip
    return made.get_template(template).render(version=fric.__version__, **values)


def require_linuxcnc() -> None:
    """Raise a `FricError` where LinuxCNC is not installed, or this is not root."""
    for word, package in (("linuxcnc", "linuxcnc-uspace"), ("halcompile", "linuxcnc-uspace-dev")):
        if shutil.which(word) is None:
            raise FricError(f"a trial needs {word}, which is not installed", hint=f"apt-get install {package}.")
    if os.geteuid() != 0:
        raise FricError("a trial runs LinuxCNC in namespaces of its own, which needs root", hint="Run it with sudo.")


def build_bench(machine: Machine, exported: Scheme, program: Program, folder: Path) -> None:
    """Write a bench into a folder, and build its components: both axes and their compensation, and what runs them.

    Raises
    ------
    FricError
        When LinuxCNC is not installed, the machine has no two axes, something cannot be exported, or does not build.
    """
    require_linuxcnc()
    names = pair(machine)
    files, axes = dict[str, str | bytes](), []
    for name in names:
        axis, made = machine.axis(name), f"fric_{identifier(name)}_"
        compensation = compensation_of(machine, name, exported)
        if compensation.friction is None:  # nothing is fed forward; the component is there
            compensation = replace(compensation, friction=StaticMap(F_c=0.0, F_s=0.0, v_s=1.0))
        for part in (compensation, machine_of(machine, name)):
            files |= {f: text for f, text in linuxcnc_files(part).items() if f.endswith((".c", ".h", ".comp"))}
        axes.append(
            {
                "name": identifier(name), "K_v": axis.cascade.K_v, "K_p": axis.cascade.K_p / 1e3,
                "K_i": axis.cascade.K_i / 1e3, "limit": min(axis.cascade.limit, 1e6),
                "plant": made + COMPONENTS["machine"], "compensation": made + COMPONENTS["compensation"],
            }
        )  # fmt: skip
    values = {
        "axes": axes, "machine": machine.name, "tail": TAIL, "channels": CHANNELS, "whole": program.whole,
        "period_ns": round(1e9 / machine.axis(names[0]).cascade.sampling), "travel": 1e3 * program.travel,
        "speed": f"{1e3 * program.speed:.9g}", "acceleration": f"{1e3 * program.acceleration:.9g}",
    }  # fmt: skip
    for file in ("bench.ini", "bench.hal", "fric_gate.comp", "session.py", "trace.yaml"):
        files[file] = render(f"{file}.j2", **values)
    folder.mkdir(parents=True, exist_ok=True)
    for file, content in (files | {"program.ngc": program.text, "bench.tbl": "", "bench.var": ""}).items():
        (folder / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    for component in sorted(folder.glob("*.comp")):
        done = subprocess.run(["halcompile", "--compile", component.name], cwd=folder, capture_output=True, text=True)
        if done.returncode:
            printed = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr[-200:])
            raise FricError(f"halcompile refuses the component: {printed}", where=str(component))


def apart(place: Path, built: Path, *command: str) -> list[str]:
    """Return the words that run a command of LinuxCNC in a folder as nobody, apart from every other LinuxCNC.

    In a process namespace of its own, for LinuxCNC ends every other one that it sees; and with modules of its own:
    those of LinuxCNC, and the components built for it, which another bench would write over in LinuxCNC's own folder
    while they run.

    Parameters
    ----------
    place
        The folder, which is ``/mnt`` there.
    built
        Where the components were compiled.
    command
        The command.
    """
    makefile = subprocess.run(
        ["halcompile", "--print-modinc"], capture_output=True, text=True, check=True
    ).stdout.strip()
    modules = re.findall(r"^RTLIBDIR := (\S+)$", Path(makefile).read_text(), re.MULTILINE)[-1]
    script = (
        'mount -t tmpfs none /mnt && cp "$1"/*.so /mnt && cp "$2"/*.so /mnt && mount --bind /mnt "$1" && '
        'mount --bind "$3" /mnt && '
        "mount -t tmpfs none /tmp && chmod 1777 /tmp && cd /mnt && shift 3 && exec setpriv "
        f'--reuid {NOBODY} --regid {NOBODY} --clear-groups env RUNTESTS=1 "$@"'
    )
    spaces = ["unshare", "--ipc", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"]
    return [*spaces, "bash", "-c", script, "_", modules, str(built.resolve()), str(place.resolve()), *command]


def run_session(machine: Machine, on: Scheme, exported: Scheme, folder: Path) -> Recording:
    """Run the program of a bench with a scheme switched on, in namespaces of its own, and return its record.

    Raises
    ------
    FricError
        When LinuxCNC refuses the program or does not finish it, or rows of the record are lost.
    """
    place = folder / f"session-{identifier(on.name)}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    for name in ("bench.ini", "bench.hal", "program.ngc", "session.py", "bench.tbl", "bench.var"):
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
    settings = ["HOME=/mnt/home", f"FRIC_SECONDS={STILL:g}", f"FRIC_PINS={','.join(pins)}"]
    words = apart(place, folder, "env", "-u", "DISPLAY", *settings, "linuxcnc", "/mnt/bench.ini")
    done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    return Recording(read_session(place, done.stdout + done.stderr), machine.axis(pair(machine)[0]).cascade.sampling)


def read_session(place: Path, printed: str) -> Real:
    """Return the rows of the record that a session left in its folder, and keep what LinuxCNC printed in ``log.txt``.

    Raises
    ------
    FricError
        When the session did not finish, LinuxCNC broke the program off, or rows were lost.
    """
    (place / "log.txt").write_text(printed)
    lines = printed.splitlines()
    lost, trace = place / "lost.txt", place / "trace.txt"
    if not (lost.exists() and trace.exists()):
        why = next((line for line in lines if line.startswith("session:")), printed.strip()[-160:])
        raise FricError(f"LinuxCNC did not finish: {why}", where=str(place / "log.txt"))
    # a command that the servo thread does not take in time ends the program, and LinuxCNC is idle as behind its end
    if broken := next((line for line in lines if "USRMOT: ERROR" in line), ""):
        raise FricError(
            f"LinuxCNC broke the program off: {broken}", where=str(place / "log.txt"),
            hint="Run the trial alone on the computer.",
        )  # fmt: skip
    return read_trace(trace, int(lost.read_text()))


def read_trace(trace: Path, lost: int) -> Real:
    """Return the rows of a record, shape (n, 16).

    Raises
    ------
    FricError
        When rows were lost, by the sampler's own count or by the periods' in the rows.
    """
    text = trace.read_text().splitlines()
    rows = np.loadtxt(text, ndmin=2) if text else np.empty((0, 1))
    if lost or not len(rows) or np.any(np.diff(rows[:, 0]) != 1):
        raise FricError(
            f"the sampler lost rows ({lost} overruns)", where=str(trace), hint="Run the trial alone on the computer."
        )
    return rows


def run_program(machine: Machine, program: Program, folder: Path) -> Recording:
    """Run a program in LinuxCNC on the machine's axes, from an empty folder to its record; nothing is fed forward.

    Parameters
    ----------
    machine
        The machine: its first two axes are the plant, and x and y of the program.
    program
        The program and its limits.
    folder
        Where the bench is written and its record is left.

    Raises
    ------
    FricError
        When LinuxCNC is not installed, refuses the program or does not finish it, or rows of its record are lost.
    """
    build_bench(machine, NONE, program, folder)
    return run_session(machine, NONE, NONE, folder)
