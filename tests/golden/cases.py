"""Every verb on the bundled records, on the bundled machines, and on the machines with flaws."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np
from ruamel.yaml import YAML

import fric
from benchmarks.reality.session import Sessions, flaws

DATA = Path(__file__).parents[2] / "data"
STROKES, RESPONSE, SLIDING, PRESLIDING = (
    DATA / f"{name}.h5" for name in ("constant-velocity", "frequency-response", "sliding-sine", "presliding-sine")
)
LEFT_OUT = {"provenance", "source", "file", "command", "created", "sha256", "warnings", "text", "ns_per_step"}
"""Keys of documents that say who made them, from what and how fast; and warnings, whose codes are kept."""
QUICK = ("base", "cogging", "all")
"""The machines of ``--quick``."""


class Golden:
    """A folder of documents.

    Parameters
    ----------
    folder
        Where they are kept, one JSON file each.
    records
        Where the simulated records of the machines with flaws are, or are kept.
    quick
        Whether long fits are left out, and most machines.
    seeds
        Sessions on each machine with a flaw.
    """

    def __init__(self, folder: Path, records: Path, *, quick: bool = False, seeds: int = 1) -> None:
        self.folder, self.records, self.quick, self.seeds = folder, records, quick, seeds

    def keep(self, name: str, make: Callable[[], Any]) -> Any:
        """Keep the document of what is made under a name, and return the result; None where it is refused."""
        began, refused = process_time(), ""
        try:
            result = make()
        except fric.FricError as error:
            result, document, refused = None, {"refused": True}, f": refused, {error}"
        else:
            document = _plain(result.document)
            document["codes"] = [[one.code, one.severity] for one in map(fric.Notice.of, result.warnings)]
        self._write(name, document)
        print(f"{process_time() - began:6.1f} s  {name}{refused}", flush=True)
        return result

    def keep_files(self, name: str, folder: Path) -> None:
        """Keep the documents of a folder that a verb filled, and the names of all its files."""
        files = sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())
        self._write(f"{name}/files", {"files": files})
        for file in folder.rglob("*.yaml"):
            self._write(f"{name}/{file.relative_to(folder).with_suffix('')}", _plain(YAML(typ="safe").load(file)))

    def _write(self, name: str, document: Mapping[str, Any]) -> None:
        file = self.folder / f"{name}.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(document, ensure_ascii=False, indent=1, sort_keys=True), encoding="utf-8")


def _plain(tree: Any) -> Any:
    """Return a document without what `LEFT_OUT` names, as JSON holds it."""
    if isinstance(tree, Mapping):
        return {str(key): _plain(value) for key, value in tree.items() if key not in LEFT_OUT}
    if isinstance(tree, list | tuple):
        return [_plain(value) for value in tree]
    return tree.item() if isinstance(tree, np.generic) else tree


def bundled(golden: Golden) -> None:
    """Identify, inspect, compare and hold against one another the bundled records of the virtual rig."""
    keep = golden.keep
    for log in (STROKES, RESPONSE, SLIDING, PRESLIDING):
        keep(f"bundled/inspect/{log.stem}", partial(fric.inspect, log))
    plant = keep("bundled/plant/response", partial(fric.identify_plant, RESPONSE))
    keep("bundled/plant/stated", partial(fric.identify_plant, RESPONSE, force_constant="150 N/V", coherence=0.7))
    keep("bundled/plant/motion", partial(fric.identify_plant, STROKES, method="motion", force_constant="150 N/V"))
    static = keep("bundled/static/plant", partial(fric.identify_static, STROKES, plant=plant))
    for name, options in STATIC.items():
        keep(f"bundled/static/{name}", partial(fric.identify_static, STROKES, **options))
    given = {"static": static, "plant": plant}
    gms = keep("bundled/gms/both", partial(fric.identify_gms, PRESLIDING, SLIDING, **given))
    keep("bundled/gms/coarse", partial(fric.identify_gms, PRESLIDING, SLIDING, blocks=4, refine=False, **given))
    keep("bundled/gms/alone", partial(fric.identify_gms, PRESLIDING))
    for model in ("dahl", "lugre", *(() if golden.quick else ("leuven", "maxwell-slip"))):
        keep(f"bundled/model/{model}", partial(fric.identify_model, model, PRESLIDING, **given))
    models = "dahl,lugre" if golden.quick else "all"
    keep("bundled/compare", partial(fric.compare, PRESLIDING, models=models, cycles=3, plant=plant))
    controller = keep("bundled/controller", partial(fric.design_controller, plant))
    keep("bundled/observer", partial(fric.design_observer, plant, RESPONSE, controller=controller))
    for block in ("sliding-mode", "two-dof", "repetitive", "kalman", "adaptive"):
        keep(f"bundled/block/{block}", partial(fric.design_block, block, plant, friction=gms, controller=controller))
    motion = _motion()
    known = {"plant": keep("motion/plant", partial(fric.identify_plant, motion)), "controller": CASCADE}
    keep("motion/validate", partial(fric.validate, motion, **known))
    keep("motion/validate-gms", partial(fric.validate, motion, friction=gms, **known))
    keep("bundled/plan-next", partial(fric.plan_next, gms, machine="xy-table"))
    if not golden.quick:
        with TemporaryDirectory() as folder:
            output = Path(folder) / "out"
            keep("bundled/auto", partial(fric.auto, RESPONSE, STROKES, PRESLIDING, output=output, tolerance="5 um"))
            golden.keep_files("bundled/auto", output)


CASCADE = fric.Cascade(K_v=100.0, K_p=40.0, K_i=0.0, velocity_filter=500.0, sampling=1000.0)


def _motion() -> fric.Log:
    """Return a motion in both directions, with a force that is known: 20 kg, 30 N·s/m, 8 N, and 2 N of offset."""
    t = np.arange(0.0, 6.0, 1e-3)
    z = 0.02 * np.sin(2 * np.pi * 0.5 * t) + 0.003 * np.sin(2 * np.pi * 2.3 * t)
    v = np.gradient(z, t)
    noise = np.random.default_rng(0).normal(0, 0.2, t.size)
    force = 20 * np.gradient(v, t) + 30 * v + 8 * np.tanh(v / 1e-4) + 2 + noise
    return fric.Log(time=t, position=z, reference=z, force=force, input=force / 50.0, kind="motion", axis="x")


STATIC: dict[str, dict[str, Any]] = {
    "auto": {},
    "each": {"direction": "each"},
    "load": {"load": "2 N"},
    "coulomb": {"form": "coulomb"},
    "stribeck": {"form": "stribeck", "delta": 1.0, "over_position": "off"},
    "free": {"form": "stribeck", "delta": "free", "over_position": "on"},
    "median": {"average": "median", "weights": "equal"},
}
"""Options of `identify_static`, by the name under which its document is kept."""


def table(golden: Golden) -> None:
    """Simulate, predict, plan, learn, tune, diagnose and export on the bundled machines."""
    keep, quick = golden.keep, golden.quick
    schemes = "a,c,f" if quick else "all"
    for machine in ("xy-table", "virtual-rig"):
        keep(f"{machine}/circle", partial(fric.circle, machine, schemes))
    slow = {"radius": "5 mm", "velocity": "20 mm/s"}
    with TemporaryDirectory() as folder:
        run = Path(folder) / "run.h5"
        made = keep("xy-table/circle-slow", partial(fric.circle, "xy-table", "f", **slow))
        made.save(run)
        keep("xy-table/diagnose", partial(fric.diagnose, run, machine="xy-table"))
        keep("xy-table/learn-table", partial(fric.learn, run, machine="xy-table"))
        if not quick:
            keep("xy-table/tune", partial(fric.tune, "xy-table", run))
            keep("xy-table/predicted", partial(fric.circle, "xy-table", "f", measured=[run], **slow))
    keep("xy-table/learn", partial(fric.learn, "xy-table", rounds=2, radius="5 mm", velocity="100 mm/s"))
    turn = np.linspace(0.0, 2 * np.pi, 40)
    points = fric.PointPath(0.002 * np.cos(turn), 0.001 * np.sin(turn), 0.05)
    keep("xy-table/path", partial(fric.path, "xy-table", points, "a,c"))
    if not quick:
        feeds, radii = [0.02, 0.1], [0.005, 0.03]
        keep("xy-table/plan", partial(fric.plan, stroke="300 mm", feed="100 mm/s", machine="xy-table", draws=3))
        keep("xy-table/map", partial(fric.circle_map, "xy-table", "a,c", feeds=feeds, radii=radii, workers=1))
        keep("xy-table/drawn", partial(fric.circle, "xy-table", "a,c", radius="5 mm", machines=6, workers=1))
    for kind in ("presliding-sine", "sliding-sine", "frequency-response"):
        logs = keep(f"virtual-rig/experiment/{kind}", partial(fric.experiment, "virtual-rig", kind, seed=1))
        keep(f"virtual-rig/inspect/{kind}", partial(fric.inspect, logs))
    for target in ("c", "st", "csv"):
        keep(f"xy-table/export/{target}", partial(fric.export_axis, target, "xy-table", axis="x", scheme="c"))


def reality(golden: Golden) -> None:
    """Identify plant, static map and GMS model on sessions of the machines with flaws, and simulate their circles."""
    for flaw in QUICK if golden.quick else flaws():
        sessions = Sessions(flaw)
        for seed in range(golden.seeds):
            _session(golden, f"reality/{flaw}/{seed}", _records(golden, sessions, flaw, seed))


def _session(golden: Golden, name: str, logs: Mapping[str, fric.Records]) -> None:
    plant = golden.keep(f"{name}/plant", partial(fric.identify_plant, *logs["frequency-response"]))
    strokes = logs["constant-velocity"]
    static = golden.keep(f"{name}/static", partial(fric.identify_static, *strokes, plant=plant))
    golden.keep(f"{name}/static-alone", partial(fric.identify_static, *strokes))
    sines = [*logs["presliding-sine"], *logs["sliding-sine"]]
    golden.keep(f"{name}/gms", partial(fric.identify_gms, *sines, static=static, plant=plant))


def _records(golden: Golden, sessions: Sessions, flaw: str, seed: int) -> dict[str, fric.Records]:
    """Return the records of a session by kind, simulated where they are not kept yet."""
    folder = golden.records / flaw / str(seed)
    if not folder.exists():
        for kind, logs in sessions.session(seed).logs.items():
            folder.mkdir(parents=True, exist_ok=True)
            fric.Records(logs).save(folder / f"{kind}.h5", force=True)
    return {file.stem: fric.read(file) for file in folder.glob("*.h5") if file.stem != "circle"}


SETS: dict[str, Callable[[Golden], None]] = {"bundled": bundled, "machines": table, "reality": reality}
"""What `make` makes, by name."""
