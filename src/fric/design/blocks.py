"""Design of a control block: its tuned parameter as large as the peak sensitivity of the whole loop allows."""

from dataclasses import dataclass
from math import inf

import numpy as np

from fric.control import ControlBlock, Setting
from fric.control.cascade import Cascade
from fric.design.margins import Loop, Margins, OpenLoop, decibel, three_digits
from fric.design.observer import PEAK_SENSITIVITY, WholeLoop, largest_that_keeps
from fric.design.perturbation import Perturbation, model_perturbation
from fric.errors import FricError

TRIED = 25


@dataclass(frozen=True)
class BlockDesign:
    """A control block, and the margins of the whole loop with it, opened at the plant's input.

    Parameters
    ----------
    block
        The block.
    margins
        Margins with it, around rest where it is not linear; None where it does not feed back, or has no margins.
    reason
        Why its parameters are as they are.
    response
        The open loop as a function of the frequencies [Hz], where it has margins.
    """

    block: ControlBlock
    margins: Margins | None
    reason: str
    response: OpenLoop | None = None

    def loops(self) -> dict[str, Loop]:
        """Return the whole loop with its margins, where there is one."""
        if self.margins is None or self.response is None:
            return {}
        title = f"with {self.block.name}" + ("" if self.block.linear else ", around rest")
        return {"input": Loop(title, self.response, self.margins)}


def design_block(
    kind: type[ControlBlock],
    setting: Setting,
    *,
    peak_sensitivity: float = PEAK_SENSITIVITY,
    perturbation: Perturbation | None = None,
) -> BlockDesign:
    """Return a control block for an axis as its controller knows it.

    The tuned parameter of a controller or an observer is the largest up to which every smaller one keeps the peak
    sensitivity. A block that is not linear is judged around rest, where its gains are largest. Other blocks are as they
    design themselves from plant and friction.

    Parameters
    ----------
    kind
        The block.
    setting
        The axis: plant, cascade, nominal friction.
    peak_sensitivity
        Largest M_s of the whole loop, a factor above 1.
    perturbation
        Delta, measured; that of the plant's delay alone where not given.

    Raises
    ------
    FricError
        When the loop misses the peak sensitivity at the smallest value already.
    """
    if not kind.tuned:
        return BlockDesign(kind.designed(setting), None, "from plant, friction and motion")
    Delta = perturbation or model_perturbation(setting.plant, setting.sampling / 2)

    cascade = Cascade.designed(setting)

    def keeps(value: float) -> bool:
        loop, blocks = loop_with(kind.tuned_to(value, setting), cascade, Delta, setting)
        return loop.peak(blocks) <= peak_sensitivity

    own = next(one for one in kind.parameters if one.name == kind.tuned)
    found = largest_that_keeps(keeps, np.geomspace(own.lower, own.upper, TRIED), 1e-4)
    text = f"the peak sensitivity of the whole loop, {decibel(peak_sensitivity):.3g} dB"
    if found == 0.0:
        raise FricError(
            f"'{kind.name}' misses {text}, at the smallest {kind.tuned} already",
            hint="Lower the gains of the controller, or ask for a larger peak sensitivity.",
        )
    value, reason = (
        (own.upper, "limited by no margin, but by its bound")
        if found == inf
        else (three_digits(found), f"limited by {text}")
    )
    loop, blocks = loop_with(block := kind.tuned_to(value, setting), cascade, Delta, setting)
    return BlockDesign(block, loop.margins(blocks), reason, loop.response(blocks))


def loop_with(
    block: ControlBlock, cascade: Cascade, Delta: Perturbation, setting: Setting
) -> tuple[WholeLoop, tuple[ControlBlock, ...]]:
    """Return the whole loop with a block as its controller, or else the blocks to go with it."""
    controller, blocks = (block, ()) if block.kind == "controller" else (None, (block,))
    return WholeLoop(setting.plant, cascade, Delta, controller, setting), blocks
