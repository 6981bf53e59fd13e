"""A session: a folder, the ordinary commands that were run in it, and what came of each."""

import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fric.apart import run_python
from fric.automatic.sources import Sources
from fric.automatic.steps import PARTS, Step, axis_steps, ingest_steps
from fric.documents.yaml import dump, plain, read_tree, write_document
from fric.errors import FricError
from fric.flaws.files import FILE_UNUSED, STEP_FAILED
from fric.output import staged
from fric.reproduce.step_cache import StepCache

Run = Callable[[Sequence[str]], None]
"""Runs one command, its words without ``fric``; raises a `FricError` where it fails."""


def run_apart(words: Sequence[str]) -> None:
    """Run a command in a process of its own."""
    done = run_python("from fric.cli.main import main\nmain()", *words)
    if done.returncode:
        message = done.stderr.decode(errors="replace").strip().removeprefix("error: ")
        raise FricError(message or f"ended with status {done.returncode}")


class Session:
    """One run: its folder, its script, and what came of each step."""

    def __init__(self, folder: Path, run: Run, say: Callable[[str], None]) -> None:
        self.folder, self.run, self.say = folder, run, say
        self.shop = StepCache(folder)
        self.script = ["#!/bin/sh", "# What `fric auto` ran, to be run again by hand."]
        self.script += ["set -eu", f"cd {shlex.quote(str(Path.cwd()))}"]
        self.steps = self.made = 0
        self.failed: dict[str, str] = {}

    def take(self, one: Step) -> bool:
        """Run a step unless it is up to date; return whether what it leaves is there."""
        if not one.ready:
            return False
        self.steps += 1
        text = shlex.join(["fric", *one.words])
        for path in one.leaves:
            path.parent.mkdir(parents=True, exist_ok=True)

        def make() -> None:
            self.say(f"$ {text}")
            self.run(one.words)

        try:
            self.made += self.shop.step(
                one.name, make, reads=one.reads, leaves=one.leaves, settings={"words": list(one.words)}
            )
        except FricError as error:
            self.failed[one.name] = str(error).replace("\n", ". ")
            self.script.append(f"# failed: {' '.join(text.splitlines())}")
            return False
        self.script.append(text)
        return True

    def write(self, tree: dict[str, Any], path: Path) -> None:
        """Write a document, and the lines of the script that write it."""
        known = plain(read_tree(path)) if path.exists() else {}
        if known.get("axes") != tree["axes"]:
            write_document(path, tree, force=True)
        self.script += [f"cat > {shlex.quote(str(path))} <<'END'", dump(tree).rstrip(), "END"]

    def close(self) -> None:
        """Write the script."""
        with staged(self.folder / "steps.sh", force=True) as draft:
            draft.write_text("\n".join(self.script) + "\n", encoding="utf-8")


def identify_axes(session: Session, found: Sources, *, lean: bool = False) -> dict[str, dict[str, Any]]:
    """Ingest and identify; return by axis what was done, what is missing, its files and its log files.

    Parameters
    ----------
    session
        Where the steps are run.
    found
        The logs.
    lean
        Identify alone: no figures, no controller, no observer.
    """
    logs = [one for one in found.logs if one.mapping is None]
    for one, left in ingest_steps(found.logs, session.folder):
        if session.take(one):
            logs.append(left)
        else:
            found.description.append(STEP_FAILED.found(one.name, why=session.failed.get(one.name, "failed")))
    axes: dict[str, dict[str, Any]] = {}
    for name in sorted({one.axis for one in logs}):
        own = [one for one in logs if one.axis == name]
        plan = axis_steps(own, session.folder / name, lean=lean)
        read = {path for one in plan.steps for path in one.reads}
        for unused in (log for log in own if log.path not in read):
            found.description.append(FILE_UNUSED.found(str(unused.path), kinds=sorted(unused.kinds), axis=name))
        done = [one.name.partition(": ")[2] for one in plan.steps if session.take(one)]
        of_axis = [(key.partition(": "), why) for key, why in session.failed.items()]
        broken = [f"{what}: {why}" for (whose, _, what), why in of_axis if whose == name]
        files = {part: session.folder / name / f"{part}.yaml" for part in PARTS}
        if "gms" not in done and "static" in done:
            files["friction"] = session.folder / name / "static.yaml"
        missing = [*plan.missing, *broken]
        axes[name] = {"done": done, "missing": missing, "files": files, "logs": [one.path for one in own]}
        axes[name]["motion"] = own[0].motion
    return axes
