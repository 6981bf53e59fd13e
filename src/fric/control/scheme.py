"""What a compensation scheme is: a friction model to feed forward, a controller, and further control blocks."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Self

from fric.control import block_type
from fric.control.base import ControlBlock
from fric.errors import FricError, printable, require_known, require_name
from fric.kernels.loop import BLOCKS
from fric.reference import MOST_LEAD
from fric.verb import typed

Lead = float | Literal["auto"]  # Of the feedforward ahead of the reference [s]; ``auto``: T_d of the nominal plant
LARGEST_GAIN = 5.0  # Of a feedforward: more is no share of a friction that is believed
OBSERVER = "inverse-model"  # The block that ``observer: true`` denotes


def require_feedforward(gain: float | None, lead: Lead | None) -> None:
    """Raise a `FricError` where a gain or a lead is none of a feedforward."""
    if gain is not None and not 0 <= gain <= LARGEST_GAIN:
        raise FricError(f"the gain of the feedforward is {gain:g}", hint="Give a share of the friction, 1 for all.")
    if lead is not None and lead != "auto" and not 0 <= float(lead) <= MOST_LEAD:
        raise FricError(f"the lead of the feedforward is {lead:g} s", hint=f"Give 0 to {MOST_LEAD:g} s, or auto.")


@typed
@dataclass(frozen=True)
class Scheme:
    """A compensation scheme.

    name: Its short name, as ``a`` to ``f`` of the paper: letters, digits, spaces and ``_ . + -``.
    title: Its description in a few words.
    friction: Name of the friction model that is fed forward (``static``, ``gms``, …); None for no feedforward.
    gain: Gain of the friction feedforward; None for that of the machine.
    lead: How far friction and inverse model are fed forward ahead of the reference; None for that of the machine.
    controller: Name of the control block that takes the place of the cascade; the cascade itself where not given.
    peak_sensitivity: Largest M_s for which blocks are designed whose files give no value, a factor; 6 dB where not
        given.
    joint: True where the gains of the cascade are designed together with the block that feeds back.
    blocks: Names of the further control blocks: observers and feedforward.
    Raises FricError: When its name cannot name a group of a file, there is no such block, one is of another kind, there
        are more than a loop has room for, or a cascade is to be designed together with none or with several.
    """

    name: str
    title: str
    friction: str | None = None
    gain: float | None = None
    lead: Lead | None = None
    controller: str = "cascade"
    peak_sensitivity: float | None = None
    joint: bool = False
    blocks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_name(self.name, what="a scheme")
        object.__setattr__(self, "title", printable(self.title))
        require_feedforward(self.gain, self.lead)
        if (kind := block_type(self.controller).kind) != "controller":
            what = f"scheme {self.name} asks for '{self.controller}' as its controller, which is of the kind {kind}"
            raise FricError(what, hint="Name it among the blocks.")
        if len(self.blocks) >= BLOCKS:
            hint = f"A loop has room for {BLOCKS - 1}."
            raise FricError(f"scheme {self.name} has {len(self.blocks)} blocks", hint=hint)
        for block in self.block_types:
            if block.kind == "controller":
                hint = f"Write it as controller: {block.name}."
                raise FricError(f"scheme {self.name} names the controller '{block.name}' among its blocks", hint=hint)
        if self.joint and len(self.designed) != 1:
            what = f"scheme {self.name} designs its cascade together with {len(self.designed)} blocks that are tuned"
            raise FricError(what, hint="Name one observer, or one controller, that 'fric design block' designs.")

    @property
    def block_types(self) -> list[type[ControlBlock]]:
        """The further blocks' types."""
        return [block_type(name) for name in self.blocks]

    @property
    def designed(self) -> list[type[ControlBlock]]:
        """The blocks that feed back and are tuned to a peak sensitivity."""
        return [block for block in (block_type(self.controller), *self.block_types) if block.tuned and block.in_loop()]

    @property
    def observer(self) -> bool:
        """True where an observer is on."""
        return any(block.kind == "observer" for block in self.block_types)

    @property
    def feeds_forward(self) -> bool:
        """True where friction is fed forward, by a model or by a block."""
        return self.friction is not None or any(block.kind == "feedforward" for block in self.block_types)

    @property
    def bare(self) -> bool:
        """True where the cascade alone counteracts friction."""
        return self.friction is None and not self.blocks and self.controller == "cascade"

    @property
    def not_linear(self) -> list[str]:
        """Names of its blocks in the loop that are not linear: such a loop cannot be judged by its poles."""
        blocks = (block_type(self.controller), *self.block_types)
        return [block.name for block in blocks if block.in_loop() and not block.linear]

    def plain(self) -> dict[str, Any]:
        """Return the scheme as plain values, without those that are not given."""
        given = vars(self) | {"blocks": list(self.blocks)}
        return {key: value for key, value in given.items() if value is not None and (key, value) != ("joint", False)}

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Self:
        """Return the scheme from plain values; ``observer: true`` is from files before there were blocks."""
        values = dict(given)
        observed, blocks = values.pop("observer", False), values.pop("blocks", ())
        blocks = tuple(map(str, blocks)) if isinstance(blocks, Iterable) else blocks
        return cls(**values, blocks=(OBSERVER, *blocks) if observed and OBSERVER not in blocks else blocks)


NONE = Scheme("a", "none")

PAPER_SCHEMES: dict[str, Scheme] = {  # The six schemes of Table 2
    scheme.name: scheme
    for scheme in (
        NONE,
        Scheme("b", "static", friction="static"),
        Scheme("c", "GMS", friction="gms"),
        Scheme("d", "observer", blocks=(OBSERVER,)),
        Scheme("e", "static + observer", friction="static", blocks=(OBSERVER,)),
        Scheme("f", "GMS + observer", friction="gms", blocks=(OBSERVER,)),
    )
}


def choose_schemes(asked: str, known: Mapping[str, Scheme] | None = None) -> list[Scheme]:
    """Return the requested schemes, as ``f``, ``a,d,f`` or ``all``.

    known: Schemes by name; those of the paper where not given.
    """
    known = PAPER_SCHEMES if known is None else known
    names = list(known) if asked == "all" else [name.strip() for name in asked.strip(" ,").split(",")]
    for name in names:
        require_known(name, known, "there is no scheme", "Take all, or some as 'a,c' of")
    return [known[name] for name in names]
