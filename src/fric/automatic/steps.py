"""The steps from the records of one axis to what its controller may believe, and those with the whole machine."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fric.automatic.sources import Source
from fric.documents.machine import MachineDocument
from fric.documents.provenance import provenance
from fric.documents.yaml import plain, read_tree

MACHINES = 24
"""Machines that are drawn from the intervals of what was identified."""

PARTS = ("plant", "controller", "observer", "friction")

TWIN = {"x": "y", "y": "x"}
"""The axis that stands in for the other one of a circle, where one alone was identified."""


@dataclass(frozen=True)
class Step:
    """One ordinary command."""

    name: str  # What it gives, as in ``x: plant``
    words: tuple[str, ...]  # The command, without ``fric``
    # reads, leaves: files that it reads, and files that it leaves
    reads: tuple[Path, ...]
    leaves: tuple[Path, ...]

    @property
    def ready(self) -> bool:
        """Whether all that it reads is there."""
        return all(path.exists() for path in self.reads)


def step(name: str, words: Iterable[object], reads: Iterable[Path], leaves: Iterable[Path]) -> Step:
    """Return a step; what it leaves is replaced."""
    return Step(name, (*map(str, words), "--force"), tuple(reads), tuple(leaves))


def ingest_steps(logs: Sequence[Source], folder: Path) -> Iterator[tuple[Step, Source]]:
    """Yield a step for the foreign logs of each axis, kind and mapping, with what it leaves."""
    groups: dict[tuple[str, str, str], list[Source]] = {}
    for one in logs:
        if one.mapping is not None:
            groups.setdefault((one.axis, "-".join(sorted(one.kinds)), one.mapping), []).append(one)
    for (axis, kind, mapping), members in groups.items():
        log = folder / axis / f"{kind}{'-' + Path(mapping).stem if mapping else ''}.h5"
        files = [one.path for one in members]
        words = ["ingest", *files, "-o", log, *(["--map", mapping] if mapping else [])]
        words += ["--kind", kind] if len(members[0].kinds) == 1 else []
        uses, both = frozenset().union(*(m.uses for m in members)), all(m.both for m in members)
        left = Source(log, axis, members[0].motion, members[0].kinds, uses, both=both)
        reads = [*files, *([Path(mapping)] if mapping.endswith(".yaml") else [])]
        yield step(f"{axis}: ingest {kind}", words, reads, [log]), left


def trace_step(trace: Path, folder: Path) -> Step:
    """Return the step that reads a foreign file with circle tests."""
    test = folder / "circles" / f"{trace.stem}.h5"
    return step(f"ingest {trace.stem}", ["ingest", trace, "--kind", "circle", "-o", test], [trace], [test])


@dataclass(frozen=True)
class AxisSteps:
    """What can be made of the records of one axis."""

    steps: tuple[Step, ...]  # The steps, in their order
    missing: tuple[str, ...]  # What cannot be made, with the record that is missing


def axis_steps(logs: Sequence[Source], folder: Path, *, lean: bool = False) -> AxisSteps:
    """Return the steps of one axis: plant, static map, GMS, controller, observer.

    Parameters
    ----------
    logs
        Log files of this axis.
    folder
        Where its files go.
    lean
        Identify alone: no figures, no controller, no observer; and the static map in one form, so that dates compare.
    """
    axis = logs[0].axis
    steps, missing = [], []
    plant, static, friction = (folder / name for name in ("plant.yaml", "static.yaml", "friction.yaml"))
    controller, observer = folder / "controller.yaml", folder / "observer.yaml"

    def of(*kinds: str, use: str = "") -> list[Path]:
        return [one.path for one in logs if one.kinds & set(kinds) and (not use or use in one.uses)]

    def identify(what: str, files: list[Path], output: Path, *more: object, reads: Iterable[Path] = ()) -> None:
        figure = output.with_suffix(".png")
        words = ["identify", what, *files, *more, "-o", output, *([] if lean else ["--plot", figure])]
        steps.append(step(f"{axis}: {what}", words, [*files, *reads], [output, *([] if lean else [figure])]))

    responses = of("frequency-response")
    if shaken := responses or of("motion"):
        scaled = any(one.both for one in logs if one.path in shaken)
        steady = [one.path for one in logs if one.kinds == {"constant-velocity"} and one.both and not scaled]
        beside = steady if responses else []  # K_f, which no response tells
        identify("plant", [*shaken, *beside], plant, *([] if responses else ["--method", "motion"]))
    else:
        missing.append("plant: a frequency response, or an ordinary motion with position and voltage or force")
    known = [plant] if shaken else []
    damping = [word for path in known for word in ("--plant", path)]
    if strokes := of("constant-velocity", use="static"):
        form = ["--delta", "1", "--over-position", "off", "--direction", "both"] if lean else []
        identify("static", strokes, static, *damping, *form, reads=known)
    else:
        missing.append("static map: strokes at constant velocity, at five speeds or more, with force")
    if slow := of("presliding-sine", use="gms"):
        sines = list(dict.fromkeys([*slow, *of("sliding-sine", use="gms")]))
        given = ["--static", static] if strokes else []
        identify("gms", sines, friction, *damping, *given, reads=[*known, *([static] if strokes else [])])
        if not of("sliding-sine"):
            missing.append("C of the GMS model: a sine in sliding, around a steady speed")
    else:
        missing.append("GMS: slow sines of some ten micrometres before sliding, with force")
    if lean:
        return AxisSteps(tuple(steps), tuple(missing))
    if responses:
        words = ["design", "controller", plant, "-o", controller]
        steps.append(step(f"{axis}: controller", words, [plant], [controller]))
        figure = observer.with_suffix(".png")
        words = ["design", "observer", plant, *responses[:1], "--controller", controller, "-o", observer]
        reads = [plant, controller, *responses[:1]]
        steps.append(step(f"{axis}: observer", [*words, "--plot", figure], reads, [observer, figure]))
    else:
        missing.append("controller and observer: a frequency response from voltage to position")
    return AxisSteps(tuple(steps), tuple(missing))


def circle_step(machine: Path, folder: Path, *more: object, reads: Iterable[Path] = ()) -> Step:
    """Return the step that simulates the circle, with machines drawn from the intervals."""
    run, figure = folder / "circle.h5", folder / "circle.png"
    words = ["simulate", "circle", machine, *more, "--monte-carlo", MACHINES, "--from-intervals"]
    return step("circle", [*words, "-o", run, "--plot", figure], [machine, *reads], [run, figure])


def diagnosis_step(circle: Path, machine: Path, folder: Path, reads: Iterable[Path] = ()) -> Step:
    """Return the step that holds a measured circle against what the machine file predicts."""
    figure = folder / f"{circle.stem}.png"
    words = ["diagnose", circle, "--machine", machine, "--plot", figure]
    return step(f"{circle.stem}: diagnosis", words, [circle, machine, *reads], [figure])


def tune_step(circles: Sequence[Path], machine: Path, folder: Path, reads: Iterable[Path] = ()) -> Step:
    """Return the step that refits what the controllers believe to measured circles."""
    target = folder / "tuned"
    words = ["tune", machine, *circles, "-o", target]
    return step("tune", words, [*circles, machine, *reads], [target / "machine.yaml"])


def machine_tree(axes: Mapping[str, Mapping[str, Path]], folder: Path) -> dict[str, Any]:
    """Return a machine file whose axes name the files of what was identified.

    Parameters
    ----------
    axes
        The files of each axis by `PARTS`.
    folder
        Where the machine file goes.
    """
    tree: dict[str, Any] = {"fric": MachineDocument.type_name(), "name": "identified machine", "axes": {}}
    for name, files in axes.items():
        tree["axes"][name] = {part: str(path.relative_to(folder)) for part, path in files.items()}
    if len(axes) == 1:
        ((name, files),) = axes.items()
        twin = {part: _bare(path) for part, path in files.items()}
        tree["axes"][TWIN.get(name, "y")] = twin
    return tree | {"provenance": provenance()}


def _bare(path: Path) -> dict[str, Any]:
    """Return the values of a file, without what ties it to its axis."""
    tree = plain(read_tree(path))
    tied = {"fric", "axis", "motion", "fit", "warnings", "warnings_coded", "provenance", "margins", "limits", "reason"}
    tied |= {"bandwidth", "second_mass"}
    return {key: value for key, value in tree.items() if key not in tied and not key.endswith("_fit")}
