"""What is amiss with records: told where it is, by its size, and not told where it is not."""

from dataclasses import replace

import numpy as np
import pytest

from fric.documents.inspection import InspectionDocument
from fric.identify.plant.identify import identify_plant
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked
from fric.log import Log
from fric.records.flaws import blocks_lost, clock_flaws, stroke_flaws, timing
from fric.records.inspection import inspect
from fric.records.over_strokes import OverTime, along_axis, over_place, over_time
from fric.records.resolution import lattice_step
from fric.records.segments import steady_segments
from fric.reference import strokes

STEP = 1e-7
SPEEDS = (5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 14e-3, 20e-3, 30e-3)


def session(seed=0, *, jitter=0.0, lost=0.0, error=0.0, pitch=20e-6, cogging=0.0, wave=0.0, rate=0.0, noise=1.0):
    """Return strokes at eight speeds of an axis with 80 N of friction, each with what is amiss with it."""
    rng, logs, began = np.random.default_rng(seed), [], 0.0
    for n, speed in enumerate(SPEEDS):
        motion = strokes(speed, max(4e-3, speed), 2000.0)
        time = motion.time
        taken = time + jitter * rng.normal(size=len(time))
        z = np.interp(taken, time, motion.position)
        told = np.rint((z + error * np.sin(2 * np.pi * z / pitch)) / STEP) * STEP
        v = np.interp(taken, time, motion.velocity)
        level = 80.0 * (1.0 + wave * np.sin(2 * np.pi * z / 3.2e-3)) * np.exp(rate * (began + time))
        force = level * np.tanh(v / 1e-6) + 100.0 * v + cogging * np.sin(2 * np.pi * z / 5e-3 + 0.4)
        force += noise * rng.normal(size=len(time))
        kept = rng.uniform(size=len(time)) >= lost
        log = Log(
            time=time[: kept.sum()], position=told[kept], force=force[kept], name=f"s{n}", kind="constant-velocity"
        )
        logs.append(log)
        began += time[-1]
    return logs


def steady(logs):
    return [(log, segment) for log in logs for segment in steady_segments(log)]


@pytest.mark.parametrize("seed", range(5))
def test_nothing_is_told_of_records_without_flaws(seed: int) -> None:
    logs = session(seed)
    assert clock_flaws(logs, "plant") == []
    assert stroke_flaws(steady(logs), over_place(steady(logs))) == []


def test_a_jitter_of_nanoseconds_is_not_worth_a_word() -> None:
    t = np.arange(40_000) / 4000.0  # as printed digits make of the true position of a simulated axis
    z = 0.03 * np.sin(2 * np.pi * (t + 9e-9 * np.random.default_rng(0).normal(size=len(t))) / 1.885)
    assert timing(Log(time=t, position=z, name="circle")).jitter == 0.0


@pytest.mark.parametrize("jitter", [40e-6, 150e-6])
def test_jitter_is_told_by_its_size_where_the_position_shows_it(jitter: float) -> None:
    logs = session(jitter=jitter)
    sizes = [timing(log).jitter for log in logs]
    for speed, size in zip(SPEEDS, sizes, strict=True):
        if speed * jitter > 10 * STEP / np.sqrt(12):
            assert size == pytest.approx(jitter, rel=0.15)
        if speed * jitter < STEP / np.sqrt(12):
            assert size == 0.0
    (told,) = clock_flaws(logs, "plant")
    assert (told.code, told.severity) == ("sampling-jitters", "wrong")
    (told,) = clock_flaws(logs, "static")
    assert told.severity == "doubt"


def test_lost_samples_are_told_by_their_share() -> None:
    logs = session(lost=0.02)
    assert timing(logs[-1]).lost == pytest.approx(0.02, rel=0.4)
    (told,) = clock_flaws(logs, "static")
    assert (told.code, told.severity) == ("samples-lost", "wrong")


def test_gaps_that_the_time_tells_are_no_lost_samples() -> None:
    log = session()[-1]
    kept = np.random.default_rng(1).uniform(size=len(log)) >= 0.02
    cut = replace(log, time=log.time[kept], position=log.position[kept], force=log.force[kept])
    assert timing(cut).lost == 0.0
    assert timing(cut).jitter == 0.0


def test_cogging_and_friction_over_position_are_told_apart() -> None:
    cogged = over_place(steady(session(cogging=6.0)))
    assert cogged is not None
    assert cogged.cogging == pytest.approx(6.0 / np.sqrt(2), rel=0.2)
    assert cogged.friction < 0.4 * cogged.cogging
    waved = over_place(steady(session(wave=0.06)))
    assert waved is not None
    assert waved.friction == pytest.approx(80 * 0.06 / np.sqrt(2), rel=0.25)
    assert waved.cogging < 0.4 * waved.friction


def over_long_waves(share: float, wave: float, drift: float = 0.0) -> list[Log]:
    """Return strokes of 60 mm and less of an axis whose friction, of 40 N, changes over position, or in time."""
    rng, logs = np.random.default_rng(3), []
    for speed in np.array([0.5, 1, 2, 3, 5, 8, 12, 20, 30, 40]) * 1e-3:
        length = min(0.06, 6.0 * speed)
        t = np.arange(0.0, length / speed, max(length / speed / 2000, 1e-3))
        z, way = np.concatenate([speed * t, length - speed * t]), np.repeat([1.0, -1.0], len(t))
        time = np.concatenate([t, t + t[-1] + t[1]])
        friction = 40.0 * (1.0 + share * np.sin(2 * np.pi * (z + 0.01) / wave)) * (1.0 + drift * time) + 20e3 * speed**2
        force = friction * way + rng.normal(0.0, 0.5, len(z))
        logs.append(Log(time, z, force=force, kind="constant-velocity", name=f"{speed * 1e3:g}"))
    return logs


@pytest.mark.parametrize("wave", [0.04, 0.1, 0.2])
def test_friction_that_changes_in_waves_longer_than_the_travel_is_of_its_size(wave: float) -> None:
    """Each stroke was taken without its slope: of ±30 % in a wave of 100 mm 2.8 N of 12 N were said."""
    found = over_place(steady(over_long_waves(0.3, wave)))
    z = np.linspace(0.0, 0.06, 601)
    true = float(np.std(40.0 * 0.3 * np.sin(2 * np.pi * (z + 0.01) / wave)))
    assert found is not None
    assert found.friction == pytest.approx(true, rel=0.35)
    assert found.cogging < 0.4 * found.friction
    warned = [notice for notice in stroke_flaws(steady(over_long_waves(0.3, wave)), found, force=40.0, half_width=0.5)
              if notice.code == "friction-over-position"]  # fmt: skip
    assert [notice.values["share"] for notice in warned] == [pytest.approx(np.sqrt(2.0) * found.friction / 40.0)]


@pytest.mark.parametrize("drift", [0.01, -0.01])
def test_friction_that_changes_in_time_is_none_over_position(drift: float) -> None:
    found = over_place(steady(over_long_waves(0.0, 1.0, drift)))
    assert found is None or not found.friction


@pytest.mark.parametrize("rate", [-0.003, 0.002])
def test_drift_is_told_by_its_rate_and_place_is_not_taken_for_time(rate: float) -> None:
    """A slow stroke may be taken for one that settles: 3 of 48 sessions are unsure by it, and 5 of 6 in 1e-5."""
    found = [drift for seed in range(6) if (drift := over_time(steady(session(seed, rate=rate)))) is not None]
    assert all(drift.rate == pytest.approx(rate, abs=2 * drift.half) for drift in found)
    assert sum(drift.half < 0.3 * abs(rate) for drift in found) >= 2
    for other in ({"cogging": 6.0}, {"wave": 0.06}):
        assert over_time(steady(session(**other))) is None


def test_a_small_drift_is_sooner_sure_where_strokes_scatter_beyond_noise() -> None:
    """Of a motor that gives 1 % less as it warms up, 6 of 32 sessions were without a word, with F_c missed in each.

    Of 16 sessions 6 are sure by their slopes alone and 12 with the scatter; of 16 without a drift none is.
    """
    drifting, still = ([steady(session(seed, rate=rate)) for seed in range(8)] for rate in (0.0003, 0.0))
    alone = [found for strokes in drifting if (found := over_time(strokes)) is not None and found.sure]
    both = [found for strokes in drifting if (found := over_time(strokes, scattered=True)) is not None and found.sure]
    assert len(both) > len(alone)
    assert all(abs(found.rate - 0.0003) < 2 * found.half for found in both)
    assert [over_time(strokes, scattered=True) for strokes in still] == [None] * 8


def test_a_force_that_ripples_hides_no_drift() -> None:
    def rippling(rate: float, seed: int = 0) -> list[Log]:  # an axis that hunts between counts
        return [
            replace(log, force=log.force + 12.0 * np.sin(2 * np.pi * 73.0 * log.time))
            for log in session(seed, rate=rate, noise=0.3)
        ]

    found = over_time(steady(rippling(0.0007)))
    assert found is not None
    assert found.rate == pytest.approx(0.0007, abs=2 * found.half)
    assert all(over_time(steady(rippling(0.0, seed))) is None for seed in range(4))


def test_a_drift_goes_on_in_the_pauses_where_one_clock_tells_them() -> None:
    logs = session(1, rate=0.002)
    alone, clocked, began = over_time(steady(logs)), [], 0.0
    for log in logs:
        clocked.append(replace(log, time=began + log.time))
        began += 30.0 + log.time[-1]
    found = over_time(steady(clocked))
    assert alone is not None
    assert found is not None
    assert alone.duration == pytest.approx(sum(log.time[-1] for log in logs))
    assert found.duration == pytest.approx(alone.duration + 30.0 * (len(logs) - 1))
    assert found.rate == pytest.approx(alone.rate, rel=0.02)


@pytest.mark.parametrize(
    ("clocked", "sure", "severity"), [(True, True, "note"), (False, True, "doubt"), (True, False, "doubt")]
)
def test_a_small_drift_is_doubted_where_it_is_only_likely_or_went_on_unseen(
    clocked: bool, sure: bool, severity: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Warm-up in pauses of 40 s put F_s off by 10 % in silence: 0.9 % over the records alone, at 3.2 errors of it."""
    found = OverTime(-0.0001, 0.00008, 60.0, clocked, sure)
    monkeypatch.setattr("fric.records.flaws.over_time", lambda _, **given: found)
    (notice,) = stroke_flaws(steady(session())[:1], None, force=80.0, half_width=0.1)
    assert (notice.code, notice.severity) == ("force-drifts", severity)
    assert ("may drift" in notice) == (not sure)
    assert ("in pauses" in notice) == (not clocked)


def test_a_force_that_rises_along_the_axis_is_taken_off() -> None:
    """A spring of 300 N/m: slow strokes stay at its beginning, and F_c was 78.5 (0 to 79.3) for 80."""

    def sprung(stiffness: float, seed: int) -> list[Log]:
        return [replace(log, force=log.force + stiffness * log.position) for log in session(seed, noise=0.3)]

    assert along_axis(steady(session(noise=0.3))) is None
    for seed in range(3):
        rises, half = along_axis(steady(sprung(300.0, seed))) or (0.0, 0.0)
        assert rises == pytest.approx(300.0, abs=2 * half)
        fit = identify_static(sprung(300.0, seed), Asked())
        assert fit.static is not None
        assert float(fit.static.estimates["F_c"]) == pytest.approx(80.0, abs=0.02)
        assert float(fit.static.estimates["offset"]) == pytest.approx(300.0 * 15.69e-3, abs=0.05)  # there
        told = {w.code: w.severity for w in fit.warnings}
        assert told["force-along-axis"] == "note"
        assert "wrong" not in told.values()


def test_a_force_that_rises_one_way_and_falls_the_other_is_no_drift_of_friction() -> None:
    """An offset and a gain that both creep: |force| rises in every stroke forwards, and falls faster backwards."""
    logs = []
    for log in session():
        forward = np.gradient(log.position, log.time) > 0
        logs.append(replace(log, force=log.force * (1.0 + np.where(forward, 0.002, -0.008) * log.time)))
    assert over_time(steady(logs)) is None
    both = [replace(log, force=log.force * (1.0 - 0.004 * log.time)) for log in session()]
    assert (found := over_time(steady(both))) is not None
    assert found.rate == pytest.approx(-0.004, rel=0.2)


def test_a_force_that_settles_within_strokes_is_no_drift() -> None:
    logs = []
    for log in session():
        there = np.abs(np.gradient(log.position, log.time)) > 0
        since = np.cumsum(there) / 2000.0
        logs.append(replace(log, force=log.force * (1.0 + 0.2 * np.exp(-since / 0.3))))
    assert over_time(steady(logs)) is None


def test_what_varies_is_wrong_where_the_interval_of_the_map_does_not_hold_it() -> None:
    fit = identify_static(session(rate=-0.003, noise=0.2), Asked())
    drifts = [w for w in fit.warnings if getattr(w, "code", "") == "force-drifts"]
    assert [w.severity for w in drifts] == ["wrong"]
    fine = identify_static(session(noise=0.2), Asked())
    assert not [w for w in fine.warnings if getattr(w, "severity", "") == "wrong"]


def test_inspect_tells_what_a_record_tells() -> None:
    found = inspect(session(jitter=150e-6)[-1])
    assert [w.code for w in found.warnings] == ["sampling-jitters"]
    (plain,) = InspectionDocument.made({"records": [found]}).tree()["records"]
    assert plain["warnings_coded"][0]["code"] == "sampling-jitters"
    assert plain["warnings"][0] == plain["warnings_coded"][0]["text"]


def test_a_response_that_jitter_spoils_is_refused_with_its_cause() -> None:
    from fric.errors import FricError

    rng, dt = np.random.default_rng(0), 2.5e-4
    time = dt * np.arange(16_000)
    position = np.interp(time + 1e-4 * rng.normal(size=len(time)), time, 0.03 * time)
    voltage = np.sin(2 * np.pi * 40 * time)
    log = Log(
        time=time,
        position=np.rint(position / STEP) * STEP,
        input=voltage,
        force=210 * voltage,
        kind="frequency-response",
    )
    with pytest.raises(FricError) as error:
        identify_plant([log])
    assert "off the logged time" in error.value.hint


@pytest.mark.parametrize("identify", ["static", "gms", "plant", "dahl"])
def test_every_identify_judges_a_record_alike(identify: str) -> None:
    """A force that is clipped, a clock that jitters: what `inspect` says of a record, each identify says too."""
    from fric.errors import FricError
    from fric.identify.gms.identify import identify_gms
    from fric.identify.plant.identify import identify_motion
    from fric.identify.replay.replay_fit import identify_by_replay
    from fric.identify.static_map.identify import identify_static
    from fric.records.prepared import prepared
    from tests.identify.presliding import pair

    if identify == "static":
        logs = [replace(log, force=np.clip(log.force, -80.0, 80.0)) for log in session()]
        with pytest.raises(FricError, match="the force is clipped in each stroke"):
            identify_static(logs, Asked())
        logs = [replace(log, force=np.clip(log.force, -83.0, 83.0)) for log in session()]
        warnings = identify_static(logs, Asked()).warnings
    else:
        logs = [replace(log, force=np.clip(log.force, -120.0, 120.0)) for log in pair(step=0.0, noise=0.5)]
        if identify == "gms":  # whose stiffness begins where the force is largest
            with pytest.raises(FricError, match="the force is clipped"):
                identify_gms(logs)
            return
        warnings = {
            "plant": lambda: identify_motion([replace(log, kind="motion") for log in logs]).warnings,
            "dahl": lambda: identify_by_replay("dahl", prepared(logs)).warnings,
        }[identify]()  # type: ignore[no-untyped-call]
    assert any(w.code == "force-clipped" and w.severity == "wrong" for w in warnings)


def test_a_creep_in_counts_too_fine_to_be_seen_in_a_fast_stroke_is_no_loss() -> None:
    """Of 4,194,304 counts a turn "3.2 % of the samples were lost" at 1000 rpm: the end of a stroke crept 1 or 2."""
    rng, t = np.random.default_rng(4), np.arange(4000) * 1e-3
    speed = np.where((t < 0.1) | (t > 1.9) & (t < 2.1), 0.0, np.where(t < 2.0, 7e4, -7e4))
    speed[t > 3.6] = 1.4 + 0.1 * np.sin(9.0 * t[t > 3.6])  # counts a sample, after the last stroke
    true = np.cumsum(np.convolve(speed, np.full(40, 1 / 40), "same") + 30.0 * rng.normal(size=len(t)) * (t < 3.6))
    counts = np.rint(true)
    assert timing(Log(time=t, position=1.5e-6 * counts)).lost == 0.0
    kept = rng.uniform(size=len(t)) >= 0.02
    assert timing(Log(time=t[: kept.sum()], position=1.5e-6 * counts[kept])).lost == pytest.approx(0.02, rel=0.4)


@pytest.mark.parametrize("speed", [1e-3, 5e-3, 20e-3])
def test_noise_of_a_sensor_that_is_there_at_rest_is_no_jitter(speed: float) -> None:
    """An oscilloscope's even samples of a noisy displacement sensor were "203 µs (rms) off the logged time"."""
    motion = strokes(speed, max(4e-3, 2 * speed), 1000.0)
    rest = np.full(500, motion.position[-1])
    z = np.concatenate([motion.position, rest, motion.position, rest])
    z = np.rint((z + 1e-6 * np.random.default_rng(2).normal(size=len(z))) / 2e-7) * 2e-7
    assert timing(Log(time=np.arange(len(z)) * 1e-3, position=z)).jitter == 0.0


def test_counts_that_a_log_rounds_are_no_jitter() -> None:
    """Counts of 11.98 µrad, printed in whole µrad, were taken for samples 5 to 8 µs off the logged time."""
    rng, t, step = np.random.default_rng(3), np.arange(30_000) * 2e-3, 2 * np.pi / 2**19
    z = sum(rng.uniform(0.05, 0.2) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in (0.11, 0.23, 0.41, 0.67))
    z = np.round(np.rint(z / step) * step, 6)
    assert lattice_step(z) == pytest.approx(step, rel=1e-3)
    assert timing(Log(time=t, position=z)).jitter == 0.0


def test_blocks_of_lost_samples_beneath_an_even_clock_are_told() -> None:
    """Position and reference jump along their motion: F_c was 16.8 (15.5 … 18.2) for 12 N, without a word."""
    whole = session()[-1]
    log = replace(whole, reference=whole.position)
    assert blocks_lost(log) == 0.0
    kept = np.ones(len(log), bool)
    for start in range(300, len(log) - 400, 900):
        kept[start : start + 120] = False
    broken = replace(log, **{name: values[kept] for name, values in log.channels().items() if name != "time"},
                     time=log.time[: kept.sum()])  # fmt: skip
    assert blocks_lost(broken) == pytest.approx(1.0 - kept.mean(), rel=0.25)
    (told,) = (flaw for flaw in clock_flaws([broken], "static") if flaw.code == "samples-lost")
    assert told.severity == "wrong"
    again = replace(log, **{name: np.roll(getattr(log, name), len(log) // 2) for name in ("reference", "position")})
    assert blocks_lost(again) == 0.0  # records behind each other: it jumps back, not along
