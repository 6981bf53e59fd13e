"""Frequency measurements and auto-tuning results of SINUMERIK Operate (Optimize, AST), saved as XML.

The elements are those that a public parser and a public measurement have: values are elements with a ``name``, arrays
are ``NumericArray`` of big-endian doubles in base 85 (five characters for four bytes, ``.`` for four zero bytes),
complex ones in pairs. A measurement holds ``PlatformSignalNode`` with the averaged spectra ``conj(a)·b`` of a node and
a second one, or its time series; an auto-tuning result holds the plant ``m_pPlant`` from torque to speed of the motor,
and the speed loop before and behind the tuning. All values are in SI, of the motor. The order of elements is free.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element

import numpy as np

from fric.arrays import Complex, Real
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.flaws.files import RESPONSE_OF_LOOP
from fric.io.readers.base import Column, ForeignTable, Format, Memory, number, read_xml
from fric.units import Motion

if TYPE_CHECKING:
    from fric.control.cascade import Cascade

FORMAT = Format("SINUMERIK Optimize", (".xml",))
AGAIN = "Save the measurement again, with its spectra."
MOST_BYTES = 64 << 20  # Bytes of a file that are read at most: a measurement has 0.2 MB
SPEED, SET_SPEED = 61, 62  # Numbers of the nodes of the actual speed and of the speed set point
ALPHABET = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ!#$`()*+-/:;=?@[]^_{|}~"
_CODES = np.full(256, -1)
_CODES[np.frombuffer(ALPHABET.encode(), np.uint8)] = np.arange(85)


def recognises(path: Path, head: bytes) -> float:
    """Its elements have class numbers of the SAT library."""
    return 1.0 * (b"satclassid=" in head)


def tables(path: Path, layout: Layout) -> Iterator[ForeignTable]:
    """Read a file: a frequency response, of the axis where the ratio of its gear is there, else of the motor."""
    root = read_xml(path, MOST_BYTES)
    tuned = _named(root, "FrequencyResponseFunction", "m_pPlant")
    f, response, coherence = _measured(root) if tuned is None else _of_tuning(root, tuned)
    good = np.isfinite(response) & (response != 0.0) & (f > 0.0) & (coherence > 0.0)
    if np.count_nonzero(good) < 3:
        raise FricError("holds no frequency response", hint=AGAIN)
    f, response, coherence = f[good], response[good], coherence[good]
    ratio, linear = _gear(root)
    # of a set speed 1 V stands for 1 m/s or rad/s of the axis; of a torque for 1 N*m of the motor
    response = response / (2j * np.pi * f * (1.0 if tuned is None else ratio))
    columns = [Column("frequency", "Hz"), Column("magnitude", "m/V" if linear else "rad/V"), Column("phase", "rad")]
    data = [f, np.abs(response), np.angle(response)]
    if not (coherence == 1.0).all():
        columns, data = [*columns, Column("coherence", "1")], [*data, coherence]
    table = Memory(path, columns, data, said={"kind": "frequency-response", "axis": _axis(root)})
    volt = f"{'1 m/s' if linear else '1 rad/s'} of set speed" if tuned is None else "1 N·m of the motor"
    table.notices = [RESPONSE_OF_LOOP.found(str(path), volt=volt)]
    yield table


def cascade_of(path: Path, position_gain: float | None) -> tuple[str, Motion, "Cascade"]:
    """Return axis, motion and cascade of an auto-tuning result, of which the tuned loop is the last.

    The voltage of the cascade stands for the torque of the motor: 1 V for 1 N*m.

    position_gain: K_v [1/s], which the file lacks.
    """
    from fric.control.cascade import Cascade  # it compiles the loop, which no reader needs

    root = read_xml(path, MOST_BYTES)
    listed = _named(root, "LinkedList", "m_listpSpeedLoopRegulators")
    loops = [] if listed is None else [element for element in listed if _number(element, "m_dKpGain") > 0.0]
    if not loops:
        raise FricError("holds no speed loop", where=str(path), hint="Save the result of an auto-tuning.")
    held = _named(loops[-1], "ConTimeFilterList", "m_ConTimeFilterListActualSpeedFilters")
    filters = [element for element in (() if held is None else held.iter()) if element.tag.endswith("Filter")]
    filters = [element for element in filters if _text(element, "m_bFilterIsEnabled") == "true"]
    if any(element.tag != "PT1Filter" for element in filters):
        raise FricError("filters the actual speed by more than a first order", where=str(path),
                        hint="Write the controller document by hand.")  # fmt: skip
    if position_gain is None:
        raise FricError("holds the speed loop alone, without K_v", where=str(path),
                        hint="Say `position_gain='33.3 1/s'`: 16.7 1/s for each 1 of MD 32200.")  # fmt: skip
    reset, period = _number(loops[-1], "m_dIntegralTime"), _number(root, "m_dActValDelayTime")
    if not (reset > 0.0 and period > 0.0):
        raise FricError("lacks the integral time, or the delay of the actual value", where=str(path), hint=AGAIN)
    (ratio, linear), corner = _gear(root), sum(_number(element, "m_dTimeConst") for element in filters)
    gain = _number(loops[-1], "m_dKpGain") * ratio
    corner = 1.0 / (2.0 * np.pi * corner) if corner > 0.0 else 0.5 / period  # without a filter that of the sampling
    cascade = Cascade(position_gain, gain, gain / reset, corner, 1.0 / period)
    return _axis(root), "linear" if linear else "rotary", cascade


def _measured(root: Element) -> tuple[Real, Complex, Real]:
    """Return frequencies [Hz], response and coherence of a measurement from set speed to speed; 1 where it has none. Of
    n spectra noise has a coherence of 1/n: what is above is left.
    """
    nodes = {int(_number(node, "m_uNodeId")): node for node in root.iter("PlatformSignalNode")}
    if not {SPEED, SET_SPEED} <= nodes.keys():
        what = f"measures the signals {', '.join(map(str, nodes)) or '(none)'}"
        raise FricError(what, hint="Measure the speed control loop: actual speed over speed set point.")
    spectra, f, count = dict[tuple[int, int], Complex](), np.empty(0), 1.0
    for info in root.iter("SigNodeCrossSpectrumInfo"):
        if len(values := _array(info, "m_ValueVector")):
            f, count = _array(info, "m_FrequencyVector").real, _number(info, "m_uNumSpectraInAvg")
            first, second = int(_number(info, "m_uSignodeId")), int(_number(info, "m_uSecondId"))
            spectra[first, second or first] = values
    u, y, across = (SET_SPEED,) * 2, (SPEED,) * 2, (SET_SPEED, SPEED)
    if across not in spectra and across[::-1] in spectra:
        spectra[across] = np.conj(spectra[across[::-1]])
    if not {u, y, across} <= spectra.keys():
        spectra, f, count = _transformed(nodes)
    if len({len(f), *(len(spectra[pair]) for pair in (u, y, across))}) > 1:
        raise FricError("holds spectra of different lengths", hint=AGAIN)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        response, power = spectra[across] / spectra[u].real, spectra[u].real * spectra[y].real
        shared = np.nan_to_num(np.minimum(np.abs(spectra[across]) ** 2 / power, 1.0))
        turned = np.nan_to_num(shared[1:] ** 4 * np.angle(response[1:] / response[:-1]))
    response = np.conj(response) if turned.sum() > 0.0 else response  # what answers is late
    return f, response, (count * shared - 1.0) / (count - 1.0) if count > 1.0 else np.ones(len(f))


def _transformed(nodes: dict[int, Element]) -> tuple[dict[tuple[int, int], Complex], Real, float]:
    """Return the spectra of the time series, which are whole periods, their frequencies [Hz] and number."""
    series = {n: list(nodes[n].iter("TimeSeries")) for n in (SET_SPEED, SPEED)}
    runs = {n: [_array(element, "m_ValueVector").real for element in found] for n, found in series.items()}
    lengths = [len(values) for found in runs.values() for values in found] or [0]
    end = _number(series[SPEED][0], "m_TimeVector.end") if series[SPEED] else 0.0
    n, count = lengths[0], len(runs[SPEED])
    if len(set(lengths)) > 1 or n < 8 or count != len(runs[SET_SPEED]) or end <= 0.0:
        raise FricError("holds neither spectra nor time series of both speeds", hint=AGAIN)
    lines = {k: np.fft.rfft(np.array(values), axis=1) for k, values in runs.items()}
    spectra = {(a, b): np.mean(np.conj(lines[a]) * lines[b], axis=0) for a in lines for b in lines}
    return spectra, np.arange(n // 2 + 1) * (n - 1) / (n * end), float(count)


def _of_tuning(root: Element, plant: Element) -> tuple[Real, Complex, Real]:
    """Return frequencies [Hz], the plant from torque to speed, and its coherence; 1 where it has none."""
    f, values = _array(plant, "m_FrequencyVector").real, _array(plant, "m_ValueVector")
    measured = _named(root, "FrequencyResponseFunction", "m_pMeasCoherence")
    coherence = np.ones(len(f)) if measured is None else _array(measured, "m_ValueVector").real
    if not len(f) == len(values) == len(coherence):
        raise FricError("holds a plant without its frequencies, or its coherence", hint=AGAIN)
    return f, values, np.minimum(coherence, 1.0)


def _array(holder: Element, name: str) -> Complex:
    """Return the numbers of an array, complex ones from pairs; none where there is no array."""
    found = _named(holder, "NumericArray", name)
    raw = "".join("".join(element.text.split()) for element in (found or ()) if element.tag == "raw" and element.text)
    if found is None or not raw:
        return np.empty(0, complex)
    codes = _CODES[np.frombuffer(raw.replace(".", "00000").encode("latin-1", "replace"), np.uint8)]
    in_pairs = found.get("elementtype") == "ComplexNumber"
    if found.get("format", "base85") != "base85" or codes.min() < 0 or len(codes) % (20 if in_pairs else 10):
        raise FricError(f"holds an array {name} that is not base 85, or cut off", hint=AGAIN)
    words = codes.reshape(-1, 5) @ 85 ** np.arange(4, -1, -1)
    if words.max() >= 1 << 32:
        raise FricError(f"holds an array {name} with a word over 32 bits", hint=AGAIN)
    values = np.frombuffer(words.astype(">u4").tobytes(), ">f8").astype(float)
    return values.view(complex) if in_pairs else values.astype(complex)


def _axis(root: Element) -> str:
    return _text(root, "m_szAxisName").lower() or f"axis{_text(root, 'm_uAxis')}"


def _gear(root: Element) -> tuple[float, bool]:
    """Return the angle of the motor over the position of the axis [rad/m or 1], and whether the axis is linear."""
    ratio = abs(_number(root, "m_dMotorToAxisRatio"))
    return ratio or 1.0, bool(ratio) and _text(root, "m_bIsRotaryAxis") == "false"


def _named(holder: Element, tag: str, name: str) -> Element | None:
    return next((element for element in holder.iter(tag) if element.get("name") == name), None)


def _text(holder: Element, name: str) -> str:
    return next(((element.text or "").strip() for element in holder.iter() if element.get("name") == name), "")


def _number(holder: Element, name: str) -> float:
    """Return a value by its name, 0 where there is none."""
    found = number(_text(holder, name))
    return found if abs(found) < 1e12 else 0.0
