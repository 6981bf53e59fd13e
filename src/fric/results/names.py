"""Plain names of symbols: what stands beside them in tables."""

from collections.abc import Iterable
from functools import cache

OTHERS = {
    "A": "damping over mass",
    "B": "acceleration per volt",
    "T_d": "delay of the drive",
    "K_f": "force constant",
    "force_lag": "lag of the logged force",
    "force_filter": "low-pass of the logged force",
    "offset": "constant force",
    "M": "moving mass",
    "F_v": "viscous friction",
    "frequency": "resonance",
    "ratio": "share of the second mass",
    "damping": "damping ratio",
    "K_v": "position gain",
    "K_p": "velocity gain",
    "K_i": "integral velocity gain",
    "velocity_filter": "low-pass of the velocity",
    "sampling": "rate of the controller",
    "limit": "largest voltage",
    "cutoff": "corner of Q",
    "sigma_0": "stiffness at rest",
    "sigma_1": "damping of the bristles",
    "n": "shape of the transition",
}
"""Of what is no parameter of a friction model."""


@cache
def _of_models() -> dict[str, str]:
    """Return the names that friction models give their parameters, where all that have one call it alike."""
    from fric.friction import models

    found: dict[str, set[str]] = {}
    for model in models().values():
        for one in model.parameters:
            found.setdefault(one.name, set()).add(one.doc)
    return {name: next(iter(docs)) for name, docs in found.items() if len(docs) == 1}


def plain_names(symbols: Iterable[str]) -> list[str]:
    """Return the plain name of each symbol, once: of ``alpha_1``, ``alpha_2``, … at the first alone."""
    named: set[str] = set()
    names = []
    for symbol in symbols:
        base, _, number = symbol.rpartition("_")
        whole = not number.isdigit() or symbol in OTHERS or symbol in _of_models()
        key = symbol if whole else base
        name = OTHERS.get(key) or _of_models().get(key, "")
        names.append("" if key in named else name)
        named.add(key)
    return names
