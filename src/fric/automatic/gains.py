"""The gains of an axis' controller in `auto`: given, found on a circle or in a closed-loop record, or asked for."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fric.automatic.sources import Source, Sources
from fric.automatic.steps import Session, step
from fric.circles.gains import USUAL
from fric.documents.controller import ControllerDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.io.circle import choose_circles
from fric.io.questions import Ask, Question
from fric.units import Motion, rotates

EXAMPLE = "K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m"  # Gains as a text
_GAIN = re.compile(r"(K_v|K_p|K_i|velocity_filter|sampling)\s*[=: ]\s*([^,;=]+)")
_AXIS = re.compile(r"\s*(\w[\w.+-]*)\s*:\s*(?=K_)")


@dataclass(frozen=True)
class Stated:
    """Gains that were stated, by axis: files, and texts; a text without an axis holds for all."""

    files: Mapping[str, Path]
    texts: Mapping[str, str]

    @classmethod
    def of(cls, given: Iterable[Path | str]) -> "Stated":
        """Sort what was given into files of controllers, and texts like `EXAMPLE` with the axis before a colon."""
        files, texts = dict[str, Path](), dict[str, str]()
        for item in given:
            if ("=" in str(item) or _GAIN.search(str(item))) and not Path(item).exists():
                named = _AXIS.match(str(item))
                texts[named[1] if named else ""] = str(item)[named.end() if named else 0 :]
            else:
                files[read_document(item, ControllerDocument).axis] = Path(item)
        return cls(files, texts)


def gains_of(text: str, axis: str, motion: Motion) -> dict[str, Any]:
    """Return the controller document of gains in a text; filter and sampling have their defaults where it has none.

    Raises FricError: When a gain is missing, or has a wrong unit.
    """
    length = "rad" if rotates(motion) else "m"
    units = {"K_v": "1/s", "K_p": f"V*s/{length}", "K_i": f"V/{length}", "velocity_filter": "Hz", "sampling": "Hz"}
    given = {"velocity_filter": f"{USUAL.velocity_filter} Hz", "sampling": f"{USUAL.sampling} Hz"}
    given |= {name: value.strip() for name, value in _GAIN.findall(text)}
    given = {name: value if re.search("[a-zA-Z]", value) else f"{value} {units[name]}" for name, value in given.items()}
    content: dict[str, Any] = {"fric": ControllerDocument.type_name(), "axis": axis, "motion": motion} | given
    try:
        return ControllerDocument.model_validate(content).tree()
    except ValidationError:
        raise FricError(f"'{text}' are no gains of axis {axis}", hint=f"Write them as '{EXAMPLE}'.") from None


def find_gains(
    session: Session, found: Sources, logs: Sequence[Source], stated: Stated, ask: Ask | None, *, needed: bool
) -> Path | None:
    """Return the file of an axis' gains; None where they were neither given nor found.

    ask: Asks the user, where gains are needed and no log shows them.
    """
    axis, motion = logs[0].axis, logs[0].motion
    if file := stated.files.get(axis) or found.controllers.get(axis):
        return file
    typed, made = session.folder / axis / "gains.yaml", session.folder / axis / "controller.yaml"
    if (text := stated.texts.get(axis, stated.texts.get(""))) is not None:
        session.write(gains_of(text, axis, motion), typed)
        return typed
    for path in found.circles:
        for test in choose_circles([path]):
            trace = test.axes.get(axis)
            if trace is None or trace.input is None or trace.reference is None or test.scheme not in ("", "a"):
                continue
            if session.take(step(f"{axis}: gains", "identify controller", [path], {"axis": axis}, output=made)):
                return made
    driven = [log.path for log in logs if log.driven]
    if driven and (needed or any("motion" in log.kinds for log in logs)):
        closed = step(f"{axis}: gains", "identify controller", driven, {"axis": axis}, output=made)
        if session.take(closed, tried=True):
            return made
    if typed.exists():
        return typed
    if needed and ask is not None:
        answer = list[dict[str, Any]]()
        ask(_question(axis, motion, answer))
        if answer:
            session.write(answer[0], typed)
            return typed
    return None


def _question(axis: str, motion: Motion, answer: list[dict[str, Any]]) -> Question:
    """Return the question for the gains of an axis; the document of the typed gains goes into ``answer``."""

    def understood(text: str) -> dict[str, Any] | None:
        try:
            return gains_of(text, axis, motion)
        except FricError:
            return None

    def apply(meant: dict[str, Any]) -> None:
        answer.extend([meant] if meant else [])

    text = f"No log shows the gains of axis {axis}. Type those of its controller, as {EXAMPLE}"
    return Question(
        text, [("not known: fric designs them, and its result is for these", {})], apply, understood=understood
    )
