"""Command lines with words that are none: each ends with status 0, 1 or 2, and nothing that moves the cursor."""

from __future__ import annotations

import io
import json
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from unicodedata import category

import numpy as np

ROOT = Path(__file__).parents[2]
KNOWN = {
    "STROKE": "data/strokes/constant-velocity-01.csv",
    "LOG": "data/constant-velocity.h5",
    "MAP": "configs/mappings/emps.yaml",
    "SINE": "data/presliding-sine.h5",
    "RESPONSE": "data/frequency-response.h5",
    "PLANT": "tests/documents/before/plant.yaml",
    "FRICTION": "tests/documents/before/gms.yaml",
}
"""Files that command lines name."""
ODD = (
    "[/]", "[red]", "\x1b[2J", "a\nb", "", " ", "-", "--", "nan", "inf", "-1", "0", "1e12", "1e-12", "1e300 m", "1 s",
    "1e12 Hz", "-5 mm", "0 mm", "9" * 400, "x" * 5000, "m**9**9**9", "../..", "/dev/null", "/dev/zero", ".", "1 kHz",
    "a" * 300 + ".yaml", "=", "x=", "=x", "a,,b", ",", "1:2", "\u2026", "\u202e", "\udcff", "{0}", "%s", "1,2", "1 N",
    "$(touch evil)", "none", "all", "auto",
)  # fmt: skip
"""What stands in place of a word."""


class AbsurdError(AssertionError):
    """A result that cannot be, without a warning."""


def changed_words(source: Path, rng: np.random.Generator) -> bytes:
    """Return a command line of a file of them, one or two of its words changed, left out or doubled, as JSON."""
    lines = source.read_text(encoding="utf-8").splitlines()
    words = lines[int(rng.integers(len(lines)))].split()
    for _ in range(int(rng.integers(1, 3))):
        at, what = int(rng.integers(1, len(words))), rng.random()
        if what < 0.85:
            words[at] = ODD[int(rng.integers(len(ODD)))]
        elif what < 0.95 and len(words) > 2:
            del words[at]
        else:
            words.insert(at, words[at])
    return json.dumps(words).encode()


def run_words(path: Path) -> None:
    """Run a command line in an empty folder, and judge how it ends; an error in its words is status 2."""
    from fric.cli.main import main

    words = json.loads(path.read_bytes())
    heard = io.StringIO()
    with TemporaryDirectory() as folder, chdir(folder), redirect_stdout(heard), redirect_stderr(heard):
        Path("circle.csv").write_text("x_ref [mm],y_ref [mm],x_pos [mm],y_pos [mm]\n" + "2,0,2,0\n" * 9)
        Path("path.csv").write_text("x [mm],y [mm]\n" + "".join(
            f"{2 * np.cos(a):.5f},{np.sin(a):.5f}\n" for a in np.linspace(0, 2 * np.pi, 60)
        ))  # fmt: skip
        named = {name: str(ROOT / file) for name, file in KNOWN.items()} | {"CIRCLE": "circle.csv", "PATH": "path.csv"}
        sys.argv = ["fric", *(named.get(word, word) for word in words)]
        try:
            main()
        except SystemExit as end:
            if end.code not in {None, 0, 1, 2}:
                raise AbsurdError(f"status {end.code} of {words}") from None
    lines = heard.getvalue().splitlines()
    first = next((n for n, line in enumerate(lines) if line.startswith("error:")), len(lines))
    if len(lines) - first > 3:
        raise AbsurdError(f"a message of {len(lines) - first} lines from {words}"[:300])
    if odd := {one for one in heard.getvalue() if category(one) == "Cc" and one not in "\n\t"}:
        raise AbsurdError(f"control characters {odd} from {words}"[:300])
