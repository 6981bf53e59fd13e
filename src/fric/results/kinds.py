"""Annotations of verbs' arguments: Python checks them, and a command reads, completes and names its options by them.

Importing this loads nothing, since a command's help needs it. Values are read when the verb runs (`given`,
`given_models`).
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
    from fric.documents.controller import ControllerDocument
    from fric.documents.friction import FrictionDocument
    from fric.documents.machine_files import IdentifiedMachine
    from fric.documents.mapping import MappingDocument
    from fric.documents.plan import PlanDocument
    from fric.documents.plant import PlantDocument
    from fric.drive.plant import Plant
    from fric.friction.stribeck import StaticMap
    from fric.log import Record
    from fric.results.base import Result
    from fric.simulate.machine import Machine

Quantity = float | str
"""A number in SI, or a text with its unit; the annotation has its dimension: ``Annotated[Quantity, "force"]``."""
Quantities: TypeAlias = Annotated[Sequence[float | str] | float | str, Kind(str), "quantities"]
"""Several quantities, also as a text with commas."""
Count: TypeAlias = Annotated[int, Kind(least=1, most=1_000_000)]  # A number of things
Blocks: TypeAlias = Annotated[int, Kind(least=1, most=12)]  # Slip blocks: a fit's time grows with their square
Workers: TypeAlias = Annotated[int, Kind(least=1, most=512)]  # Processes, of 0.15 GB each
Seed: TypeAlias = Annotated[int, Kind(least=0, most=2**32 - 1)]  # A seed of random numbers
EncoderName: TypeAlias = Literal["motor", "load"]  # The name of one of two encoders of an axis
LogLike: TypeAlias = Annotated["Record | Path | str | Iterable[Record | Path | str]", Kind(Path, "LOG.h5")]
"""A log file, its records as `fric.read` returns them, or a list of both."""
PlantLike: TypeAlias = Annotated["Plant | PlantDocument | Result | Path | str", Kind(Path, "PLANT.yaml")]
"""A plant: given directly, as its file, or as the result that found it."""
ControllerLike: TypeAlias = Annotated[
    "Cascade | ControllerDocument | Result | Path | str", Kind(Path, "CONTROLLER.yaml")
]
"""A cascade: given directly, as its file, or as the result that designed it."""
FrictionLike: TypeAlias = Annotated["StaticMap | FrictionDocument | Result | Path | str", Kind(Path, "FRICTION.yaml")]
"""Identified friction: a static map, a friction file, or the result that found it."""
MachineFile: TypeAlias = Annotated[Path | str, Kind(metavar="MACHINE.yaml", complete="machines")]
"""A machine file, or the name of a bundled machine."""
MachineLike: TypeAlias = Annotated["Machine | IdentifiedMachine | Path | str", Kind(Path, "MACHINE.yaml", "machines")]
"""A machine: given directly, as identified, as its file, or by the name of a bundled machine."""
MappingLike: TypeAlias = Annotated["MappingDocument | Path | str", Kind(Path, "MAP.yaml")]
"""A mapping of the columns of foreign logs, or its file."""
RecordKind: TypeAlias = Annotated[LogKind, Kind(Literal[(*KINDS, CIRCLE)], "KIND")]  # What was logged
PlanLike: TypeAlias = Annotated["PlanDocument | Result | Path | str", Kind(Path, "PLAN")]
"""A plan, its file or its folder, or the result that made it."""
CircleLike: TypeAlias = Annotated[
    "MeasuredCircle | Result | Path | str | Sequence[MeasuredCircle]", Kind(Path, "CIRCLE.h5")
]
"""A measured circle or a simulated run, or the file of either; or a list of circles."""
CirclesLike: TypeAlias = Annotated[
    "MeasuredCircle | Path | str | Sequence[MeasuredCircle | Path | str]", Kind(list[Path], "CIRCLE.h5")
]
"""A measured circle, or several."""
CircleFiles: TypeAlias = Annotated[Sequence[Path | str], Kind(list[Path], "CIRCLE.h5")]  # Files of measured circles
SchemeName: TypeAlias = Annotated[str, Kind(metavar="SCHEME", complete="schemes")]  # The name of a compensation scheme
SchemesLike: TypeAlias = Annotated["str | Scheme | Iterable[str | Scheme]", Kind(str, "SCHEME", "schemes")]
"""A scheme, several, or their names as ``a,c,f`` or ``all``."""
KnownSchemes: TypeAlias = Annotated["Mapping[str, Scheme] | Path | str", Kind(Path, "SCHEMES.yaml")]
"""Schemes by name, or their file."""
AxisName: TypeAlias = Annotated[str, Kind(metavar="AXIS", complete="axes")]  # The name of an axis
RecordName: TypeAlias = Annotated[str, Kind(metavar="NAME", complete="records")]  # The name of a record
Address: TypeAlias = Annotated[str, Kind(metavar="ADDRESS")]  # The address of a Dask cluster
