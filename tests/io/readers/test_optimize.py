"""Frequency measurements and auto-tuning results in the form of SINUMERIK Operate, by a writer of its own."""

import struct

import numpy as np
import pytest

from fric.errors import FricError
from fric.io.readers import tables
from fric.results.identify import identify_controller, identify_plant
from fric.results.ingest import ingest

DIGITS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ!#$`()*+-/:;=?@[]^_{|}~"
RATIO, PERIOD = 2 * np.pi / 0.01, 125e-6  # rad of the motor a metre; sampling time [s]
F = np.arange(1023) / (2047 * PERIOD)


def base85(numbers) -> str:
    """Return doubles as five characters for four bytes, a point for four zero bytes, in lines of odd lengths."""
    text = ""
    for number in numbers:
        data = struct.pack(">d", number)
        for word in (int.from_bytes(data[:4], "big"), int.from_bytes(data[4:], "big")):
            digits = ""
            for _ in range(5):
                word, rest = divmod(word, 85)
                digits = DIGITS[rest] + digits
            text += "." if digits == "00000" else digits
    return "\n".join(text[n : n + 203] for n in range(0, len(text), 203))


def array(name: str, values) -> str:
    values = np.asarray(values)
    kind = "ComplexNumber" if np.iscomplexobj(values) else "double"
    numbers = np.column_stack([values.real, values.imag]).ravel() if np.iscomplexobj(values) else values
    return (f'<NumericArray satclassid="4" elementtype="{kind}" format="base85" name="{name}"><unsigned_int '
            f'name="m_length">{len(values)}</unsigned_int><raw name="m_pNumberArray"><![CDATA[\n{base85(numbers)}\n'
            "]]></raw></NumericArray>")  # fmt: skip


def value(name: str, what, tag: str = "float") -> str:
    return f'<{tag} name="{name}">{what}</{tag}>'


def spectrum(first: int, second: int, values, count: int = 2) -> str:
    return (f"<SigNodeCrossSpectrumInfo>{value('m_uSecondId', second)}{value('m_uSignodeId', first)}"
            f"{value('m_uNumSpectraInAvg', count)}<CrossSpectrum>{array('m_FrequencyVector', F[: len(values)])}"
            f"{array('m_ValueVector', values)}</CrossSpectrum></SigNodeCrossSpectrumInfo>")  # fmt: skip


def node(number: int, *inside: str) -> str:
    return f"<PlatformSignalNode>{''.join(inside)}{value('m_uNodeId', number)}</PlatformSignalNode>"


def measurement(*nodes: str, linear: bool = True) -> str:
    about = value("m_dMotorToAxisRatio", RATIO) + value("m_bIsRotaryAxis", "false" if linear else "true", "boolean")
    return ('<?xml version="1.0" encoding="ISO-8859-1"?><!-- 4.7 --><ResponseTestCustom satclassid="174">'
            f"<unheard_of/>{value('m_uAxis', 1)}{''.join(nodes)}<x>{about}</x></ResponseTestCustom>")  # fmt: skip


def loop(f, damping: float = 60 * 2 * np.pi):
    """Return a closed speed loop of first order with a delay."""
    s = 2j * np.pi * f
    return damping / (s + damping) * np.exp(-s * 3 * PERIOD)


def spectra(turned: bool, noise: float = 1e-4):
    """Return set speed, speed and cross spectrum of two averaged runs."""
    rng = np.random.default_rng(3)
    u = np.exp(2j * np.pi * rng.random((2, len(F))))
    y = loop(F) * u + noise * (rng.normal(size=u.shape) + 1j * rng.normal(size=u.shape))
    across = np.mean(np.conj(y) * u, axis=0)
    return np.mean(abs(u) ** 2, axis=0) + 0j, np.mean(abs(y) ** 2, axis=0) + 0j, np.conj(across) if turned else across


def columns(table) -> dict:
    blocks = [block.columns for block in table.read(range(len(table.columns)))]
    return dict(
        zip([column.name for column in table.columns], map(np.concatenate, zip(*blocks, strict=True)), strict=True)
    )


@pytest.mark.parametrize("turned", [False, True])
def test_a_measurement_is_the_response_of_the_position_to_the_set_speed(tmp_path, turned):
    """Whichever of both orders the cross spectrum has: what answers is late."""
    u, y, across = spectra(turned)
    path = tmp_path / "a.xml"
    path.write_text(measurement(node(62, spectrum(62, 0, u)), node(61, spectrum(61, 0, y), spectrum(61, 62, across))))
    (table,) = tables(path)
    found = columns(table)
    expected = loop(found["frequency"]) / (2j * np.pi * found["frequency"])
    assert table.said["axis"] == "axis1"
    assert found["frequency"] == pytest.approx(F[1:])
    assert found["magnitude"] * np.exp(1j * found["phase"]) == pytest.approx(expected, rel=0.03)
    assert found["coherence"].min() > 0.95
    done = ingest(path, output=tmp_path / "log.h5").done
    assert {one.code for one in done.warnings} == {"response-of-loop"}
    plant = identify_plant(tmp_path / "log.h5")
    assert float(plant.A) == pytest.approx(60 * 2 * np.pi, rel=0.02)
    assert float(plant.B) == pytest.approx(60 * 2 * np.pi, rel=0.02)
    assert float(plant.T_d) == pytest.approx(3 * PERIOD, rel=0.02)


def test_without_spectra_it_is_that_of_the_time_series(tmp_path):
    rng = np.random.default_rng(1)
    lines = loop(np.arange(1024) / (2047 * PERIOD))
    runs = np.sign(rng.normal(size=(2, 2047))) + np.array([[40.0], [-40.0]])
    answers = np.fft.irfft(np.fft.rfft(runs) * lines, 2047)

    def series(of) -> str:
        return "".join(f"<TimeSeries>{array('m_ValueVector', one)}{value('m_TimeVector.end', 2046 * PERIOD)}"
                       "</TimeSeries>" for one in of)  # fmt: skip

    path = tmp_path / "a.xml"
    path.write_text(measurement(node(61, series(answers)), node(62, series(runs)), linear=False))
    (table,) = tables(path)
    found = columns(table)
    expected = loop(found["frequency"]) / (2j * np.pi * found["frequency"])
    assert found["magnitude"] * np.exp(1j * found["phase"]) == pytest.approx(expected, rel=1e-6)
    assert table.columns[1].unit == "rad/V"
    path.write_text(measurement(node(61, series(answers[:1])), node(62, series(runs[:1]))))
    assert "coherence" not in columns(next(tables(path)))  # of a lone run it would be 1, whatever the noise is


def tuning(*, filters: str = "", listed: str = "m_listpSpeedLoopRegulators", gain: str = "m_dKpGain") -> str:
    s = 2j * np.pi * F[1:]
    plant = np.exp(-s * PERIOD) / (0.002 * s + 0.01)
    loops = "".join(
        f"<Regulator>{value('m_dIntegralTime', 0.01)}{value(gain, k)}"
        '<ConTimeFilterList name="m_ConTimeFilterListActualSpeedFilters"><LinkedList name="l">'
        f"{filters}</LinkedList></ConTimeFilterList></Regulator>" for k in (0.1, 0.25)
    )  # fmt: skip
    response = "".join(
        f'<FrequencyResponseFunction name="{name}">{array("m_ValueVector", values)}{array("m_FrequencyVector", F[1:])}'
        "</FrequencyResponseFunction>" for name, values in (("m_pMeasCoherence", 0 * s + 0.999), ("m_pPlant", plant))
    )  # fmt: skip
    return (f'<AutoTune satclassid="9">{value("m_szAxisName", "X1", "string")}<DynamicModelPositionController840DSL>'
            f'{response}{value("m_dActValDelayTime", PERIOD)}<LinkedList name="{listed}">{loops}</LinkedList>'
            "</DynamicModelPositionController840DSL></AutoTune>")  # fmt: skip


def test_an_auto_tuning_result_holds_plant_and_loop(tmp_path):
    path = tmp_path / "ast.xml"
    low_pass = f'<PT1Filter><boolean name="m_bFilterIsEnabled">true</boolean>{value("m_dTimeConst", 2e-4)}</PT1Filter>'
    off = '<PT2Filter><boolean name="m_bFilterIsEnabled">false</boolean></PT2Filter>'
    path.write_text(tuning(filters=low_pass + off))
    ingest(path, output=tmp_path / "log.h5")
    plant = identify_plant(tmp_path / "log.h5")
    assert (float(plant.A), float(plant.B)) == pytest.approx((5.0, 500.0), rel=0.02)
    found = identify_controller(path, position_gain="20 1/s")
    assert (found.axis, found.motion) == ("x1", "rotary")
    gains = found.belief
    assert (gains.K_v, gains.K_p, gains.K_i, gains.sampling) == pytest.approx((20.0, 0.25, 25.0, 8000.0))
    assert gains.velocity_filter == pytest.approx(1 / (2 * np.pi * 2e-4))
    assert "as it says" in str(found)
    assert found.document["K_p"]["unit"] == "V*s/rad"
    with pytest.raises(FricError, match="without K_v"):
        identify_controller(path)
    path.write_text(tuning(filters=low_pass.replace("PT1", "SecondOrder")))
    with pytest.raises(FricError, match="more than a first order"):
        identify_controller(path, position_gain="20 1/s")
    path.write_text(tuning(listed="other"))
    with pytest.raises(FricError, match="no speed loop"):
        identify_controller(path, position_gain="20 1/s")


U, Y, ACROSS = spectra(turned=False)
WHOLE = measurement(node(62, spectrum(62, 0, U)), node(61, spectrum(61, 0, Y), spectrum(61, 62, ACROSS)))


@pytest.mark.parametrize(("text", "says"), [
    (WHOLE[: len(WHOLE) // 2], "not complete XML"),
    (WHOLE.replace("<!-- 4.7 -->", '<!DOCTYPE a [<!ENTITY b "b">]>'), "declares a document type"),
    (WHOLE.replace(value("m_uNodeId", 62), value("m_uNodeId", 7)), "measures the signals 7, 61"),
    (WHOLE.replace(value("m_uSecondId", 62), value("m_uSecondId", 5)), "neither spectra nor time series"),
    (WHOLE.replace("]]></raw>", "~~]]></raw>", 1), "not base 85, or cut off"),
    (WHOLE.replace("CDATA[\n", "CDATA[\n~~~~~~~~~~~~~~~~~~~~", 1), "a word over 32 bits"),
    (WHOLE.replace("base85", "hex"), "not base 85"),
    (measurement(node(62, spectrum(62, 0, U)), node(61, spectrum(61, 0, Y), spectrum(61, 62, ACROSS[1:]))), "lengths"),
    (measurement(node(62, spectrum(62, 0, 0 * U)), node(61, spectrum(61, 0, Y), spectrum(61, 62, ACROSS))),
     "no frequency response"),
    (tuning().replace('name="m_FrequencyVector"', 'name="m_Other"', 2), "a plant without its frequencies"),
])  # fmt: skip
def test_what_cannot_be_read_ends_in_a_sentence(tmp_path, text, says):
    path = tmp_path / "a.xml"
    path.write_text(text)
    with pytest.raises(FricError, match=says) as caught:
        list(tables(path))
    assert "a.xml" in str(caught.value)


def test_another_xml_is_no_auto_tuning_result(tmp_path):
    path = tmp_path / "trace.xml"
    path.write_text("<measurement><sample t='0'/></measurement>")
    with pytest.raises(FricError, match="not an auto-tuning result"):
        identify_controller(path)
