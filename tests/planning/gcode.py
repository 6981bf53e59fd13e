"""Runs G-code as a control does: words, modal groups, feed a minute or inverse time. It knows nothing of fric."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

WORD = re.compile(r"([A-Z])\s*=?\s*([-+]?\d*\.?\d+)")


@dataclass
class Control:
    """A control of two axes [mm]; `path` holds time [s] and place at the end of each piece, arcs in small pieces."""

    axes: str = "XY"
    at: dict[str, float] = field(default_factory=dict)
    path: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    dwells: float = 0.0
    feeds: list[float] = field(default_factory=list)
    ended: bool = False

    def run(self, text: str, dwell_word: str) -> Control:
        self.at = dict.fromkeys(self.axes, 0.0)
        mode, inverse, feed, time = 1, False, None, 0.0
        self.path = [(0.0, self._place())]
        for raw in text.splitlines():
            line = re.sub(r"\([^()]*\)", "", raw).partition(";")[0].strip()
            if not line or line == "%" or line.startswith("O"):
                assert re.fullmatch(r"(%|O\d{4}.*|)", line)
                continue
            assert not self.ended, "behind the end of the program"
            words = WORD.findall(line)
            assert re.sub(WORD, "", line).strip() == "", f"not G-code: {line}"
            codes = [float(value) for letter, value in words if letter == "G"]
            values = {letter: float(value) for letter, value in words if letter not in "GM"}
            if any(letter == "M" and float(value) in {2, 30} for letter, value in words):
                self.ended = True
                continue
            if 4 in codes:
                assert set(values) == {dwell_word}
                time += values[dwell_word]
                self.dwells += values[dwell_word]
                self.path.append((time, self._place()))
                continue
            for code in codes:
                assert code in {0, 1, 2, 3, 17, 21, 40, 49, 54, 64, 71, 90, 93, 94}, code
                mode = int(code) if code in {0, 1, 2, 3} else mode
                inverse = True if code == 93 else False if code == 94 else inverse
                feed = None if code in {93, 94} else feed
            feed = values.get("F", feed)
            if not set(values) & set(self.axes):
                continue
            assert mode != 0, "a rapid move has no planned speed"
            assert feed, "a move without feed"
            assert not inverse or "F" in values, "inverse time holds for one block"
            begin, end = dict(self.at), self.at | {a: values[a] for a in self.axes if a in values}
            pieces = [end] if mode == 1 else list(self._arc(begin, end, values, mode))
            lengths = [math.dist(a.values(), b.values()) for a, b in zip([begin, *pieces], pieces, strict=False)]
            if not sum(lengths):  # an approach to where it is
                assert not inverse
                self.path.append((time, self._place()))
                continue
            lasting = 60 / feed if inverse else 60 * sum(lengths) / feed
            for piece, length in zip(pieces, lengths, strict=True):
                time += lasting * length / sum(lengths)
                self.at = piece
                self.path.append((time, self._place()))
            self.feeds.append(sum(lengths) / lasting)
        return self

    def _place(self) -> tuple[float, ...]:
        return tuple(self.at.values())

    def _arc(self, begin, end, values, mode):
        centre = begin["X"] + values["I"], begin["Y"] + values["J"]
        radius = math.dist(centre, begin.values())
        assert abs(math.dist(centre, end.values()) - radius) < 2e-4, "the end is not on the circle"
        first = math.atan2(begin["Y"] - centre[1], begin["X"] - centre[0])
        turn = 2 * math.pi if mode == 3 else -2 * math.pi
        for n in range(1, 361):
            angle = first + turn * n / 360
            yield {"X": centre[0] + radius * math.cos(angle), "Y": centre[1] + radius * math.sin(angle)}
