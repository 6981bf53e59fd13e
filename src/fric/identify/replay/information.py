"""What records tell of a model that is known: the Fisher information of the fit by replay, without a search."""

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS
from fric.identify.replay.coordinates import LEVEL, Coordinates, Ranges, coordinates_of
from fric.identify.replay.lateness import of_timing
from fric.identify.replay.replay_intervals import Beyond, replay_covariance, slopes
from fric.identify.replay.replay_search import Search
from fric.records.prepared import Prepared

BLIND = 1e-6
"""Share of the best seen direction's effect below which records are blind for a direction."""


def replay_information(
    records: Sequence[Prepared], model: GMS, ranges: Ranges, beyond: Beyond | None = None
) -> tuple[tuple[str, ...], Real]:
    """Return what records tell of alpha, k and C of a GMS model, its static map and nothing else being known.

    It is the inverse of the fit's own covariance at this model, in the directions that the records see; what they have
    of their own (a level, offsets) is taken out. alpha enters by its logit (the last share follows from the others), k
    and C by their logarithms, as in a friction file's covariance.

    records: Records with the friction of this model, ready for replay.
    model: The model.
    ranges: Between which values the records could show it.
    beyond: What the covariance gains besides, where the residuals do not tell it.
    Returns the parameters, and a matrix (p, p).
    """
    held = {("static", name): float(getattr(model.static, name)) for name in STATIC_PARAMETERS}
    level = not all(record.slides for record in records)
    coordinates = Coordinates.of(GMS, ranges, blocks=len(model.alpha), held=held, level=level)
    search = Search(coordinates, [record.trimmed() for record in records])
    x = coordinates_of(coordinates, model)
    search = search.weighed(x)
    here = search.at(x)
    S, V = np.linalg.svd(here.gradient, full_matrices=False)[1:]
    seen = BLIND * S[0] < S
    basis = np.eye(len(x)) if seen.all() else V[seen].T
    shown = here.gradient @ basis
    freedom = max(len(here.residual) - len(basis.T), 1)
    covariance = replay_covariance(shown, here.residual, search.records, float(stdtrit(freedom, 0.975)))
    covariance += of_timing(search, x, shown)
    if beyond is not None:
        covariance += beyond(search, x, basis)
    information = basis @ np.linalg.inv(covariance) @ basis.T
    own = [n for n, c in enumerate(coordinates.free) if c.parameter is LEVEL]
    kept = [n for n in range(len(x)) if n not in own]
    information = (
        information[np.ix_(kept, kept)]
        - information[np.ix_(kept, own)]
        @ np.linalg.pinv(information[np.ix_(own, own)])
        @ information[np.ix_(own, kept)]
    )
    names, rows = [], []
    for (section, name), found in slopes(coordinates, x).items():
        if section != "static":
            count = len(found.slope) - (name == "alpha")
            names += [f"{name}_{n + 1}" if found.parameter.per_block else name for n in range(count)]
            rows += [found.slope[n, kept] for n in range(count)]
    back = np.linalg.inv(np.array(rows))
    return tuple(names), np.asarray(back.T @ information @ back)
