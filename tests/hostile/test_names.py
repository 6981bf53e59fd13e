"""Names that anyone's file gives: of axes, schemes, columns. None leaves its folder, or becomes a program."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import h5py
import pytest
from typer.testing import CliRunner

import fric
from fric.automatic.steps import Session, step
from fric.cli.completion import records
from fric.cli.main import app
from fric.documents.machine_files import MachineDocument
from fric.documents.schemes import read_schemes
from fric.documents.yaml import read_document, write_document
from fric.errors import FricError, require_name
from fric.export.base import remark
from fric.io.propose import proposal
from fric.output import written
from fric.report.view import environment
from fric.results.export import export_axis
from tests.command import fric as run
from tests.turns import in_turns

ROOT = Path(__file__).parents[2]
DATA = ROOT / "data"
STROKES = sorted((ROOT / "data" / "strokes").glob("*.csv"))
WORSE = [
    "../../escaped",
    "/etc/escaped",
    "x)\nM3 S9000\n(",
    "x */ system(0); /*",
    "x *) y := 1; (*",
    "[/]",
    "x" * 41,
    "\x1b[2J",
]
"""Axes whose names lead elsewhere, or end a comment."""


@pytest.mark.parametrize("name", WORSE)
def test_no_file_gives_an_axis_a_name_that_does_more(tmp_path: Path, name: str) -> None:
    with pytest.raises(FricError, match="not a name of an axis"):
        require_name(name)
    log = tmp_path / "log.h5"
    log.write_bytes((ROOT / "data" / "presliding-sine.h5").read_bytes())
    with h5py.File(log, "a") as file:
        file.attrs["axis"] = name
    with pytest.raises(FricError, match="not a name of an axis"):
        fric.read(log)
    with pytest.raises(FricError, match="not a name of an axis"):
        fric.ingest(*STROKES[:1], output=tmp_path / "again.h5", axis=name)
    machine = tmp_path / "machine.yaml"
    text = (ROOT / "configs" / "xy-table.yaml").read_text()
    assert "\n  x:\n" in text
    machine.write_text(text.replace("\n  x:\n", f"\n  {json.dumps(name)}:\n"))
    with pytest.raises(FricError, match="name of an axis"):
        read_document(machine, MachineDocument)


@pytest.mark.parametrize("name", ["x", "Y1", "Achse 1", "Ψ", "x-axis", "a.b", "table_2 left+right"])
def test_what_axes_are_called_is_a_name(name: str) -> None:
    assert require_name(name) == name


def test_a_log_with_a_hostile_axis_makes_auto_write_nothing_outside_its_folder(tmp_path: Path) -> None:
    log = tmp_path / "in" / "log.h5"
    log.parent.mkdir()
    log.write_bytes((ROOT / "data" / "constant-velocity.h5").read_bytes())
    with h5py.File(log, "a") as file:
        file.attrs["axis"] = "../../escaped"
    done = CliRunner().invoke(app, ["auto", str(log.parent), "-o", str(tmp_path / "a" / "b" / "out")])
    assert done.exit_code
    assert not list(tmp_path.rglob("escaped"))


SCHEMES = 'fric: schemes/1\nschemes:\n  f: {{title: "{}", friction: gms, observer: true}}\n'
WORSE_SCHEMES = {
    "c": 'a */ #include <evil.h> /*\\nint evil;\\" \\\\',
    "st": "a *) evil := TRUE; (*\\nevil",
    "linuxcnc": 'a */\\nevil\\"; evil',
    "sinumerik": "a\\nevil",
    "fmi": 'a */ \\" <evil/> ]]>\\nevil',
}


@pytest.mark.parametrize("target", WORSE_SCHEMES)
def test_the_title_of_a_scheme_stays_a_comment(tmp_path: Path, target: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Line by line the files are those of a scheme with an ordinary title; what circles leave hangs on none."""
    monkeypatch.setattr("fric.results.export.trust_of", lambda *given, **known: ([], []))
    monkeypatch.setattr("fric.export.sinumerik.glitches_of", lambda *given: lambda *run: 1e-6)

    def made(name: str) -> dict[str, str]:
        schemes = tmp_path / "schemes.yaml"
        schemes.write_text(SCHEMES.format(name))
        (scheme,) = read_schemes(schemes).values()
        found = export_axis(target, ROOT / "configs" / "xy-table.yaml", axis="x", scheme=scheme)
        return {file: content for file, content in found.files.items() if isinstance(content, str)}

    plain, worse = made("f2"), made(WORSE_SCHEMES[target])
    assert plain.keys() == worse.keys()
    for file, text in plain.items():
        assert len(text.splitlines()) == len(worse[file].splitlines())
        for one, other in zip(text.splitlines(), worse[file].splitlines(), strict=True):
            assert one == other or ("f2" in one and not re.search(r"\*/.*evil|\*\).*evil|\".*evil.*\".*evil", other))


def test_a_remark_ends_no_comment() -> None:
    assert remark('x */ y *) z ) ; \n # "q" \\ {{ <!-- é') == "x y z q < --"
    assert remark("static + observer, 0.6 ms") == "static + observer, 0.6 ms"


def test_a_mapping_that_is_proposed_holds_names_as_names(tmp_path: Path) -> None:
    path = tmp_path / "log.h5mat.mat"
    evil = 'pos", unit: "m"}\nfile: "x\x1b[2J'
    with h5py.File(path, "w", userblock_size=512) as file:
        for name in ("time", "position", evil):
            file.create_dataset(name, data=[[0.1 * n for n in range(50)]])
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file".ljust(512))
    text = proposal([path])
    assert all(one.isprintable() or one == "\n" for one in text)
    assert not [line for line in text.splitlines() if line.startswith(("file", "pos"))]


def test_the_shell_is_completed_by_plain_words_alone(tmp_path: Path) -> None:
    log = tmp_path / "log.h5"
    log.write_bytes((ROOT / "data" / "presliding-sine.h5").read_bytes())
    with h5py.File(log, "a") as file:
        for name in ("$(touch evil)", "a;evil", "a\nevil", "a b", "`evil`", "\x1b[2J"):
            file["records"].copy("presliding-sine-01", name)

    class Context:
        args, params = (str(log),), dict[str, str]()

    assert records(Context(), "") == ["presliding-sine-01", "presliding-sine-02"]  # type: ignore[arg-type]


def test_a_script_holds_names_of_files_as_words(tmp_path: Path) -> None:
    """A step that failed is a comment, and stays one where a file's name holds a line end."""
    evil = tmp_path / "a\ntouch evil\n.csv"
    evil.write_text("")

    def run(_: object) -> None:
        raise FricError("no")

    session = Session(tmp_path / "out", run, lambda _: None)
    session.take(step("x: ingest", "ingest", [evil], {}, output=tmp_path / "out" / "log.h5"))
    session.close()
    subprocess.run(["sh", str(session.folder / "steps.sh")], cwd=tmp_path, check=True, capture_output=True)
    assert not list(tmp_path.rglob("evil"))
    assert not Path("evil").exists()


HOSTILE = ("a\udcff", "b\x1b[31mX\x07", "c\nd", "h\x9b2J", "k\u2028l", "<script>", "*i*)'; rm")
"""Names of files that no encoding holds, that a terminal obeys, that end a line, a comment or a text."""


@pytest.mark.parametrize("name", HOSTILE)
def test_a_name_of_a_file_goes_everywhere_as_plain_text(tmp_path, monkeypatch, name):
    """Terminal, log file, document, report and code: a lone surrogate ended a report, an escape sequence went out."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "strokes" / "constant-velocity-09.csv", f"{name}.csv")
    told = [
        run("ingest", f"{name}.csv", "-o", f"{name}.h5").output,
        run("inspect", f"{name}.h5").output,
        run("inspect", f"{name}.h5", "--json").output,
    ]
    write_document(Path("a.yaml"), {"fric": "plant/1", "axis": "x", "provenance": {"command": name}})
    written(Path("a.html"), environment().from_string("<p>{{ title }}</p>").render(title=name))
    held = [Path("a.yaml").read_text(), Path("a.html").read_text(), *told]
    assert all(one.isprintable() or one == "\n" for text in held for one in text)
    assert "<script>" not in held[1]


@cache
def strokes_map() -> fric.StaticResult:
    return fric.identify_static(fric.read(DATA / "constant-velocity.h5")[::3])


@pytest.mark.parametrize("name", in_turns(["\ud800", "a\0b", "\ud800/x.yaml"], ["a\0b", "\ud800/x.yaml"]))
@pytest.mark.parametrize("call", [
    lambda name: fric.write_machine(fric.read_machine("xy-table"), name),
    lambda name: strokes_map().save(name),
    lambda name: fric.read(name),
    lambda name: fric.read_machine(name),
    lambda name: fric.circle(Path(name), "a"),
    lambda name: fric.auto(DATA / "constant-velocity.h5", output=name),
    lambda name: fric.auto(name, output="found"),
    lambda name: fric.diagnose(name),
], ids=["write_machine", "save", "read", "read_machine", "circle", "output", "logs", "diagnose"])  # fmt: skip
def test_a_name_that_no_file_has_is_refused_by_every_verb(tmp_path, monkeypatch, call, name):
    """A lone surrogate and a null ended in tracebacks of most of them."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FricError, match="holds a character that no file's name has"):
        call(name)
    assert not list(tmp_path.iterdir())
