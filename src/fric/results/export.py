"""Export of one axis under one scheme, in the language of a controller."""

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec
from itertools import pairwise
from pathlib import Path
from shlex import quote, split
from types import ModuleType
from typing import Annotated, Any, Literal

import fric
from fric.circles.prediction import Prediction
from fric.contour import Circularity
from fric.control.scheme import NONE, Scheme
from fric.documents.base import sources
from fric.documents.bundled import located
from fric.documents.listings import ExportDocument, TrialPart
from fric.documents.machine_files import axis_notices, read_machine, read_machine_document
from fric.errors import FricError, clean, require_known
from fric.export import targets
from fric.export.base import ExportedPart, Files, Target, compensation_of, machine_of, manifest
from fric.flaws import flaw_of
from fric.flaws.prediction import NOTHING_SIMULATED, SCHEME_SATURATES
from fric.io.circle import DrawnGlitches, read_drawn, read_prediction, read_run_provenance, read_runs
from fric.notice import Notice, once
from fric.output import folder_made, write_folder
from fric.results.base import Advance, Piece, Result, Table, path_of, silent
from fric.results.circles import diagnose
from fric.results.given_models import schemes_of
from fric.results.kinds import AxisName, CircleFiles, KnownSchemes, MachineLike, Quantity, SchemesLike
from fric.simulate.contour_run import Circle, CircleRun, PathRun, pair, run_circle
from fric.simulate.machine import Machine
from fric.units import readable
from fric.verb import Kind, verb
from fric.verdict import Candidate, Evidence, candidates_of, decide, evidence_of, machine_name, reasons_against


def trust_of(
    machine: Machine, name: str, scheme: Scheme, notices: Iterable[Notice], disagreements: Sequence[Notice] = (), *,
    compared: bool = False, drawn: Sequence[Evidence] = (), advance: Advance = silent,
) -> tuple[list[Notice], list[Notice]]:  # fmt: skip
    """Return the reasons against a scheme on an axis, and further doubts of the verdict.

    Reasons are warnings of severity ``wrong`` in the machine's files, and a measured circle that differs from its
    prediction. Where the axis runs circles, the circle is simulated at 100 and at 10 mm/s: a reason of the verdict
    against the scheme at either feed, or a drive that saturates, counts too. Doubts are that no machines were drawn,
    and that no circle was measured.

    disagreements, compared: Where measured circles differ from the prediction; whether any was compared with the
        machine.
    drawn: What the scheme, and no compensation, left on drawn machines, by circle.
    """
    given = Evidence(
        axes=(name,), resolution=machine.axis(name).encoder.resolution, compared=compared, disagreements=disagreements,
        notices=[notice for notice in notices if notice.severity == "wrong"],
    )  # fmt: skip
    try:
        on_circle = name in pair(machine)
    except FricError:
        on_circle = False
    against: list[Notice] = []
    for feed in (0.1, 0.01) if on_circle else ():
        runs = []
        for tried in (replace(NONE, gain=None), scheme):
            runs.append(run_circle(machine, tried, Circle(feed=feed), only=name))
            advance()
        alone, with_it = candidates_of(runs)
        given = replace(given, candidates=(alone, with_it), exact=machine.is_nominal([scheme.friction], [name]))
        where = f"axis {name} at {1e3 * feed:g} mm/s"
        against += [notice.at(where) for notice in reasons_against(with_it, given)]
        if with_it.warnings and not alone.warnings:
            against.append(SCHEME_SATURATES.found(where, how=str(with_it.warnings[0])))
    for evidence in drawn:
        against += reasons_against(next(c for c in evidence.candidates if not c.scheme.bare), evidence)
    reasons = [notice for evidence in drawn or (given,) for notice in decide(evidence).why]
    why = [notice for notice in once(reasons) if on_circle or notice.code != NOTHING_SIMULATED.code]
    wrong = [notice for notice in why if notice.severity == "wrong"]
    return list(once([*wrong, *against])), [notice for notice in why if notice.severity != "wrong"]


@dataclass(frozen=True)
class TriedCircle:
    """An arc in LinuxCNC, and the same loop simulated along the reference of LinuxCNC's planner."""

    scheme: Scheme  # What was switched on
    feed: float  # Speed along the arc [m/s]
    direction: int  # 1 counter-clockwise, -1 clockwise
    measured: Circularity  # measured, simulated: what was left of the circle, in LinuxCNC and by simulation
    simulated: Circularity

    @property
    def difference(self) -> float:
        """The largest difference of a quadrant's glitch between both [m]."""
        return max(abs(a - b) for a, b in zip(self.measured.quadrants, self.simulated.quadrants, strict=True))


class ExportResult(Result):
    """Files for a controller, and the reasons for and against their use."""

    target: Target  # The target
    part: ExportedPart  # What is exported
    files: Files  # Its files by name, without the manifest
    notices: Sequence[Notice]  # Warnings of the machine's files
    against: Sequence[Notice]  # Why it should not be put on the machine; may be empty
    distrust: Sequence[Notice]  # Why the verdict does not trust it yet
    instead: Sequence[Notice]  # What the target holds in place of the scheme that the verdict is of
    made_from: Sequence[dict[str, str]]  # Name and digest of each file that it was made from
    arcs: Sequence[TriedCircle] = ()  # Circles in LinuxCNC, where they were run

    @cached_property
    def document(self) -> dict[str, Any]:
        """The content of manifest.json, and the arcs if LinuxCNC ran."""
        content = manifest(self.target.name, self.part, self.files, notices=self.warnings, sources=self.made_from)
        if self.part.role == "compensation":
            why = [*self.against, *self.distrust, *self.instead]
            content["verdict"] = {"trusted": not why, "why": [notice.as_dict() for notice in why]}
        content |= {"trial": [TrialPart.model_validate(arc).model_dump() for arc in self.arcs]} if self.arcs else {}
        ExportDocument.model_validate(content)
        return content

    @property
    def warnings(self) -> Sequence[Notice]:
        """Warnings of the machine's files, reasons against the export, and what it holds in place of the scheme."""
        return once([*self.notices, *self.against, *self.instead])

    def report(self) -> list[Piece]:
        """Return what is in which file, and how LinuxCNC and simulation compare."""
        rows = [[name, str(len(content))] for name, content in self._all().items()]
        scheme = f", scheme {self.part.scheme}," * bool(self.part.scheme)
        title = f"{self.part.machine}: {self.part.role} of axis {self.part.axis}{scheme} for {self.target.name}"
        pieces: list[Piece] = [Table(["file", "bytes"], rows, title)]
        if self.distrust:
            pieces.append(f"Not to be trusted yet. {' '.join(self.distrust)}")
        if self.arcs:
            head = ["switched on", "feed", "turns", "LinuxCNC", "simulated", "largest difference of a quadrant"]
            title = "largest glitch of each circle in µm: in LinuxCNC, and simulated along its planner's reference"
            pieces.append(Table(head, [_row(arc) for arc in self.arcs], title))
        return pieces

    def save(self, path: Path | str, *, force: bool = False) -> None:
        """Write files and manifest into a folder.

        Raises FricError: When the verdict does not trust it, or a file exists, and ``force`` is not set.
        """
        if not force:
            require_trust(self.part, self.against, self.distrust, self.made_from)
        write_folder(Path(path), self._all(), force=force)

    def _all(self) -> dict[str, str | bytes]:
        text = clean(json.dumps(self.document, ensure_ascii=False, indent=2, allow_nan=False))
        return {**self.files, "manifest.json": f"{text}\n"}


@verb
def export_axis(
    target: Annotated[str, Kind(metavar="TARGET", complete="fric.export:targets")], machine: MachineLike, *,
    axis: AxisName, scheme: SchemesLike | None = None, part: Literal["compensation", "machine"] = "compensation",
    single: bool = False, nominal_files: Annotated[Sequence[str], Kind(list[str], "AXIS=FILE.yaml")] = (),
    gain: float | None = None, lead: Annotated[Quantity | None, "time"] = None, known: KnownSchemes | None = None,
    circles: CircleFiles = (), drawn: Annotated[Sequence[Path | str], Kind(list[Path], "RUN.h5")] = (),
    trial: Path | str | None = None, force: bool = False, advance: Advance = silent,
) -> ExportResult:  # fmt: skip
    """Write code for a controller: friction feedforward and observers, with a manifest of its contents.

    A folder of `fric auto` in place of a machine gives its machine, its run, and the circles of that run.

    target: c, linuxcnc, fmi, st, twincat, sinumerik, csv, mat or xlsx.
    scheme: The scheme: friction feedforward, and blocks; by default the one that a folder of `fric auto` recommends,
        else f (twincat: b). Its name, or itself.
    part: compensation; or machine, the axis itself as a plant to test a controller.
    single: Single precision (c).
    circles: A measured circle. Where it differs from the machine's prediction, and the varied machines were not fitted
        to it, that counts against the export.
    drawn: A run of the scheme on drawn machines (simulate circle). The verdict uses these run files.
    trial: A folder in which circles are run in LinuxCNC, beside their simulation. For the target ``linuxcnc``, as root,
        and from a checkout of fric: the bench is ``tests/linuxcnc``.
    force: Run the trial even if the verdict does not trust the scheme.
    Raises FricError: When there is no such target, axis or scheme, or a part cannot be exported.
    """
    chosen = one_target(target, part, single=single)
    session = Path(machine) if isinstance(machine, str | Path) and Path(machine).is_dir() else None
    advised = _recommended(session) if session and scheme is None and not chosen.friction else None
    (wanted,) = schemes_of(scheme or advised or ("b" if chosen.friction else "f"), known)[:1]
    if chosen.friction and not wanted.bare and (wanted.friction, wanted.blocks) != (chosen.friction, ()):
        able = ", ".join(other.name for other in targets().values() if "machine" in other.parts)
        raise FricError(f"the target {target} holds a {chosen.friction} map alone, and no scheme {wanted.name}",
                        hint=f"Export `scheme='b'`, or scheme {wanted.name} to {able} or st.")  # fmt: skip
    notices: tuple[Notice, ...] = ()
    made_from: list[dict[str, str]] = []
    if isinstance(machine, Machine):
        subject = machine
    else:
        if session:
            machine, drawn, circles = _of_session(session, drawn, circles)
        file = located(path_of("a machine, or its file", machine), "machine")
        subject = read_machine(file, nominal_files=nominal_files, gain=gain, lead=lead)
        notices = axis_notices(read_machine_document(file, nominal_files), axis)
        made_from = sources([file, *(Path(text.partition("=")[2]) for text in nominal_files)])
    made = compensation_of(subject, axis, wanted) if part == "compensation" else machine_of(subject, axis)
    instead: list[Notice] = []
    options = {"single": single, "machine": subject, "advance": advance, "instead": instead}
    files = chosen.files(made, **{name: value for name, value in options.items() if name in chosen.options})
    against, distrust = list[Notice](), list[Notice]()
    if part == "compensation":
        drawings = [_drawing(Path(path), subject, wanted, axis) for path in drawn]
        named = path_of("a machine file, to hold a circle against it", machine) if circles else None
        held = {str(circle): diagnose(circle, machine=named).disagreements(str(circle)) for circle in circles}
        apart = [text for texts in held.values() for text in texts]
        around = [evidence_of(*one, compared=bool(circles), disagreements=held, notices=notices) for one in drawings]
        against, distrust = trust_of(
            subject, axis, wanted, notices, apart, compared=bool(circles), drawn=around, advance=advance
        )
        settled = [text for evidence in around for text in evidence.settled if flaw_of(text).disagrees]
        notices = (*notices, *(text for text in settled if text not in distrust))
    arcs: list[TriedCircle] = []
    if trial is not None:
        if target != "linuxcnc":
            raise FricError(f"a trial is for the target linuxcnc, and this is {target}", hint="Leave out the trial.")
        if not force:
            require_trust(made, against, distrust, made_from)
        arcs = _linuxcnc_bench().try_in_linuxcnc(subject, wanted, folder_made(trial), advance=advance)
    return ExportResult(chosen, made, files, notices, against, distrust, instead, made_from, arcs)


def _linuxcnc_bench() -> ModuleType:
    """Return the module of the test bench that runs circles in LinuxCNC."""
    folder = Path(fric.__file__).parents[2] / "tests" / "linuxcnc"
    if not (folder / "trial.py").exists():
        what = "circles in LinuxCNC are run by a test bench that is not part of the installed package"
        raise FricError(what, hint="Run fric from a checkout of its repository, which has the bench in tests/linuxcnc.")
    name = "fric_linuxcnc"
    if name not in sys.modules:
        spec = ModuleSpec(name, None, is_package=True)
        spec.submodule_search_locations = [str(folder)]
        sys.modules[name] = module_from_spec(spec)
    return import_module(f"{name}.trial")


def require_trust(
    part: ExportedPart, against: Sequence[Notice], distrust: Sequence[Notice], made_from: Sequence[dict[str, str]]
) -> None:
    """Raise a `FricError` where the verdict does not trust what would be exported."""
    if against:
        hint = "Correct that first; `force=True` exports it nevertheless."
        raise FricError(f"scheme {part.scheme} on axis {part.axis} is not to be trusted: {against[0]}", hint=hint)
    if distrust:
        name = quote(machine_name(made_from[0]["file"])) if made_from else "MACHINE.yaml"
        many = f"fric simulate circle {name} --scheme a,{part.scheme} --monte-carlo 20 -o run.h5"
        what = f"scheme {part.scheme} on axis {part.axis} is not to be trusted yet. {' '.join(distrust)}"
        hint = f"Give a run with varied machines (`{many}`) with `drawn=`, and a measured circle with `circles=`; "
        raise FricError(what, hint=f"{hint}`force=True` exports it nevertheless.")


def _of_session(
    folder: Path, drawn: Sequence[Path | str], circles: Sequence[Path | str]
) -> tuple[Path, Sequence[Path | str], Sequence[Path | str]]:
    """Return the machine of a folder of `fric auto`, its run, and the circles of that; runs and circles as given."""
    run = folder / "circle.h5"
    if not run.exists():
        return folder / "machine.yaml", drawn, circles
    words = split(read_run_provenance(run).get("command", ""))
    given = [after for word, after in pairwise(words) if word == "--measured"]  # beside the folder, run elsewhere
    places = [Path.cwd(), folder.resolve(), *folder.resolve().parents]
    measured = [next((place / name for place in places if (place / name).exists()), name) for name in given]
    return folder / "machine.yaml", drawn or [run], circles or measured


def _drawing(
    file: Path, machine: Machine, scheme: Scheme, axis: str
) -> tuple[dict[str, Any], list[Candidate], Prediction | None]:
    """Return the description of a run file, the glitches with and without a scheme on machines, and the prediction."""
    made, left = read_run_provenance(file), read_drawn(file)
    runs = [run for run in read_runs(file, traces=False) if run.scheme == scheme or run.scheme.bare]
    of, here = ({**origin, "path": ""} for origin in (made.get("origin", {}), machine.origin))
    if made.get("machine") != machine.name or of != here:
        what = f"the run is not of {machine.name}, or with another friction, gain or lead"
        raise FricError(what, where=str(file), hint="Simulate it again with this machine.")
    if axis not in made.get("axes", ()):
        raise FricError(f"the run is without axis {axis}", where=str(file), hint="Simulate it again without --axis.")
    if scheme.name not in {run.scheme.name for run in runs if not run.scheme.bare}:
        raise FricError(f"the run is without scheme {scheme.name}", where=str(file),
                        hint=f"Make it by `fric simulate circle --scheme a,{scheme.name}`.")  # fmt: skip
    return made, *_candidates(file, runs, left)


def _candidates(
    file: Path, runs: Sequence[CircleRun | PathRun], left: Mapping[str, DrawnGlitches]
) -> tuple[list[Candidate], Prediction | None]:
    """Return what schemes left in a run file and on its drawn machines, and the prediction."""
    found = candidates_of(runs, prediction=(prediction := read_prediction(file)))
    if left:
        both = ((candidate, left[candidate.scheme.name]) for candidate in found)
        found = [replace(candidate, drawn=drawn.glitches, swings=drawn.swings) for candidate, drawn in both]
    return found, prediction


def _recommended(folder: Path) -> Scheme | None:
    """Return the scheme that the run in a folder of `fric auto` recommends; None where it is none."""
    if not (run := folder / "circle.h5").exists():
        return None
    found, prediction = _candidates(run, read_runs(run, traces=False), read_drawn(run))
    chosen = decide(evidence_of(read_run_provenance(run), found, prediction)).choice
    return None if chosen is None or chosen.scheme.bare else chosen.scheme


MAKERS = {
    "siemens": "sinumerik", "840d": "sinumerik", "beckhoff": "twincat", "codesys": "st", "plc": "st",
    "simulink": "fmi", "matlab": "mat", "excel": "xlsx",
}  # fmt: skip
"""Targets of controllers and programs whose name somebody may give."""


def one_target(name: str, part: str, *, single: bool) -> Target:
    """Return the target that exports such a part with such options."""
    known = targets()
    if name.endswith((".yaml", ".yml")):
        raise FricError(f"'{name}' is not a target", hint=f"The target comes first: `fric export linuxcnc {name}`.")
    require_known(MAKERS.get(name.casefold(), name), known, "there is no target")
    if made := MAKERS.get(name.casefold()):
        raise FricError(f"'{name}' is not a target", hint=f"For its controllers: `fric export {made}`.")
    target = known[name]
    if part not in target.parts:
        able = [target.name for target in known.values() if part in target.parts]
        hint = f"It exports {' and '.join(target.parts)}" + (f"; {', '.join(able)} export that." if able else ".")
        raise FricError(f"the target {name} has no part '{part}'", hint=hint)
    if single and "single" not in target.options:
        raise FricError(f"the target {name} has no single precision", hint="Leave `single=` out, or export to c.")
    return target


def _row(arc: TriedCircle) -> list[str]:
    sense = "counter-clockwise" if arc.direction > 0 else "clockwise"
    microns = [f"{1e6 * value:.2f}" for value in (arc.measured.glitch, arc.simulated.glitch, arc.difference)]
    return [arc.scheme.title, readable(arc.feed, "m/s"), sense, *microns]
