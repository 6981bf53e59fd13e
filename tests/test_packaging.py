"""What others install fric with says what pyproject.toml says, and their checks are ours."""

from __future__ import annotations

import tomllib
from pathlib import Path

import fric
from fric.documents.yaml import plain, read_tree

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PYTHONS = [one.rpartition(" ")[2] for one in PROJECT["classifiers"] if ":: Python :: 3." in one]


def test_the_conda_recipe_asks_for_the_same_libraries() -> None:
    recipe = plain(read_tree(ROOT / "packaging" / "recipe.yaml"))
    asked = {one.replace(" ", "").replace("matplotlib-base", "matplotlib") for one in recipe["requirements"]["run"]}
    assert asked == {*PROJECT["dependencies"], f"python{PROJECT['requires-python']}"}
    assert recipe["package"]["version"] == PROJECT["version"] == fric.__version__
    assert recipe["build"]["python"]["entry_points"] == [f"fric = {PROJECT['scripts']['fric']}"]


def test_the_workflow_runs_what_ci_runs_on_each_python() -> None:
    (job,) = plain(read_tree(ROOT / ".github" / "workflows" / "ci.yml"))["jobs"].values()
    assert [step["run"] for step in job["steps"] if "run" in step] == ["bash .ci/run"]
    assert job["strategy"]["matrix"]["python"] == PYTHONS
    assert f">={PYTHONS[0]}" == PROJECT["requires-python"]


def test_the_container_has_what_the_wheel_is_made_of() -> None:
    build = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    text = (ROOT / "packaging" / "Containerfile").read_text()
    copied = {name for line in text.splitlines() if line.startswith("COPY") for name in line.split()[1:-1]}
    needed = {Path(path).parts[0] for path in build["only-include"]}
    assert needed | {"pyproject.toml", PROJECT["readme"], *PROJECT["license-files"]} <= copied
    assert all((ROOT / name).exists() for name in copied)


def test_who_made_it_is_said_alike() -> None:
    cited = plain(read_tree(ROOT / "CITATION.cff"))
    assert (cited["authors"], cited["version"], cited["license"]) == (
        PROJECT["authors"], PROJECT["version"], PROJECT["license"],
    )  # fmt: skip
