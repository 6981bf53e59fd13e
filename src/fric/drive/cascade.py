"""The cascade controller of one axis: position P, velocity PI."""

from __future__ import annotations

from dataclasses import dataclass

from fric.errors import FricError


@dataclass(frozen=True)
class Cascade:
    """Position P, velocity PI, with velocity and inverse-model feedforward (Fig. 6 of the paper).

    ::

        r ──┬─────────────────────────── d/dt ─┐        ┌── (z̈_r + A·ż_r)/B + friction feedforward
            │                                  v        v
            └──>(+)── K_v ───────────────────>(+)─ PI ─>(+)──> limit ──> u
                 ^-                            ^-
                 z                             ż  (first difference and low-pass of z)

    Against wind-up the integral waits while the voltage is limited, unless it leads out of the limit.

    Parameters
    ----------
    K_v
        Position gain [1/s].
    K_p
        Proportional velocity gain [V·s/m].
    K_i
        Integral velocity gain [V/m].
    velocity_filter
        Corner of the first-order low-pass behind the first difference [Hz].
    sampling
        Sampling of the controller [Hz].
    limit
        Saturation of the control voltage [V].

    Raises
    ------
    FricError
        When a value is not positive (K_i may be zero).
    """

    K_v: float
    K_p: float
    K_i: float
    velocity_filter: float
    sampling: float
    limit: float = float("inf")

    def __post_init__(self) -> None:
        for name in ("K_v", "K_p", "K_i", "velocity_filter", "sampling", "limit"):
            value = getattr(self, name)
            if not (value > 0 or (name == "K_i" and value == 0)):
                raise FricError(f"{name} of the controller is {value:g}", mend=f"{name} is a positive number.")

    @property
    def T_s(self) -> float:
        """Sampling period [s]."""
        return 1.0 / self.sampling
