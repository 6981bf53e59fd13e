"""The bench of corrections: what it leaves out is left out, and what it counts is what sessions say."""

import pytest

from benchmarks.reality.ablation import ALL, NAMES, OFF, earned, section, warned, warnings_section
from benchmarks.reality.bench import Outcome, Row
from benchmarks.reality.judge import Number, Step, judged_static
from benchmarks.reality.session import Sessions
from fric.identify.static_map.corrections import AT_ANY_SPEED, OF_A_MAP
from fric.notice import Notice


@pytest.mark.parametrize("name", [*AT_ANY_SPEED, *OF_A_MAP])
def test_a_correction_is_left_out_and_comes_back(name):
    table = AT_ANY_SPEED if name in AT_ANY_SPEED else OF_A_MAP
    before = dict(table)
    with OFF[name]():
        assert set(table) == set(before) - {name}
    assert list(table.items()) == list(before.items())


def session(**steps: Step) -> dict:
    whole = Step({"F_c": Number(10.0, 9.0, 11.0, 10.5)})
    return {"machine": "cogging", "seed": 0,
            "steps": {name: steps.get(name, whole).as_dict() for name in (ALL, *NAMES[1:])}}  # fmt: skip


def test_what_is_counted_is_what_the_sessions_say():
    narrow = Step({"F_c": Number(10.0, 9.9, 10.1, 10.5)}, [Notice("", "strokes-scatter", "doubt")])
    told = Step({"F_c": Number(10.0, 9.9, 10.1, 10.5)}, [Notice("", "force-over-position", "wrong")])
    by_name = {one.name: one for one in earned([session(place=narrow, settling=told)])}
    place, settling, swing = (by_name[name] for name in ("place", "settling", "swing"))
    assert (place.covered, place.silent, place.codes) == ((1, 0), (0, 1), {"strokes-scatter": 1})
    assert (settling.covered, settling.silent) == ((1, 0), (0, 0))  # this machine's flaw is named
    assert place.width == pytest.approx(0.1)
    assert (swing.changed, swing.covered, swing.width) == ((), (1, 1), 1.0)
    assert "| place | `cogging` | 1 of 1 → 0 of 1 | 0 → 1 | 0.10 | strokes-scatter +1 |" in section(
        [session(place=narrow)]
    )


def test_a_warning_earns_what_nothing_else_says():
    """Of three sessions that drift two are told: one by one code, and one by two, each of which the other replaces."""
    wrong = Number(10.0, 9.0, 11.0, 12.0)

    def outcome(seed: int, *codes: str) -> Outcome:
        notices = [Notice("", code, "wrong") for code in codes]
        return Outcome("drift", seed, {"plant": Step(), "static": Step({"F_c": wrong}, notices), "gms": Step()}, None)

    drift = Row("drift", (outcome(0, "force-drifts"), outcome(1, "force-drifts", "energy-drifts"), outcome(2)))
    swings = {"static": Step(notices=[Notice("", "strokes-swing", "note")])}
    clean = Row("clean", tuple(Outcome("clean", seed, swings, None) for seed in (0, 1)))
    found = {one.code: one for one in warned([drift, clean])}
    assert (found["force-drifts"].alone, found["energy-drifts"].alone) == (1, 0)
    assert found["force-drifts"].machines == {"drift": pytest.approx(2 / 3)}
    assert found["energy-drifts"].always_with == ("force-drifts",)
    page = warnings_section([drift, clean])
    assert "| strokes-swing | note | 100% | none |  |  |" in page
    assert "`samples-lost`" in page


@pytest.mark.long(10)
def test_strokes_that_a_place_makes_deviate_do_not_hide_it():
    """Weighing less, the slow strokes of this session kept the place from being taken off: no interval held."""
    session, step = Sessions("waves").session(2), Step()
    judged_static(step, session, session.logs["constant-velocity"], session.axis.plant)
    assert all(number.covered for number in step.numbers.values())
    assert {"force-over-position": "note"}.items() <= {one.code: one.severity for one in step.notices}.items()
