import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fric.cli.main import app
from fric.control.scheme import PAPER_SCHEMES
from fric.documents.schemes import read_schemes
from fric.errors import FricError
from fric.io.circle import read_runs

RUN = CliRunner()
MACHINE = Path("configs/xy-table.yaml").resolve()


def circle(*words: str, machine: Path = MACHINE) -> str:
    done = RUN.invoke(app, ["simulate", "circle", str(machine), *words])
    if done.exception is not None:
        raise done.exception
    return done.stdout


def test_the_table_shows_the_six_schemes_beside_the_paper_s_values() -> None:
    lines = [line.split() for line in circle().splitlines() if line.startswith("(")]
    assert [line[0] for line in lines] == [f"({name})" for name in "abcdef"]
    assert [float(line[-1]) for line in lines] == [22, 7, 6, 8, 5, 3]


def test_paper_s_values_stand_beside_its_own_circle_alone() -> None:
    assert "paper" not in circle("--scheme", "a", "--radius", "20 mm").replace("of the paper", "")


def test_one_axis_alone_and_the_direction_are_told() -> None:
    printed = circle("--scheme", "a", "--axis", "x", "--clockwise")
    assert "at 100 mm/s, clockwise, x alone; glitches in µm" in printed
    assert len(printed.splitlines()[1].split()) == 9  # the paper's values are those of both axes


def test_json_and_run_file_tell_the_same(tmp_path: Path) -> None:
    out = tmp_path / "run.h5"
    told = json.loads(circle("--scheme", "a,f", "--clockwise", "--json", "-o", str(out)))
    assert (told["velocity"], told["radius"], told["direction"]) == (0.1, 0.03, -1)
    runs = {run.scheme.name: run for run in read_runs(out)}
    assert list(runs) == list(told["schemes"]) == ["a", "f"]
    for name, run in runs.items():
        found = told["schemes"][name]
        assert tuple(found["quadrants"]) == run.circularity.quadrants
        assert found["glitch"] == max(map(abs, run.circularity.quadrants))
        assert run.scheme == PAPER_SCHEMES[name]
        assert set(run.traces) == {"x", "y"}
        x, y = (run.traces[axis].position for axis in "xy")
        np.testing.assert_allclose(np.hypot(x, y)[-len(run.circularity.error) :] - 0.03, run.circularity.error)
    with pytest.raises(FricError, match="the output exists"):
        circle("-o", str(out))


def test_a_figure_is_drawn(tmp_path: Path) -> None:
    circle("--scheme", "a,c,f", "--plot", str(tmp_path / "figure.png"))
    assert (tmp_path / "figure.png").stat().st_size > 10_000


def test_the_schemes_of_the_file_are_those_of_the_paper_and_others_can_be_given(tmp_path: Path) -> None:
    assert read_schemes(Path("configs/schemes.yaml")) == PAPER_SCHEMES
    own = tmp_path / "schemes.yaml"
    own.write_text("fric: schemes/1\nschemes:\n  half: {title: half of it, friction: gms, gain: 0.5}\n")
    told = json.loads(circle("--schemes", str(own), "--json"))["schemes"]
    full = json.loads(circle("--scheme", "a,c", "--json"))["schemes"]
    assert full["c"]["glitch"] < told["half"]["glitch"] < full["a"]["glitch"]


def test_believed_friction_is_separate_from_true_friction(tmp_path: Path) -> None:
    nominal_friction = tmp_path / "x.yaml"
    text = "fric: friction/1\naxis: x\nstatic: {F_c: 105 N, F_s: 165 N, v_s: 1 mm/s, sigma: 40 N*s/m}\n"
    nominal_friction.write_text(text)
    words = ("--scheme", "a,b", "--json", "--gain", "1", "--axis", "x")
    own, same = (json.loads(circle(*words, *more))["schemes"] for more in ((), ("--friction", f"x={nominal_friction}")))
    assert own == same
    nominal_friction.write_text(text.replace("105 N", "10 N").replace("165 N", "10 N"))
    weak = json.loads(circle(*words, "--friction", f"x={nominal_friction}"))["schemes"]
    assert weak["a"] == own["a"]
    assert weak["b"]["glitch"] > 2 * own["b"]["glitch"]


def test_a_controller_of_its_own_is_used_and_told_by_its_type(tmp_path: Path) -> None:
    soft = tmp_path / "soft.yaml"
    soft.write_text(
        "fric: controller/1\naxis: x\nK_v: 60 1/s\nK_p: 40 V*s/m\nK_i: 800 V/m\n"
        "velocity_filter: 500 Hz\nsampling: 4 kHz\n"
    )
    words = ("--scheme", "a", "--axis", "x", "--json")
    stiff, weak = (json.loads(circle(*words, *more))["schemes"]["a"] for more in ((), ("--with", f"x={soft}")))
    assert weak["glitch"] > 2 * stiff["glitch"]
    with pytest.raises(FricError, match="controller of the linear axis x, and axis y"):
        circle("--with", f"y={soft}")
    with pytest.raises(FricError, match="not a file that a controller uses"):
        circle("--with", f"x={MACHINE}")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--radius", "0 mm"], "'0 mm' is not positive"),
        (["--velocity", "-1 mm/s"], "'-1 mm/s' is not positive"),
        (["--scheme", "g"], "no scheme 'g'"),
        (["--axis", "q"], "no axis 'q'"),
        (["--velocity", "100 mm"], "velocity"),
        (["--friction", "x.yaml"], "which axis"),
    ],
)
def test_what_cannot_be_run_is_told(words: list[str], told: str) -> None:
    with pytest.raises(FricError, match=told):
        circle(*words)


def test_no_revolution_is_a_wrong_usage() -> None:
    done = RUN.invoke(app, ["simulate", "circle", str(MACHINE), "--revolutions", "0"])
    assert done.exit_code == 2
    assert "revolutions" in done.output


@pytest.mark.parametrize(
    ("was", "now", "told"),
    [
        (
            '      K_f: {value: 548, unit: N/V, source: "[C] cal',
            '      #{source: "[C] cal',
            r"axis x: the force constant K_f",
        ),
        ("v_s: {value: 1, unit: mm/s", "v_s: {value: 1", r"line \d+: axes.x.friction.static.v_s.unit: is missing"),
        (
            "K_f: {value: 548, unit: N/V",
            "K_f: {value: 548, unit: N",
            r"line \d+: axes.x.plant.K_f: force per input cannot",
        ),
        ("k: {value: [99.94, 1.364", "k: {value: [-99.94, 1.364", r"line \d+: axes.x.friction.gms: k of 'gms'"),
        ("B: {value: 4.526", "B: {value: -4.526", "axis x: B of the plant is -4.526"),
        ("    observer:\n      filter: binomial2", "    observer:\n      filter: none", "'none' is no Q-filter"),
        ("axes:\n  x:", "axes:\n  z:", "two linear axes|no axis"),
    ],
)
def test_bad_machine_files_are_told(tmp_path: Path, was: str, now: str, told: str) -> None:
    text = MACHINE.read_text()
    assert was in text
    bad = tmp_path / "machine.yaml"
    bad.write_text(text.replace(was, now, 1))
    with pytest.raises(FricError, match=told):
        circle("--axis", "x", machine=bad)


def test_parts_in_files_of_their_own_must_be_of_the_axis(tmp_path: Path) -> None:
    text = MACHINE.read_text()
    start, end = text.index("    friction:\n"), text.index("    feedforward:\n")
    (tmp_path / "machine.yaml").write_text(text[:start] + "    friction: own.yaml\n" + text[end:])
    static = "static: {F_c: 105 N, F_s: 165 N, v_s: 1 mm/s}\n"
    body = static + "gms: {alpha: {value: [1.0], unit: '1'}, k: 100 N/um, C: 1e4 N/s}\n"
    for head, told in (
        ("axis: y\n", "linear axis y, and this is the linear axis x"),
        ("axis: x\nmotion: rotary\n", "N"),
    ):
        (tmp_path / "own.yaml").write_text("fric: friction/1\n" + head + body)
        with pytest.raises(FricError, match=told):
            circle(machine=tmp_path / "machine.yaml")
    (tmp_path / "own.yaml").write_text("fric: friction/1\naxis: x\n" + body)
    assert "(a)" in circle("--scheme", "a", machine=tmp_path / "machine.yaml")
    (tmp_path / "own.yaml").unlink()
    with pytest.raises(FricError, match=r"own.yaml: there is no such file"):
        circle(machine=tmp_path / "machine.yaml")


def test_a_feed_that_asks_for_more_voltage_than_the_drive_has_is_refused() -> None:
    """x needs √((v²/r)² + (A·v)²)/B besides friction: 9.1 + 0.3 V at 0.95 m/s, 10.5 + 0.3 V at 1.05 m/s."""
    for feed, refused in (("1.5 m/s", True), ("1.05 m/s", True), ("0.95 m/s", False)):
        words = ["simulate", "circle", str(MACHINE), "--scheme", "a", "--velocity", feed, "--revolutions", "3"]
        done = RUN.invoke(app, words)
        assert isinstance(done.exception, FricError) == refused, feed
        if refused:
            assert "axis x saturates: the motion needs" in str(done.exception)


def test_a_drive_that_saturates_on_the_way_is_told(tmp_path: Path) -> None:
    low = tmp_path / "machine.yaml"
    text = MACHINE.read_text()
    low.write_text(text.replace("limit: {value: 10, ", "limit: {value: 0.85, "))
    done = RUN.invoke(app, ["simulate", "circle", str(low), "--scheme", "b", "--gain", "2.5", "--json"])
    assert done.exit_code == 0, done.exception
    assert "axis x: The voltage is at its limit" in done.stderr
    assert json.loads(done.stdout)["schemes"]["b"]["warnings"]


def test_a_scheme_with_an_unknown_model_is_told(tmp_path: Path) -> None:
    own = tmp_path / "schemes.yaml"
    own.write_text("fric: schemes/1\nschemes:\n  k: {title: t, friction: gmss}\n")
    with pytest.raises(FricError, match="no such model; there are dahl, gms"):
        circle("--schemes", str(own))


def test_an_unstable_loop_is_told_with_its_margin_and_nothing_is_written(tmp_path: Path) -> None:
    bad = tmp_path / "machine.yaml"
    bad.write_text(MACHINE.read_text().replace("K_p: {value: 83.7", "K_p: {value: 837"))
    with pytest.raises(FricError, match=r"axis x is not stable: its gain margin is -\d+\.\d dB"):
        circle("-o", str(tmp_path / "run.h5"), machine=bad)
    assert [file.name for file in tmp_path.iterdir()] == ["machine.yaml"]


def test_a_path_is_followed_and_drawn(tmp_path: Path) -> None:
    angle = np.linspace(0, 2 * np.pi, 300)
    points = np.column_stack([40 * np.sin(angle), 20 * np.sin(2 * angle)])
    np.savetxt(tmp_path / "eight.csv", points, delimiter=",", header="x [mm],y [mm]", comments="")
    words = ["simulate", "path", str(MACHINE), str(tmp_path / "eight.csv"), "--scheme", "a,f", "--json"]
    done = RUN.invoke(app, [*words, "--plot", str(tmp_path / "figure.svg"), "-o", str(tmp_path / "run.h5")])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)["schemes"]
    assert [turn["axis"] for turn in told["a"]["reversals"]].count("y") == 4
    assert told["f"]["glitch"] < 0.3 * told["a"]["glitch"]
    assert (tmp_path / "figure.svg").exists()
    assert len(read_runs(tmp_path / "run.h5")) == 2
    table = RUN.invoke(app, words[:-1]).stdout
    assert table.count("turns at") == 6
