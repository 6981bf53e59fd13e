"""`fric identify MODEL`, `fric compare` and `fric validate` from the command line, on bundled logs."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fric.cli.commands import MODELS
from fric.cli.main import app
from fric.documents.friction import FrictionDocument
from fric.documents.yaml import read_document
from fric.errors import FricError
from fric.friction import models

ROOT = Path(__file__).parents[2]
LOOPS = ROOT / "data/presliding-sine.h5"


RUN = CliRunner()


def fric(*words):
    return RUN.invoke(app, [str(word) for word in words])


def test_every_model_that_can_be_identified_has_a_subcommand():
    assert set(MODELS) == {name for name, model in models().items() if model.identified}


def test_help_needs_neither_numpy_nor_a_compiler():
    code = "import sys, fric.cli.main; print([m for m in ('numpy', 'numba', 'scipy', 'nlopt') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.parametrize("words", [["--help"], ["identify", "static", "--help"], ["simulate", "-h"], ["auto", "-h"]])
def test_help_of_a_command_imports_no_verb(words):
    heavy = ("numpy", "numba", "fric.friction", "fric.documents", "fric.results.identify", "fric.automatic.run")
    code = f"import sys, fric.cli.main as m\ntry:\n m.app({words})\nfinally:\n print(set(sys.modules) & {{*{heavy}}})"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert told.startswith("Usage")
    assert told.endswith("set()\n")


def test_a_table_of_schemes_loads_nothing_that_it_does_not_use():
    words = ["simulate", "circle", "configs/xy-table.yaml", "--scheme", "f", "--radius", "5 mm", "--json"]
    assert fric(*words).exit_code == 0  # what is compiled is in the cache now
    code = f"import sys, fric.cli.main as m\ntry:\n m.app({words})\nfinally:\n print(sorted(sys.modules))"
    for _ in range(2):  # a test that compiles beside this one may take an entry out of the index of the cache
        loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'fric.kernels.loop'" in loaded
    heavy = (
        "h5py",
        "pandas",
        "matplotlib",
        "rich.progress",
        "scipy.linalg",
        "scipy.optimize",
        "scipy.interpolate",
        "scipy.signal",
        "numba.np.linalg",  # of Numba's compiler
    )
    assert [name for name in heavy if f"'{name}'" in loaded] == []


def test_a_model_is_written_and_read_again(tmp_path):
    out, figure = tmp_path / "friction.yaml", tmp_path / "loops.png"
    words = ["identify", "lugre", LOOPS, "-o", out, "--fix", "sigma=180 N*s/m", "--plot", figure]
    told = fric(*words, "--json")
    assert told.exit_code == 0, told.exception
    printed = json.loads(told.stdout)
    model = read_document(out, FrictionDocument).friction("lugre")
    assert model.sigma_0 == pytest.approx(printed["lugre"]["sigma_0"]["value"], rel=1e-5)
    assert model.static.sigma == 180.0
    assert printed["static"]["sigma"]["fixed"]
    assert len(printed["lugre_fit"]["records"]) == 2
    assert figure.stat().st_size > 10_000
    again = fric(*words)
    assert isinstance(again.exception, FricError)
    assert "--force" in again.exception.hint
    kept = fric("identify", "dahl", LOOPS, "--static", out, "-o", tmp_path / "both.yaml")
    assert kept.exit_code == 0, kept.exception
    both = read_document(tmp_path / "both.yaml", FrictionDocument)
    assert both.friction("lugre") == model
    assert both.friction("dahl").sigma_0 > 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["identify", "lugre", LOOPS, "-o", "x.yaml", "--fix", "n=1"], "no parameter 'n'"),
        (["identify", "lugre", LOOPS, "-o", "x.yaml", "--fix", "sigma_0=1 N"], "cannot be in 'N'"),
        (["identify", "replay", "--model", "x", LOOPS, "-o", "x.yaml"], "no friction model 'x'"),
        (["compare", LOOPS, "--models", "dahl,x"], "no friction model 'x'"),
        (["compare", LOOPS, "--models", "dahl", "--fit-on", "x"], "no record 'x'"),
        (["compare", LOOPS, "--fit-on", "presliding-sine-01", "--cycles", "2"], "two ways to split"),
    ],
)
def test_what_cannot_be_done_is_told(tmp_path, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    done = fric(*words)
    assert isinstance(done.exception, FricError)
    assert told in str(done.exception)
    assert not list(tmp_path.iterdir())


def test_a_process_ends_with_status_1_and_no_traceback(tmp_path, warm):
    words = ["identify", "lugre", LOOPS, "-o", tmp_path / "x.yaml", "--fix", "n=1"]
    done = subprocess.run(["fric", *map(str, words)], env=warm, check=False, capture_output=True, text=True)
    assert done.returncode == 1
    assert "no parameter 'n'" in done.stderr
    assert "Traceback" not in done.stderr


def test_one_record_scores_a_fit_to_the_other():
    words = ["--models", "dahl,static", "--fit-on", "presliding-sine-01", "--json"]
    found = json.loads(fric("compare", LOOPS, *words).stdout)
    assert list(found["models"]) == ["dahl", "static"]
    assert list(found["models"]["dahl"]["records"]) == ["presliding-sine-02"]
    assert found["winner"] == "dahl"
