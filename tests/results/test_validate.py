"""`fric validate` on every file that fric writes: each kind of plant and friction, each direction, any delay."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import fric
from fric.control.cascade import Cascade
from fric.documents.friction import FrictionDocument
from fric.documents.yaml import read_document
from fric.log import Log
from tests.turns import in_turns

CASCADE = Cascade(K_v=100.0, K_p=40.0, K_i=0.0, velocity_filter=500.0, sampling=1000.0)


@pytest.fixture(scope="module")
def motion():
    """Return a motion in both directions, with a force that is known: 20 kg, 30 N·s/m, 8 N, and 2 N of offset."""
    t = np.arange(0.0, 4.0, 1e-3)
    z = 0.02 * np.sin(2 * np.pi * 0.5 * t) + 0.003 * np.sin(2 * np.pi * 2.3 * t)
    v = np.gradient(z, t)
    force = (
        20 * np.gradient(v, t) + 30 * v + 8 * np.tanh(v / 1e-4) + 2 + np.random.default_rng(0).normal(0, 0.2, t.size)
    )
    return Log(time=t, position=z, reference=z, force=force, input=force / 50.0, kind="motion", axis="x")


@pytest.fixture(scope="module")
def files(motion, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kinds")
    plants = {way: fric.identify_plant(motion, direction=way, method="motion") for way in ("both", "each")}
    strokes = fric.read("data/constant-velocity.h5")[::3]
    made = {f"plant {way}": one for way, one in plants.items()}
    made["static"] = fric.identify_static(*strokes)
    made["static each"] = fric.identify_static(*strokes, direction="each")
    sines = fric.read("data/presliding-sine.h5")
    made["gms alone"] = fric.identify_gms(sines, blocks=3, refine=False)
    made["gms"] = fric.identify_gms(sines, static=made["static"], blocks=3, refine=False)
    made["dahl"] = fric.identify_model("dahl", motion, plant=made["plant both"])
    paths = {}
    for name, one in made.items():
        paths[name] = folder / f"{name.replace(' ', '-')}.yaml"
        one.save(paths[name])
    return paths


FRICTIONS = None, "static", "static each", "gms alone", "gms", "dahl"


@pytest.mark.parametrize(
    ("friction", "way"),
    in_turns(product(FRICTIONS, ("both", "each")), zip(FRICTIONS, 3 * ("both", "each"), strict=True)),
)
def test_every_file_is_taken(files, motion, way, friction):
    given = {} if friction is None else {"friction": files[friction]}
    found = fric.validate(motion, plant=files[f"plant {way}"], controller=CASCADE, **given)
    assert [one.loop for one in found.validations] == ["closed", "open", "inverse"]
    scores = [signal.relative for one in found.validations for signal in one.signals.values()]
    assert np.all(np.isfinite(scores))
    if friction is None:
        assert found.validations[-1].signals["force"].relative < 0.1


def test_a_delay_under_half_a_sample_is_taken_as_half_a_sample(files, motion, tmp_path):
    text = files["plant both"].read_text(encoding="utf-8")
    short = tmp_path / "short.yaml"
    lines = ["T_d: {value: 0.1, unit: ms}" if line.startswith("T_d:") else line for line in text.splitlines()]
    short.write_text("\n".join(lines), encoding="utf-8")
    found = fric.validate(motion, plant=short, controller=CASCADE)
    assert "T_d-below-hold" in {getattr(one, "code", "") for one in found.warnings}


def test_the_load_belongs_to_the_axis_by_whatever_name_a_record_goes(files, motion):
    """It was kept by the name of the record that a model was fitted to: 8.1 % in place of 5.9 on another."""
    document = read_document(files["dahl"], FrictionDocument)
    (fitted,) = document.fit_of("dahl").records
    other = fitted.model_copy(update={"record": "b", "offset": fitted.offset.model_copy(update={"value": 6.0})})
    document.fit_of("dahl").records.append(other)
    load = (float(fitted.offset.si("force", "linear")) + 6.0) / 2
    by_name = [
        fric.validate(replace(motion, name=name), plant=files["plant both"], friction=document)
        for name in (fitted.record, "b", "c")
    ]
    stated = fric.validate(motion, plant=files["plant both"], friction=document, load=f"{load!r} N")
    for found in by_name:
        assert found.validations[-1].signals["force"].rms == pytest.approx(
            stated.validations[-1].signals["force"].rms, rel=1e-9
        )
