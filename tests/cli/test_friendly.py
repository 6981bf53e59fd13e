"""What a user meets beside the numbers: completion, examples, pages, full disks, Ctrl-C, endings of names."""

import json
import os
import re
import signal
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from resource import RLIMIT_FSIZE, setrlimit
from time import sleep

import pytest
from typer.testing import CliRunner

import fric
from fric import units
from fric.cli import console, main
from fric.cli.command import Command
from fric.cli.commands import COMMANDS, IDENTIFY
from fric.cli.main import app
from fric.control.scheme import choose_schemes
from fric.documents import bundled
from fric.documents.machine_files import MachineDocument
from fric.documents.mapping import MappingDocument
from fric.documents.plant import PlantDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.process import tried

ROOT = Path(__file__).parents[2]
RUN = CliRunner()

UNWRITTEN = "error: standard output cannot be written: {}\nSend it to another file or disk.\n"


def run(*words, **given):
    return subprocess.run(["fric", *words], text=True, stderr=subprocess.PIPE, check=False, **given)


def completed(warm, *words):
    environment = warm | {
        "_FRIC_COMPLETE": "complete_bash", "COMP_WORDS": " ".join(["fric", *words]), "COMP_CWORD": str(len(words)),
    }  # fmt: skip
    return run(stdout=subprocess.PIPE, env=environment, cwd=ROOT).stdout.split()


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["simulate", "circle", "xy-table", "--scheme", ""], ["a", "b", "c", "d", "e", "f", "all"]),
        (["simulate", "circle", "xy-table", "--schemes", "configs/literature.yaml", "--scheme", "rep"], ["repetitive"]),
        (["simulate", "experiment", "xy-table", "--axis", ""], ["x", "y"]),
        (["schema", "fri"], ["friction"]),
        (["export", "c", "xy-table", "--axis", "x", "--scheme", ""], ["a", "b", "c", "d", "e", "f", "all"]),
        (["learn", "xy-table", "--scheme", "b"], ["b"]),
        (["compare", "data/presliding-sine.h5", "--fit-on", "p"], ["presliding-sine-01", "presliding-sine-02"]),
        (["help", "fo"], ["formats"]),
        (["example", "xy"], ["xy-table-identified", "xy-table"]),
        (["simulate", "experiment", "no-such-machine", "--axis", ""], []),
        (["simulate", "experiment", "xy-table", "--kind", "m"], ["micro-steps"]),
        (["simulate", "circle", "xy"], ["xy-table-identified", "xy-table"]),
        (["export", "li"], ["linuxcnc"]),
        (["design", "block", "kal"], ["kalman"]),
        (["identify", "replay", "sine.h5", "--model", "d"], ["dahl"]),
    ],
)  # fmt: skip
def test_completion(words, found, warm):
    assert completed(warm, *words) == found


def test_the_example_goes_where_it_is_told_and_is_whole(tmp_path):
    done = RUN.invoke(app, ["example", "-o", str(tmp_path / "try")])
    assert done.exit_code == 0
    assert len(list((tmp_path / "try/data/strokes").glob("*.csv"))) == 17
    assert fric.read_machine(tmp_path / "try/configs/virtual-rig.yaml").axes.keys() == {"x", "y"}
    strokes = min((tmp_path / "try/data/strokes").iterdir())
    mapped = fric.ingest(strokes, output=tmp_path / "log.h5", mapping=tmp_path / "try/mapping.yaml")
    assert mapped.done.samples > 500
    assert isinstance(RUN.invoke(app, ["example", "-o", str(tmp_path / "try")]).exception, FricError)  # it is there


def test_every_bundled_document_is_an_example_with_what_it_names(tmp_path):
    for name, kind in bundled.examples().items():
        made = fric.example(name, output=tmp_path / name)
        if kind == "machine":
            (path,) = (one for one in (tmp_path / name).rglob(f"{name}.yaml"))
            assert fric.read_machine(path).axes, made
    with pytest.raises(FricError, match="Is it xy-table"):
        fric.example("xytable", output=tmp_path / "none")


def test_pages_are_listed_shown_and_guessed():
    listed = RUN.invoke(app, ["help"]).output.splitlines()
    assert [line.split()[0] for line in listed] == list(bundled.topics())
    assert RUN.invoke(app, ["help", "limits"]).output == (ROOT / "docs/limits.md").read_text(encoding="utf-8")
    assert "Is it limits?" in str(RUN.invoke(app, ["help", "limts"]).exception)
    assert RUN.invoke(app, ["help", "gms"]).output.startswith("GMS model: ")  # a word of the glossary, in any case
    assert "no page 'word'" in str(RUN.invoke(app, ["help", "word"]).exception)  # the head of its table is none


@pytest.mark.parametrize(("asked", "terms"), [
    ("Coulomb friction", ["Coulomb friction F_c"]), ("static FRICTION", ["static friction F_s"]),
    ("presliding", ["pre-sliding"]), ("delay", ["delay T_d"]), ("f_C", ["Coulomb friction F_c"]),
    ("quadrant glitch", ["glitch (quadrant glitch)"]), ("K_i", ["velocity gains K_p, K_i"]),
])  # fmt: skip
def test_terms_and_symbols_of_the_glossary_have_pages(asked, terms):
    assert [line.partition(":")[0] for line in RUN.invoke(app, ["help", asked]).output.splitlines()] == terms


def test_the_meaning_of_a_code_fits_a_terminal():
    for code in ("records-vary", "strokes-swing", "implausible-speed"):
        assert max(map(len, RUN.invoke(app, ["help", code]).output.splitlines())) <= 80
    assert "Is it Coulomb friction F_c?" in str(RUN.invoke(app, ["help", "couloumb friction"]).exception)


@pytest.mark.parametrize("words", [["schema", "friction"], ["ingest", "--list"]])
def test_a_full_standard_output_is_told_in_a_line(words, warm):
    with Path("/dev/full").open("w") as full:
        done = run(*words, stdout=full, env=warm)
        assert done.returncode == 1
        assert done.stderr == UNWRITTEN.format("No space left on device")
        assert subprocess.run(["fric", *words], stdout=full, stderr=full, env=warm, check=False).returncode == 1


def test_a_standard_output_that_may_not_grow_is_told_in_a_line(warm, tmp_path):
    """As a file beyond `ulimit -f`, or on a file system of small files."""
    with (tmp_path / "out.json").open("w") as short:
        done = run("schema", "friction", stdout=short, env=warm, preexec_fn=lambda: setrlimit(RLIMIT_FSIZE, (0, -1)))
        assert done.stderr == UNWRITTEN.format("File too large")


@pytest.mark.parametrize(
    ("words", "better"),
    [
        (["identify", "static", "LOG", "-o", "static.h5"], "Call it static.yaml."),
        (["identify", "static", "LOG", "-o", "static.yaml", "--plot", "a.yaml"], "Call it a.png."),
        (["simulate", "circle", "xy-table", "-o", "run.yaml"], "Call it run.h5."),
        (["simulate", "experiment", "xy-table", "--kind", "sliding-sine", "-o", "log.csv"], "Call it log.h5."),
        (["ingest", "LOG", "-o", "log.yaml"], "Call it log.h5."),
        (["report", "LOG", "-o", "page.pdf"], "Call it page.html."),
        (["learn", "xy-table", "--rounds", "1", "-o", "run.png"], "Call it run.h5."),
    ],
)
def test_an_ending_that_means_another_format_is_refused_before_any_work(tmp_path, monkeypatch, words, better):
    monkeypatch.chdir(tmp_path)
    error = RUN.invoke(
        app, [str(ROOT / "data/constant-velocity.h5") if word == "LOG" else word for word in words]
    ).exception
    assert isinstance(error, FricError)
    assert "and the name ends in" in error.what
    assert error.hint == better
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("words", "within"), [
    ("identify gms data/presliding-sine.h5 --blocks 6 -o OUT", "fric.identify.gms.identify._blocks"),
    ("plan --stroke 0.3m --feed 0.1m/s --machine xy-table -o OUT", "fric.simulate.experiment.run_axis"),
    ("learn xy-table --rounds 1 -o OUT", "fric.results.circles.learn_rounds"),
    ("tune xy-table data/sliding-sine.h5 -o OUT", "fric.results.circles.some_circles"),
    ("reproduce -o OUT", "fric.simulate.experiment.run_axis"),
    ("auto data/constant-velocity.h5 -o OUT", "fric.results.identify.fit_static"),
    ("auto FLEET -o OUT --workers 1", "fric.automatic.fleet.identify_axes"),
])  # fmt: skip
def test_ctrl_c_ends_with_130(tmp_path, monkeypatch, capsys, words, within):
    """The real signal through the real handler, in the middle of the work: a fit before its blocks are counted."""
    begun = []

    def interrupting(*_, **__):
        begun.append(os.kill(os.getpid(), signal.SIGINT))
        pytest.fail("it went on")

    date = tmp_path / "fleet" / "machine" / "2026-01-01"
    date.mkdir(parents=True)
    (date / "x.h5").symlink_to(ROOT / "data/constant-velocity.h5")
    out = tmp_path / {"identify": "friction.yaml", "learn": "run.h5"}.get(words.split()[0], "out")
    given = {"OUT": out, "FLEET": date.parents[1]}
    monkeypatch.setattr(sys, "argv", ["fric", *(str(given.get(one, one)) for one in words.split())])
    monkeypatch.chdir(ROOT)
    module, _, name = within.rpartition(".")
    monkeypatch.setattr(import_module(module), name, interrupting)
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        with pytest.raises(SystemExit) as ended:
            main.main()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert begun == []  # the signal came within the call
    assert ended.value.code == 130
    assert "interrupted" in capsys.readouterr().err
    assert not [one for one in tmp_path.rglob("*") if one.is_file() and not one.is_symlink() and out not in one.parents]
    assert not out.is_file()


def test_a_folder_hides_no_bundled_name(tmp_path, monkeypatch):
    """`fric auto … -o emps` reads its logs with the mapping of that name."""
    monkeypatch.chdir(tmp_path)
    for kind, name in (("machine", "xy-table"), ("mapping", "emps")):
        (tmp_path / name).mkdir()
        assert bundled.located(Path(name), kind) == bundled.bundled(kind)[name]
        (tmp_path / name).rmdir()
        (tmp_path / name).write_text("")
        assert bundled.located(Path(name), kind) == Path(name)
    (tmp_path / "found").mkdir()
    (tmp_path / "found/machine.yaml").write_text("")
    assert bundled.located(Path("found"), "machine") == Path("found/machine.yaml")


def test_the_bundled_documents_read():
    for kind in bundled.KINDS:
        for path in bundled.bundled(kind).values():
            from fric.documents import document_types

            assert read_document(path, document_types()[kind])


@pytest.mark.parametrize(("words", "told"), [
    (["identify", "lugr", "log.h5"], "no command 'lugr'. Is it lugre?"),
    (["inspct", "log.h5"], "no command 'inspct'. Is it inspect?"),
    (["design", "controller", "p.yaml", "--phase-margin", "60"], "T_d: is missing"),
    (["ingest", "p.yaml", "-o", "log.h5"], "p.yaml: is a plant file, and a log file is needed"),
    (["simulate", "circle", "xy-table", "--friction", "f.yaml"], "Write it as x=f.yaml"),
    (["simulate", "experiment", "xy-table", "constant-velocity", "-o", "log.h5"], "unexpected extra argument"),
])  # fmt: skip
def test_a_mistake_is_answered_with_its_place_and_its_mend(words, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("p.yaml").write_text("fric: plant/1\naxis: x\nA: {value: 1, unit: 1/s}\n")
    done = RUN.invoke(app, words)
    assert done.exit_code in {1, 2}
    assert told in " ".join(f"{done.output} {done.exception}".split())


def test_an_angle_without_its_unit_is_taken_for_degrees():
    with pytest.raises(FricError, match="as in '60 deg'"):
        units.parse("60", "angle")


def test_blocks_are_listed_as_json_too():
    found = json.loads(RUN.invoke(app, ["design", "block", "list", "--json"]).stdout)
    assert (found["fric"], found["warnings"], found["warnings_coded"]) == ("blocks/1", [], [])
    assert {"name": "kalman", "kind": "observer", "linear": True}.items() <= next(
        block for block in found["blocks"] if block["name"] == "kalman"
    ).items()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["simulate", "circle", "xy-table", "--scheme", "a c"], "Take all, or some as 'a,c' of a, b, c"),
        (["inspect", "nowhere.h5"], "It was looked for in "),
        (["inspect", "."], "or use `fric auto`"),
        (["simulate", "path", "xy-table", "one.csv"], "Head the columns 'x [mm], y [mm]'."),
        (["auto", "note.pdf", "-o", "found"], "`fric ingest --list` lists the formats"),
        (["auto", "zero.csv", "-o", "found"], "the file is empty"),
        (["export", "machine.yaml", "c", "--axis", "x", "-o", "code"], "`fric export linuxcnc machine.yaml`"),
        (["export", "c", "xy-table", "--axis", "x", "--lead", "1 mm", "-o", "code"], "--lead: time cannot be in 'mm'"),
        (["export", "c", "xy-table", "--axis", "x", "--lead", "1 mm", "-o", "code"], "Write '1 ms'."),
        (["plan", "--stroke", "50 mm", "--feed", "50 mm", "-o", "plan"], "--feed: velocity cannot be in 'mm'"),
    ],
)
def test_first_mistakes_are_told_with_what_mends_them(tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    Path("one.csv").write_text("force\n1\n2\n")
    Path("note.pdf").write_text("%PDF-1.4\n")
    Path("zero.csv").write_text("")
    error = RUN.invoke(app, words).exception
    assert told in str(error)


def test_a_long_value_that_is_no_choice_is_cut(monkeypatch, capsys):
    """A value of 5,000 letters was told whole."""
    monkeypatch.setattr("sys.argv", ["fric", "design", "observer", "p.yaml", "--filter", "9" * 5000])
    with pytest.raises(SystemExit) as ended:
        main.main()
    assert (ended.value.code, len(capsys.readouterr().err) < 1500) == (2, True)


def test_a_value_that_is_no_choice_is_told_with_the_choices_once(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["fric", "ingest", "one.csv", "--kind", "cv"])
    with pytest.raises(SystemExit):
        main.main()
    told = capsys.readouterr().err
    assert told.count("holding-map") == 1
    assert "Value error" not in told


@pytest.mark.parametrize("words", [["tune", "m.yaml", "c.h5"], ["export", "c", "m.yaml", "-o", "k"], ["auto"]])
def test_what_is_missing_of_a_command_is_shown_by_an_example(monkeypatch, capsys, words):
    monkeypatch.setattr("sys.argv", ["fric", *words])
    with pytest.raises(SystemExit):
        main.main()
    assert f"\nExample: fric {words[0]} " in capsys.readouterr().err


def test_a_pipe_gets_no_trailing_blanks():
    shown = RUN.invoke(app, ["ingest", "--list"]).output.splitlines()
    assert len(shown) > 9
    assert shown == [line.rstrip() for line in shown]


def test_a_pipe_gets_lines_of_progress(monkeypatch, capsys):
    """Also while one run takes long: a path of 75 s of processor said nothing before its end."""
    monkeypatch.setattr(console, "EVERY", 0.4)
    with console.progress("fitting") as advance:
        tried("x: plant")
        sleep(0.6)
        advance(total=4)
        sleep(0.4)
    assert capsys.readouterr().err.splitlines() == ["fitting: 0 s (x: plant)", "fitting: 25 %, 1 s (x: plant)"]


@pytest.mark.parametrize("words", [[], ["identify"], ["simulate"]])
def test_a_group_alone_prints_its_help_line_by_line(words, monkeypatch, capsys):
    """It was one paragraph, cut in its middle."""
    monkeypatch.setattr(sys, "argv", ["fric", *words])
    with pytest.raises(SystemExit) as ended:
        main.main()
    shown = capsys.readouterr().err
    assert ended.value.code == 2
    assert shown.startswith("Usage: ")
    assert len(shown.splitlines()) > 10
    assert "…" not in shown


def test_a_working_folder_that_is_gone_is_said(tmp_path, monkeypatch, capsys):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    monkeypatch.setattr("sys.argv", ["fric", "inspect", "nowhere.h5"])
    with pytest.raises(SystemExit):
        main.main()
    assert "is not there any more" in capsys.readouterr().err


def test_a_backend_that_is_none_does_no_harm(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "nonsense")
    monkeypatch.setattr("sys.argv", ["fric", "schema", "friction"])
    with pytest.raises(SystemExit):
        main.main()
    assert "MPLBACKEND" not in os.environ


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--monte-carlo", "many"], "'--monte-carlo': give a whole number: Run"),
        (["--gain", "high"], "'--gain': give a number: Gain"),
        (["--monte-carlo", "0"], "give at least 1: Run"),
        (["--scheme", "a", "b"], "written with commas, as 'a,b'"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_in_words_of_the_user(words, said, capfd, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["fric", "simulate", "circle", "xy-table", *words])
    with pytest.raises(SystemExit):
        main.main()
    printed = " ".join(capfd.readouterr().err.split())
    assert said in printed, printed
    assert "Input" not in printed


@pytest.mark.parametrize(("words", "said"), [(["log.h5", "--models", "gms", "dahl"], True), (["dahl"], False)])
def test_a_word_behind_the_value_of_an_option_may_be_another(words, said, tmp_path, capfd, monkeypatch):
    """It was said of any missing folder."""
    (tmp_path / "log.h5").write_bytes((ROOT / "data/sliding-sine.h5").read_bytes())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["fric", "compare", *words])
    with pytest.raises(SystemExit):
        main.main()
    printed = capfd.readouterr().err
    assert "dahl: there is no such file" in printed
    assert ("with commas" in printed) == said


def test_a_similar_name_is_of_a_document_of_the_type_that_is_wanted(tmp_path):
    (tmp_path / "plan.yaml").write_text("fric: plant/1\n")
    (tmp_path / "planted.yaml").write_text('"fric" : "machine/1"\n')
    for model, name in ((MachineDocument, "planted.yaml"), (PlantDocument, "plan.yaml"), (MappingDocument, "")):
        with pytest.raises(FricError) as found:
            read_document(tmp_path / "plante.yaml", model)
        assert found.value.hint.startswith(f"Is it {name}?" if name else "It was looked for")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["ingest", "log.csv", "--kind", "constant-velocty", "-o", "log.h5"], "Is it constant-velocity?"),
        (["plan", "--stroke", "300", "-o", "plan"], "'300' has no unit"),
        (["plan", "--stroke", "300 mm", "-o", "plan"], "--feed is missing"),
        (["--json", "auto"], "No such option: --json. Options of a command follow its name"),
        (["foo"], "Commands: example, auto,"),  # in the order of the help
        (["plan", "--stroke", "9 mm", "--feed", "9 mm/s", "--accuracy", "F_s=2", "-o", "plan"], "as F_s=2%"),
    ],
)
def test_an_error_says_what_lacks_or_is_meant(words, said, capfd, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["fric", *words])
    with pytest.raises(SystemExit):
        main.main()
    printed = " ".join(capfd.readouterr().err.split())
    assert said in printed, printed


def test_a_comma_behind_the_last_scheme_is_no_scheme():
    assert [scheme.name for scheme in choose_schemes("c, ")] == ["c"]
    assert [scheme.name for scheme in choose_schemes("a,c,")] == ["a", "c"]


def test_each_command_says_in_its_bar_what_it_does():
    """An empty text left a bar without a word, as that of export."""

    def commands(homes, of=""):
        for name, home in homes.items():
            if isinstance(home, Command):
                yield f"{of}{name}", home

    made = {**dict(commands(COMMANDS)), **dict(commands(IDENTIFY, "identify "))}
    quick = {
        "example",
        "inspect",
        "schema",
        "help",
        "auto",
        "export",
        "ingest",
        "report",
    }  # auto and export say theirs elsewhere
    assert not [name for name, command in made.items() if not command.doing and name not in quick]


def test_no_option_asks_for_the_name_of_a_type(warm):
    shown = run("simulate", "circle", "-h", stdout=subprocess.PIPE, env=warm).stdout
    assert "--seed N" in shown
    assert not re.search(r"<(int|float|str)", shown)


def test_a_path_beyond_what_the_system_takes_is_refused_with_its_mend(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["fric", "design", "controller", "9" * 400])
    with pytest.raises(SystemExit):
        main.main()
    assert "Give a shorter path" in capsys.readouterr().err


@pytest.mark.parametrize("option", [["-o"], ["-o", "a.h5", "--propose"]])
def test_an_option_is_no_file(option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("time [s],position [mm]\n0,0\n1,1\n")
    found = RUN.invoke(app, ["ingest", "a.csv", *option, "--json"])
    assert "'--json' is an option, and no file" in str(found.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_a_mapping_that_goes_to_a_dash_is_printed(tmp_path, monkeypatch):
    """It was written to a file named `-`."""
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{n},{n * n % 7},{n % 5}\n" for n in range(60))
    (tmp_path / "a.csv").write_text("time,position,current\n" + rows)
    text = RUN.invoke(app, ["ingest", "a.csv", "--propose", "-"]).stdout
    assert text.startswith("fric: mapping/1")
    assert "wrote" not in text
    found = json.loads(RUN.invoke(app, ["ingest", "a.csv", "--propose", "-", "--json"]).stdout)
    assert (found["fric"], found["warnings"], found["mapping"].strip()) == ("proposal/1", [], text.strip())
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]
