"""The commands: the verb of each, and what a terminal adds to it."""

import re
from pathlib import Path

import fric
from fric.cli.command import READ_MACHINE, Command, Home, Output, file_option, flag, group
from fric.cli.special import OF_CIRCLES
from fric.columns import CIRCLE, KINDS
from fric.verb import folders, verbs_in


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


MODELS = models_in(*folders("fric.friction"))  # Every model that can be identified, with its description

FRICTION = Output("FRICTION.yaml", "Friction file to write.")


def _replayed(text: str, **beside: object) -> Command:
    settings = {"output": FRICTION, "plot": True, "helps": {"model": f"One of {', '.join(MODELS)}."}} | beside
    text = f"{text.removesuffix('.')}. Fitted by replay."
    return Command("fric.results.identify:identify_model", text=text, options=["model"], **settings)  # type: ignore[arg-type]


IDENTIFY: dict[str, Home] = {
    "plant": Command(
        "fric.results.identify:identify_plant", Output("PLANT.yaml", "Plant file to write."), plot=True, doing="plant"
    ),
    "controller": Command(
        "fric.results.identify:identify_controller", Output("CONTROLLER.yaml", "Controller file to write."),
        doing="gains",
    ),
    "static": Command("fric.results.identify:identify_static", FRICTION, plot=True, doing="friction map"),
    "gms": Command(
        "fric.results.identify:identify_gms", FRICTION, plot=True, doing="virgin curve and replay",
        run="fric.cli.special:gms",
        terminal=[flag("interactive", "Move the knots by hand on a page, served to this computer only.")],
    ),
}  # fmt: skip
_FITTED = {name: text for name, text in MODELS.items() if name not in IDENTIFY}
IDENTIFY |= {name: _replayed(text, bound={"model": name}, doing=f"fitting {name}") for name, text in _FITTED.items()}
IDENTIFY["replay"] = _replayed("Any friction model, to any records.", doing="fitting")

DESIGN: dict[str, Home] = {
    "controller": Command(
        "fric.results.design:design_controller",
        Output("CONTROLLER.yaml", "The controller file to write.", required=False), plot=True,
        flags={name: f"--{name}" for name in ("K_p", "K_i", "K_v")},
    ),
    "observer": Command(
        "fric.results.design:design_observer", Output("OBSERVER.yaml", "The observer file to write.", required=False),
        plot=True, places=["log"], flags={"resonances": "--resonance"},
    ),
    "block": Command(
        "fric.results.design:design_block", Output("BLOCK.yaml", "The block file to write.", required=False),
        places=["plant", "log"], optional=["plant"], run="fric.cli.special:block",
    ),
}  # fmt: skip

RUN = Output("RUN.h5", "Keep traces and metrics in this file.", required=False, writes="HDF5")
BELIEFS = ("nominal_files", "gain", "lead")  # Options for models that controllers use in place of the machine's
CONTOUR = {"schemes": "--scheme", "known": "--schemes", "nominal_files": "--friction --with"}
FEED = {"velocity": "--velocity --feed"}

SIMULATE: dict[str, Home] = {
    "experiment": Command(
        "fric.results.experiment:experiment", Output("LOG.h5", "The log file to write.", writes="HDF5"),
        doing="experiments",
    ),
    "circle": Command(
        "fric.results.simulate:circle", RUN, plot=True, doing="circles",
        flags=CONTOUR | FEED | {"machines": "--monte-carlo"},
        further={READ_MACHINE: (*BELIEFS, "friction_model")}, run="fric.cli.special:circle",
        terminal=[
            flag("from_intervals", "Draw identified parameters from their 95 % intervals instead."),
            file_option("plot_reversal", "Draw error and voltages over time near a reversal.", "FIG"),
        ],
    ),
    "path": Command(
        "fric.results.simulate:path", RUN, plot=True, doing="schemes", flags=CONTOUR | FEED,
        further={READ_MACHINE: BELIEFS},
    ),
    "map": Command(
        "fric.results.simulate:circle_map", Output("MAP.yaml", "Keep the map in this file.", required=False),
        plot=True, plausible=False, doing="circles", flags=CONTOUR, further={READ_MACHINE: BELIEFS},
        run="fric.cli.special:circle_map",
    ),
}  # fmt: skip

INTERACTIVE = flag("interactive", "State what the columns are on a page with sketches, served to this computer only.")

COMMANDS: dict[str, Home] = {
    "auto": Command(
        "fric.automatic.run:auto", replaces=False, without=["run", "say", "ask"], run="fric.cli.special:auto",
        flags={"output": "-o --output", "circles": "--circle", "controllers": "--controller", "mapping": "--map"},
        terminal=[INTERACTIVE],
    ),
    "ingest": Command(
        "fric.results.ingest:ingest", doing="ingesting", plausible=False, optional=["files", "output"], without=["ask"],
        flags={
            "output": "-o --output", "mapping": "--map", "begin": "--from", "end": "--to",
            "clockwise": "--clockwise/--counter-clockwise",
        },
        helps={"kind": f"What was logged: {', '.join((*KINDS, CIRCLE))}."},
        further={"fric.results.ingest:ingest_circles": OF_CIRCLES}, run="fric.cli.special:ingest",
        terminal=[
            file_option("propose", "Write the guessed mapping (-: print it); ingest nothing.", "MAP.yaml"),
            INTERACTIVE,
            flag("list_formats", "List the formats that fric reads, and which libraries are installed.", "--list"),
        ],
    ),
    "inspect": Command("fric.results.records:inspect", plot=True, plausible=False),
    "report": Command(
        "fric.report.summary:make_report", Output("REPORT.html", "The page to write.", writes="HTML"), plausible=False,
        doing="machines", flags={"circles": "--circle"},
    ),
    "schema": "fric.cli.special:schema",
    "reproduce": Command(
        "fric.reproduce.paper:reproduce_paper", plausible=False, replaces=False, doing="reproduce",
        flags={"folder": "-o --output"},
    ),
    "plan": Command(
        "fric.results.plan:plan",
        Output("DIR", "Folder for the plan and its programs.", required=False, writes="", holds="plan.yaml"),
        plot=True, plausible=False, doing="expected intervals", places=["last"], optional=["last", "stroke", "feed"],
        without=["draws"], further={"fric.results.plan:plan_next": ("last", "scheme")}, run="fric.cli.special:plan",
    ),
    "compare": Command(
        "fric.results.compare:compare", plot=True, doing="fitting",
        helps={"models": f"Models to compare, of {', '.join(MODELS)}."},
    ),
    "diagnose": Command("fric.results.circles:diagnose", plot=True, doing="predicting", flags={"known": "--schemes"}),
    "tune": Command(
        "fric.results.circles:tune", Output("DIR", "Folder for what is written.", writes="", holds="machine.yaml"),
        doing="tuning", run="fric.cli.special:tune",
    ),
    "learn": Command(
        "fric.results.circles:learn",
        Output("OUT.h5", "Run file of the rounds; or feedforward of the next.", required=False, writes="HDF5"),
        plot=True, doing="circles", flags=FEED | {"observer": "--observer/--no-observer"}, run="fric.cli.special:learn",
    ),
    "validate": Command("fric.results.compare:validate", plot=True, doing="replaying"),
    "export": Command(
        "fric.results.export:export_axis", Output("DIR", "Folder for the files.", writes="", holds="manifest.json"),
        run="fric.cli.special:export", without=["trial"], doing="circles",
        flags={
            "single": "--float", "nominal_files": "--friction --with", "known": "--schemes", "circles": "--circle",
            "drawn": "--run",
        },
        helps={"force": "Replace files that exist, and export what is not to be trusted."},
        terminal=[flag(
            "try_it", "linuxcnc, from a checkout of fric: run circles in LinuxCNC, beside their simulation.", "--try"
        )],
    ),
    "example": Command(
        "fric.results.example:example", plausible=False, places=["name"], flags={"output": "-o --output"}
    ),
    "help": "fric.cli.special:manual",
    "design": group("design", "Design controller, disturbance observer and other control blocks of an axis.", DESIGN),
    "identify": group("identify", "Identify friction and plant from logs.", IDENTIFY),
    "simulate": group("simulate", "Virtual experiments, and the circular test.", SIMULATE),
}  # fmt: skip
_FURTHER = {name: home for name, home in verbs_in("fric.results").items() if name not in dir(fric)}
COMMANDS |= {name.replace("_", "-"): Command(home, plot=True) for name, home in _FURTHER.items()}
"""A verb in a file that the table above does not name becomes a command without further settings."""
