"""What a clipped force, a coarse encoder and coarse counts of the force do to what is claimed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.errors import FricError
from fric.log import Log
from fric.records.flaws import record_flaws
from fric.records.resolution import clipped_samples

DATA = Path(__file__).parents[2] / "data"
STATIC = fric.StaticMap(F_c=60.6, F_s=91.6, v_s=2.2e-3, sigma=1180.0)


def sines() -> list[Log]:
    return list(fric.read(DATA / "presliding-sine.h5"))


@pytest.mark.parametrize(
    "verb", [lambda logs: fric.identify_gms(*logs, static=STATIC), lambda logs: fric.identify_model("lugre", *logs)]
)
def test_no_stiffness_is_claimed_of_a_clipped_force(verb) -> None:
    """It gave 16 to 22 N/µm for 38, with narrow intervals and without a word."""
    cut = [replace(log, force=np.clip(log.force, -60.0, 60.0)) for log in sines()]
    with pytest.raises(FricError, match=r"the force is clipped in 1777 samples .* stiffness are not known"):
        verb(cut)


def test_a_clipped_record_beside_a_whole_one_is_left_out_and_told() -> None:
    small, large = sines()
    mixed = fric.identify_gms(small, replace(large, force=np.clip(large.force, -60.0, 60.0)), blocks=3, refine=False)
    alone = fric.identify_gms(small, blocks=3, refine=False)
    assert mixed.document["gms"]["k"]["value"] == alone.document["gms"]["k"]["value"]
    assert "clipped-unused" in {one["code"] for one in mixed.document["warnings_coded"]}
    few = replace(small, force=np.minimum(small.force, np.quantile(small.force, 0.92)))
    found = fric.identify_model("dahl", few, large, fix={"n": 1.0})
    assert any(one["code"] == "clipped-unused" for one in found.document["warnings_coded"])


def test_strokes_whose_force_is_cut_are_left_out_of_the_map() -> None:
    """Twelve of 17 strokes were cut at 70 N: F_c was 73 (70 … 76) for 63, and a scheme was recommended."""
    logs = fric.read(DATA / "constant-velocity.h5")
    whole = fric.identify_static(*logs)

    def cut(limit: float) -> fric.StaticResult:
        return fric.identify_static(*(replace(log, force=np.clip(log.force, -limit, limit)) for log in logs))

    for limit in (75.0, 85.0):  # F_c was 69.6 (66.9 … 71.9) at 75 N
        found = cut(limit)
        severity = {one["code"]: one["severity"] for one in found.document["warnings_coded"]}
        assert (severity["clipped-unused"], severity["force-clipped"]) == ("doubt", "wrong")
        for name in ("F_c", "F_s"):
            low, high = getattr(found, name).ci95
            assert low < float(getattr(whole, name)) < high
    with pytest.raises(FricError, match="the force is clipped in all but 2 strokes"):
        cut(70.0)
    with pytest.raises(FricError, match="the force is clipped in each stroke"):
        cut(60.0)


def test_coarse_counts_of_a_force_are_no_clipping() -> None:
    for log in [*fric.read(DATA / "constant-velocity.h5"), *sines()]:
        for count in (25.0, 10.0):
            assert clipped_samples(np.round(log.force / count) * count) == 0
    assert all(channel["clipped"] == 0 for log in sines()
               for channel in fric.inspect(log).document["records"][0]["channels"].values())  # fmt: skip
    fine = sines()[1].force
    for limit in (40.0, 60.0, 80.0):  # a trace of 10 bits that is too short
        count = 2 * limit / 1024
        assert clipped_samples(np.clip(np.round(fine / count) * count, -limit, limit)) > 0.2 * len(fine)


def test_a_flat_end_in_few_steps_is_a_doubt() -> None:
    """Of clean strokes and sines rounded to 41 steps 3 % were said to be clipped and wrong, to 200 and more 0.2 %."""
    t = np.arange(2000) / 1000.0
    force = 50.0 * np.tanh(8.0 * np.sin(2 * np.pi * t)) + 0.05 * np.random.default_rng(0).standard_normal(2000)

    def severity(force: np.ndarray) -> list[str]:
        found = record_flaws([Log(t, position=np.sin(2 * np.pi * t), force=force, name="one")], "inspect")
        return [one.severity for one in found if one.code == "force-clipped"]

    step = 100.0 / 44
    assert severity(np.round(force / step) * step) == ["doubt"]  # a plateau within a step
    assert severity(np.clip(force, -40.0, 40.0)) == ["wrong"]
    assert severity(np.clip(np.round(force / 0.3) * 0.3, -36.0, 36.0)) == ["wrong"]  # eight bits
    assert severity(force) == []


@pytest.mark.parametrize("held", [5, 8, 16])
def test_a_force_that_comes_at_a_slower_rate_is_no_clipping(held: int) -> None:
    """A current of 250 Hz in a log of 2 kHz: each peak is held, and every identification was refused."""
    (log,) = fric.read(DATA / "frequency-response.h5")
    for force in (log.force, *(one.force for one in sines())):
        assert clipped_samples(np.repeat(force, held)) == 0
        cut = 0.6 * float(np.abs(force).max())
        assert clipped_samples(np.repeat(np.clip(force, -cut, cut), held)) > 300


def test_coarse_counts_of_a_force_are_told() -> None:
    def codes(step: float) -> set[str]:
        logs = fric.read(DATA / "constant-velocity.h5")
        coarse = [replace(log, force=step * np.round(log.force / step)) for log in logs]
        return {one["code"] for one in fric.identify_static(*coarse).document["warnings_coded"]}

    assert "force-coarse" in codes(25.0)
    assert not {"force-coarse", "force-clipped"} & codes(1.0)


@pytest.mark.parametrize("step", [20.0, 25.0, 28.0, 40.0])
def test_intervals_of_coarse_counts_hold_the_truth(step: float) -> None:
    """It gave F_s 98 (93 to 103) at 25 N, and 84 to the last digit at 28."""
    coarse = [replace(log, force=step * np.round(log.force / step)) for log in fric.read(DATA / "constant-velocity.h5")]
    static = fric.identify_static(*coarse).document["static"]
    for name, true in (("F_c", STATIC.F_c), ("F_s", STATIC.F_s)):
        low, high = static[name].get("ci95", (-np.inf, np.inf))
        assert low <= true <= high
        assert high - low >= step


@pytest.mark.parametrize("step", [20.0, 28.0])
def test_counts_that_are_coarse_beside_friction_are_told_where_ramps_take_many(step: float) -> None:
    """Inertia alone took the range of the force over twelve counts, and nothing was said."""
    coarse = []
    for log in fric.read(DATA / "constant-velocity.h5"):
        force = step * np.round(log.force / step)
        force[:6] = step * np.array([7.0, 8.0, 9.0, -7.0, -8.0, -9.0])  # a jerk of the ramp, in no stroke
        coarse.append(replace(log, force=force))
    found = fric.identify_static(*coarse).document
    assert "force-coarse" in {one["code"] for one in found["warnings_coded"]}
    for name, true in (("F_c", STATIC.F_c), ("F_s", STATIC.F_s), ("v_s", STATIC.v_s)):
        low, high = found["static"][name]["ci95"]
        assert low <= true <= (np.inf if high is None else high)


def test_a_clipped_multisine_is_told() -> None:
    """Its crests are short: K_f came out as 143.0 ± 0.9 N/V for 150 without a word."""
    (log,) = fric.read(DATA / "frequency-response.h5")
    cut = 0.6 * float(np.abs(log.force).max())
    assert clipped_samples(np.clip(log.force, -cut, cut)) > 600
    assert clipped_samples(log.force) == 0
    found = fric.identify_plant(replace(log, force=np.clip(log.force, -cut, cut)))
    assert {"force-clipped": "wrong"}.items() <= {
        one["code"]: one["severity"] for one in found.document["warnings_coded"]
    }.items()
    assert "K_f" not in found.fit.estimates  # nor is a number shown that the clipped force makes


def test_an_encoder_too_coarse_for_slow_strokes_leaves_no_break_away_force() -> None:
    """With counts of 50 µm the strokes below 2 mm/s are gone; F_s came out as 113 (103 … 124) for 91.6."""
    coarse = [
        replace(log, position=50e-6 * np.round(log.position / 50e-6))
        for log in fric.read(DATA / "constant-velocity.h5")
    ]
    found = fric.identify_static(*coarse)
    F_s = found.document["static"]["F_s"]
    codes = {one["code"]: one["severity"] for one in found.document["warnings_coded"]}
    holds = "ci95" in F_s and F_s["ci95"][0] <= 91.6 <= F_s["ci95"][1]
    assert holds or codes.get("F_s-extrapolated") == "wrong" or "assumed" in F_s
    whole = fric.identify_static(*fric.read(DATA / "constant-velocity.h5"))
    assert "F_s-extrapolated" not in {one["code"] for one in whole.document["warnings_coded"]}


@pytest.mark.parametrize(
    "absurd",
    [
        lambda: fric.circle("xy-table", "a", revolutions=10**6),
        lambda: fric.circle("xy-table", "a", velocity=1e-9),
        lambda: fric.experiment("xy-table", "presliding-sine", frequency=1e-12),
        lambda: fric.experiment("xy-table", "constant-velocity", speeds=[1e-15]),
        lambda: fric.design_controller(plant_document(), sampling=1e12),
        lambda: fric.design_controller(plant_document(T_d="10 s"), sampling=4000.0),
        lambda: lifted_controller(plant_document(T_d="10 s")),
    ],
)
def test_absurd_settings_end_in_an_error_before_memory_does(absurd) -> None:
    with pytest.raises(
        FricError, match=r"simulated at most|no frequency that a machine has|no servo loop closes|400 are at most"
    ):
        absurd()


def lifted_controller(plant):
    with fric.lifted():
        return fric.design_controller(plant, sampling=4000.0)


def plant_document(T_d: str = "0.6 ms"):
    from fric.documents.plant import PlantDocument

    return PlantDocument.made({"axis": "x", "A": "28 1/s", "B": "4.5 m/(s^2*V)", "T_d": T_d, "K_f": "548 N/V"})
