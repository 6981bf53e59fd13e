"""What `fric tune` writes: a machine file with the new nominal parameters, and a friction and a plant file an axis."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fric.documents.base import FOOT
from fric.documents.controller import ControllerPart
from fric.documents.friction import FrictionDocument
from fric.documents.machine import MachineDocument
from fric.documents.machine_files import read_machine_document
from fric.documents.plant import PlantDocument
from fric.documents.yaml import write_document
from fric.errors import FricError
from fric.estimate import Estimate
from fric.output import refuse_existing

if TYPE_CHECKING:
    from fric.circles.measured import MeasuredCircle
    from fric.circles.tune import Tuned
    from fric.circles.tuned import TunedAxis


def tuned_files(found: Tuned, folder: Path) -> list[Path]:
    """Return the files that `write_tuned` writes."""
    better = [name for name, one in found.axes.items() if one.improves]
    return [folder / "machine.yaml", *(folder / f"{name}{end}.yaml" for name in better for end in ("", "-plant"))]


def write_tuned(
    found: Tuned, machine: Path, folder: Path, *, force: bool = False, done: list[Path] | None = None
) -> list[Path]:
    """Write a machine file with the new nominal parameters, and the friction and the plant of each axis that it names.

    An axis that was not improved stays as it was.

    found: What was tuned.
    machine: The machine file that it was tuned from.
    folder: Where to write.
    force: Replace files that exist.
    done: Is called for each file that is there.
    Raises FricError: When a file exists, or cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FricError(f"cannot be made: {error.strerror or error}", where=str(folder)) from None
    files = tuned_files(found, folder)
    refuse_existing(*files, force=force)
    done = [] if done is None else done
    tree = read_machine_document(machine).tree()
    better = {name: one for name, one in found.axes.items() if one.improves}
    for name, one in better.items():
        write_document(folder / f"{name}.yaml", friction_tree(one, found.tests), force=force)
        done.append(folder / f"{name}.yaml")
        write_document(folder / f"{name}-plant.yaml", plant_tree(one, found.tests), force=force)
        done.append(folder / f"{name}-plant.yaml")
        axis = tree["axes"][name]
        axis.pop("nominal", None)  # it, and what is fed forward, are named once the rest has been checked
        axis["feedforward"] = {"lead": "auto"}
        if isinstance(axis.get("observer"), dict):  # its G_n is the nominal plant
            axis["observer"] = {key: part for key, part in axis["observer"].items() if key not in ("A", "B")}
        if one.loop:
            axis |= _loop(one)
    content = {key: part for key, part in tree.items() if key not in ("fric", "like", *FOOT)}
    written = MachineDocument.made(content, notices=found.warnings, also=_sources(found.tests)).tree()
    for name, one in better.items():
        written["axes"][name] |= {"nominal": f"{name}-plant.yaml", "feedforward": _feedforward(name, one)}
    write_document(folder / "machine.yaml", written, force=force)
    done.append(folder / "machine.yaml")
    return files


def _feedforward(name: str, one: TunedAxis) -> dict[str, Any]:
    """Return what is fed forward of a tuned axis: its friction, or a share of it."""
    gain = one.axis.nominal_friction.gain
    share = {} if gain == 1.0 else {"gain": {"value": gain, "unit": "1"}}
    return {"lead": "auto", "friction": f"{name}.yaml", **share}


def _loop(one: TunedAxis) -> dict[str, Any]:
    """Return the gains of a loop that was designed anew, as parts of an axis."""
    own, watch = one.axis.cascade, one.axis.observer
    gains = {name: gain.as_dict() for name, gain in ControllerPart.of(own, one.axis.motion).items()}
    if watch is None:
        return {"controller": gains}
    cutoff = {"value": watch.q.cutoff, "unit": "Hz"}
    return {"controller": gains, "observer": {"filter": watch.q.name, "cutoff": cutoff}}


def _sources(tests: Sequence[MeasuredCircle]) -> dict[str, Any]:
    return {"circles": [{"file": test.source, "test": test.name, "sha256": test.sha256} for test in tests]}


def friction_tree(one: TunedAxis, tests: Sequence[MeasuredCircle]) -> dict[str, Any]:
    """Return the friction that circles gave an axis as a friction document."""
    estimates, axis = one.estimates, one.axis
    assert estimates is not None  # of what is improved
    K_f = one.nominal.K_f
    text = {
        "rmse": Estimate(one.after.rms * K_f, "N"),
        "method": "circles: voltage balance, " + ("full shape" if one.full else "level, stiffness, C and T_d"),
        "covariance": estimates.covariance,
    }
    content: dict[str, Any] = {"axis": axis.name, "motion": axis.motion, "static": estimates.static}
    if estimates.negative is not None:
        content["static_negative"] = estimates.negative
    content |= {"gms": estimates.gms, "gms_fit": text}
    return FrictionDocument.made(content, notices=one.warnings, also=_sources(tests)).tree()


def plant_tree(one: TunedAxis, tests: Sequence[MeasuredCircle]) -> dict[str, Any]:
    """Return the nominal plant that circles gave an axis as a plant document."""
    estimates, axis = one.estimates, one.axis
    assert estimates is not None
    content = {"axis": axis.name, "motion": axis.motion, **estimates.plant}
    return PlantDocument.made(content, also=_sources(tests)).tree()
