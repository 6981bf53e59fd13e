"""What verbs take, as annotations: what Python checks, and how a command reads, completes and names it.

Importing this loads nothing: a command's help is made of it. What a type stands for is read where the verb is run
(`given`, `given_models`).
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from fric.columns import CIRCLE, KINDS
from fric.columns import Kind as LogKind
from fric.verb import Kind

if TYPE_CHECKING:  # each brings what a command's help does without
    from fric.circles.measured import MeasuredCircle
    from fric.control.cascade import Cascade
    from fric.control.scheme import Scheme
    from fric.design.perturbation import StructuralMode
    from fric.documents.controller import ControllerDocument
    from fric.documents.friction import FrictionDocument
    from fric.documents.identified import IdentifiedMachine
    from fric.documents.mapping import MappingDocument
    from fric.documents.plan import PlanDocument
    from fric.documents.plant import PlantDocument
    from fric.drive.plant import Plant
    from fric.friction.stribeck import StaticMap
    from fric.log import Record
    from fric.results.base import Result
    from fric.simulate.machine import Machine
    from fric.simulate.path import PointPath, RecordedPath
    from fric.simulate.spread import Spread

Quantity = float | str
"""A number in SI, or a text with its unit; its dimension stands beside it: ``Annotated[Quantity, "force"]``."""
METAVARS = {
    "time": "TIME", "frequency": "FREQUENCY", "position": "LENGTH", "velocity": "SPEED", "force": "FORCE",
    "angle": "ANGLE", "gain": "GAIN", "mass": "MASS", "input": "VOLTAGE", "acceleration": "ACCELERATION",
    "force per input": "K_F", "rate": "GAIN", "velocity gain": "GAIN", "position gain": "GAIN",
}  # fmt: skip
"""What stands for a quantity in a help text, by its dimension."""
Quantities: TypeAlias = Annotated[Sequence[float | str] | float | str, Kind(str)]
"""Several of them: also as a text with commas."""
Count: TypeAlias = Annotated[int, Kind(least=1, most=1_000_000)]
"""A number of things."""
Seed: TypeAlias = Annotated[int, Kind(least=0, most=2**32 - 1)]
"""The seed of what is drawn at random."""
EncoderName: TypeAlias = Literal["motor", "load"]
"""One of two encoders of an axis."""
LogLike: TypeAlias = Annotated["Record | Path | str | Iterable[Record | Path | str]", Kind(Path, "LOG.h5")]
"""A log file, its records as `fric.read` returns them, or a list of both."""
PlantLike: TypeAlias = Annotated["Plant | PlantDocument | Result | Path | str", Kind(Path, "PLANT.yaml")]
"""A plant: itself, its file, or the result that found it."""
ControllerLike: TypeAlias = Annotated[
    "Cascade | ControllerDocument | Result | Path | str", Kind(Path, "CONTROLLER.yaml")
]
"""A cascade: itself, its file, or the result that designed it."""
FrictionLike: TypeAlias = Annotated["StaticMap | FrictionDocument | Result | Path | str", Kind(Path, "FRICTION.yaml")]
"""What is known of friction: a static map, a friction file, or the result that found it."""
MachineFile: TypeAlias = Annotated[Path | str, Kind(metavar="MACHINE.yaml")]
"""A machine file, or the name of a bundled machine."""
MachineLike: TypeAlias = Annotated["Machine | IdentifiedMachine | Path | str", Kind(Path, "MACHINE.yaml")]
"""A machine: itself, as identified, its file, or the name of a bundled one."""
MappingLike: TypeAlias = Annotated["MappingDocument | Path | str", Kind(Path, "MAP.yaml")]
"""What the columns of foreign logs mean, or the file of it."""
RecordKind: TypeAlias = Annotated[LogKind, Kind(Literal[(*KINDS, CIRCLE)], "KIND")]
"""What was logged."""
PlanLike: TypeAlias = Annotated["PlanDocument | Result | Path | str", Kind(Path, "PLAN")]
"""A plan, its file or its folder, or the result that made it."""
CircleLike: TypeAlias = Annotated[
    "MeasuredCircle | Result | Path | str | Sequence[MeasuredCircle]", Kind(Path, "CIRCLE.h5")
]
"""A measured circle or a simulated run, or the file of either; or a list of circles."""
CirclesLike: TypeAlias = Annotated[
    "MeasuredCircle | Path | str | Sequence[MeasuredCircle | Path | str]", Kind(list[Path], "CIRCLE.h5")
]
"""One of them, or several."""
PathLike: TypeAlias = Annotated["PointPath | RecordedPath | Path | str", Kind(Path, "PATH.csv")]
"""A path, or the file of its points."""
ResonancesLike: TypeAlias = Annotated["Iterable[str | StructuralMode]", Kind(list[str], "FREQUENCY,DAMPING[,SHARE]")]
"""Modes, each also as a text: frequency, damping, share."""
SpreadsLike: TypeAlias = Annotated["Mapping[str, Spread] | Path | str", Kind(Path, "SPREAD.yaml")]
"""What is drawn how widely, by name, or the file of it."""
CircleFiles: TypeAlias = Annotated[Sequence[Path | str], Kind(list[Path], "CIRCLE.h5")]
"""Files of measured circles."""
SchemeName: TypeAlias = Annotated[str, Kind(metavar="SCHEME", complete="schemes")]
"""The name of a compensation scheme."""
SchemesLike: TypeAlias = Annotated["str | Scheme | Iterable[str | Scheme]", Kind(str, "SCHEME", "schemes")]
"""A scheme, several, or their names as ``a,c,f`` or ``all``."""
KnownSchemes: TypeAlias = Annotated["Mapping[str, Scheme] | Path | str", Kind(Path, "SCHEMES.yaml")]
"""Schemes by name, or their file."""
AxisName: TypeAlias = Annotated[str, Kind(metavar="AXIS", complete="axes")]
"""The name of an axis."""
Reported: TypeAlias = Annotated["Result | Machine | Path | str", Kind(Path, "FILE")]
"""What a report is made of: a file, or a result or machine in place of the file that it saves."""
RecordName: TypeAlias = Annotated[str, Kind(metavar="NAME", complete="records")]
"""The name of a record."""
Address: TypeAlias = Annotated[str, Kind(metavar="ADDRESS")]
"""The address of a Dask cluster."""
