"""The last bits of each simulated plant, moved: FRIC_NUDGE=3 makes its B larger by 3e-13 of itself."""

from __future__ import annotations

import os
from typing import Any

STEP = 1e-13


def nudge() -> None:
    """Move B of all plants that this process simulates from now on, where FRIC_NUDGE says so."""
    count = float(os.environ.get("FRIC_NUDGE", "0"))
    if not count:
        return
    from fric.kernels import loop
    from fric.kernels.plant import PlantConstants

    simulated: Any = loop._closed_loop

    def nudged(*arguments: Any) -> Any:
        moved = (
            one._replace(B=one.B * (1.0 + STEP * count)) if isinstance(one, PlantConstants) else one
            for one in arguments
        )
        return simulated(*moved)

    loop._closed_loop = nudged
