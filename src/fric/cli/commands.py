"""The commands: of each its verb, and what a terminal adds to it."""

import re
import sys
from pathlib import Path
from typing import Annotated

import fric
from fric.cli.command import READ_MACHINE, Command, Output
from fric.cli.group import Home, group
from fric.cli.signature import option, parameter


def models_in(*folders: Path | str) -> dict[str, str]:
    """Return the models whose files are in folders: name, and the first sentence of the file's docstring.

    They are found by reading their files, not by importing them: `--help` needs no compiler.
    """
    found = {}
    for path in sorted(path for folder in folders for path in Path(folder).glob("*.py")):
        source = path.read_text(encoding="utf-8")
        name = re.search(r'^    name\b[^=\n]*= "(\w+)"', source, re.MULTILINE)
        if name and not re.search(r"^    identified\b[^=\n]*= False", source, re.MULTILINE):
            found[name[1]] = source.split('"""')[1].strip().splitlines()[0]
    return found


_ROOM = sys.modules.get("fric.friction")
MODELS = models_in(*(_ROOM.__path__ if _ROOM else [Path(fric.__file__).parent / "friction"]))
"""Every model that can be identified, and what it is."""

FRICTION = Output("FRICTION.yaml", "Friction file to write.")

COMPARE = Command(
    "fric.results.compare:compare", plot=True, doing="fitting",
    helps={"models": f"Models to compare, of {', '.join(MODELS)}."},
)  # fmt: skip


def _replayed(text: str, **beside: object) -> Command:
    settings = {"output": FRICTION, "plot": True, "helps": {"model": f"One of {', '.join(MODELS)}."}} | beside
    text = f"Fit by replay: {text[0].lower()}{text[1:]}"
    return Command("fric.results.model:identify_model", text=text, options=["model"], **settings)  # type: ignore[arg-type]


IDENTIFY: dict[str, Home] = {
    "plant": Command(
        "fric.results.plant:identify_plant", Output("PLANT.yaml", "Plant file to write."), plot=True, doing="plant"
    ),
    "static": Command("fric.results.static:identify_static", FRICTION, plot=True, doing="friction map"),
    "gms": Command(
        "fric.results.gms:identify_gms", FRICTION, plot=True, doing="virgin curve and replay",
        run="fric.cli.special:gms",
        own=[parameter("interactive", Annotated[
            bool, option("Move the knots by hand, on a page that this computer alone sees.", "--interactive")
        ], False)],
    ),
}  # fmt: skip
IDENTIFY |= {
    name: _replayed(text, bound={"model": name}, doing=f"fitting {name}")
    for name, text in MODELS.items()
    if name not in IDENTIFY
}
IDENTIFY["replay"] = _replayed("Any friction model, to any records.", doing="fitting")

DESIGN: dict[str, Home] = {
    "controller": Command(
        "fric.results.controller:design_controller",
        Output("CONTROLLER.yaml", "The controller file to write.", required=False), plot=True,
        flags={name: f"--{name}" for name in ("K_p", "K_i", "K_v")},
    ),
    "observer": Command(
        "fric.results.observer:design_observer",
        Output("OBSERVER.yaml", "The observer file to write.", required=False), plot=True,
        places=["log"], flags={"resonances": "--resonance"},
    ),
    "block": Command(
        "fric.results.block:design_block", Output("BLOCK.yaml", "The block file to write.", required=False),
        places=["plant", "log"], optional=["plant"], run="fric.cli.special:block",
    ),
}  # fmt: skip

RUN = Output("RUN.h5", "Keep traces and metrics in this file.", required=False, writes="HDF5")
BELIEFS = ("nominal_files", "gain", "lead")
"""What the controllers of a machine believe, instead of what its file says."""
CONTOUR = {"schemes": "--scheme", "known": "--schemes", "nominal_files": "--friction --with"}

SIMULATE: dict[str, Home] = {
    "experiment": Command(
        "fric.results.experiment:experiment", Output("LOG.h5", "The log file to write.", writes="HDF5"),
        doing="experiments",
    ),
    "circle": Command(
        "fric.results.circle:circle", RUN, plot=True, doing="circles", flags=CONTOUR | {"machines": "--monte-carlo"},
        further={READ_MACHINE: (*BELIEFS, "friction_model")}, run="fric.cli.special:circle",
        more="With --monte-carlo the test runs on many machines: how the glitch of each scheme is distributed over "
        "them, and how often each scheme is the best. Ctrl-C keeps the machines that are done.",
        own=[
            parameter("from_intervals", Annotated[
                bool, option("Draw what was identified from its 95 % intervals instead.", "--from-intervals")
            ], False),
            parameter("plot_reversal", Annotated[
                Path | None, option("Draw error and voltages over time near a reversal.", metavar="FIG")
            ], None),
        ],
    ),
    "path": Command(
        "fric.results.path:path", RUN, plot=True, doing="schemes", flags=CONTOUR, further={READ_MACHINE: BELIEFS},
    ),
    "map": Command(
        "fric.results.circle_map:circle_map", Output("MAP.yaml", "Keep the map in this file.", required=False),
        plot=True, plausible=False, doing="circles", flags=CONTOUR, further={READ_MACHINE: BELIEFS},
        more="Ctrl-C keeps the circles that are done; the others stay empty.", run="fric.cli.special:circle_map",
    ),
}  # fmt: skip

COMMANDS: dict[str, Home] = {
    "auto": "fric.cli.auto:auto",
    "ingest": "fric.cli.ingest:ingest",
    "inspect": Command("fric.results.records:inspect", plot=True, plausible=False),
    "report": "fric.cli.report:report",
    "schema": "fric.cli.schema:schema",
    "reproduce": "fric.cli.reproduce:reproduce",
    "plan": "fric.cli.plan:plan",
    "compare": COMPARE,
    "diagnose": "fric.cli.diagnose:diagnose",
    "tune": "fric.cli.tune:tune",
    "learn": "fric.cli.learn:learn",
    "validate": Command("fric.results.validate:validate", plot=True, doing="replaying"),
    "export": "fric.cli.export:export",
    "example": "fric.cli.example:example",
    "help": "fric.cli.manual:manual",
    "design": group("design", "Design controller, disturbance observer and other control blocks of an axis.", DESIGN),
    "identify": group("identify", "Identify friction and plant from logs.", IDENTIFY),
    "simulate": group("simulate", "Virtual experiments, and the circular test.", SIMULATE),
}
