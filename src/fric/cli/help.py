"""Layout of the commands' help: in the order of the work, options in groups, with examples."""

import re
from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any

from typer.core import TyperCommand

PARTS: Mapping[str, Mapping[str, str]] = {
    "First": {
        "example": "Copy an example: logs of an axis and a measured circle.",
        "auto": "Go from a folder of logs to a decision and a page.",
        "help": "Show a page, a command, or what a warning means.",
    },
    "Logs": {
        "plan": "Plan the records that identify an axis, as programs.",
        "ingest": "Read logs of a drive into one log file.",
        "inspect": "Show what each record is, and what it is good for.",
    },
    "Friction and control": {
        "identify": "Identify plant, friction and controller from logs.",
        "compare": "Fit several friction models, and score them.",
        "validate": "Replay a recorded motion with a model.",
        "design": "Design controller, observer and control blocks.",
    },
    "Circles": {
        "simulate": "Simulate circles, paths and experiments.",
        "diagnose": "Take a measured circle apart; compare it with a machine.",
        "tune": "Refit a machine to recorded circles.",
        "learn": "Learn a repeated circle, round by round.",
    },
    "Results": {
        "export": "Write a compensation for a controller.",
        "report": "Make one page of results.",
        "reproduce": "Run the paper from end to end.",
        "schema": "Print the JSON Schema of a document type.",
    },
    "fric identify": {
        "plant": "The plant A, B, T_d and K_f, from a response or a motion.",
        "controller": "The gains, from a circle or a log in closed loop.",
        "static": "The static map F_c, F_s, v_s, from strokes.",
        "gms": "The GMS model, from pre-sliding cycles.",
        "replay": "Any friction model, fitted to any records by replay.",
    },
}
"""Commands in a few words: of `fric` by part, in the order of the work, and of a group by its name."""

EXAMPLES: Mapping[str, Sequence[str]] = {
    "example": ["example -o session", "example xy-table -o machine"],
    "auto": [
        "auto logs -o found",
        'auto logs -o found --circle circle.h5 --tolerance "5 um"',
        'auto logs -o found --controller "K_v=100 1/s, K_p=131 V*s/m, K_i=4090 V/m"',
    ],
    "help": ["help glossary", "help tune", "help force-lags"],
    "plan": [
        'plan --stroke "300 mm" --feed "100 mm/s" -o plan',
        "plan found/x/friction.yaml --machine found/machine.yaml -o next",
    ],
    "ingest": [
        "ingest stroke-*.csv --kind constant-velocity -o strokes.h5",
        "ingest log.txt --propose map.yaml",
        "ingest log.txt --map map.yaml -o log.h5",
        "ingest trace.csv --kind circle -o circle.h5",
    ],
    "inspect": ["inspect log.h5", "inspect log.h5 --plot log.png"],
    "identify plant": [
        "identify plant frequency-response.h5 -o plant.yaml",
        "identify plant motion.h5 --method motion -o plant.yaml",
    ],
    "identify controller": [
        "identify controller circle.h5 --axis y -o controller.yaml",
        "identify controller strokes.h5 -o controller.yaml",
    ],
    "identify static": ["identify static strokes.h5 --plant plant.yaml -o static.yaml"],
    "identify gms": ["identify gms sines.h5 --static static.yaml --plant plant.yaml -o friction.yaml"],
    "identify replay": ["identify replay motion.h5 --model lugre --plant plant.yaml -o friction.yaml"],
    "compare": ["compare sines.h5 strokes.h5", "compare motion.h5 --models lugre,gms --halves"],
    "validate": ["validate motion.h5 --friction friction.yaml --plant plant.yaml --controller controller.yaml"],
    "design controller": ["design controller plant.yaml -o controller.yaml"],
    "design observer": ["design observer plant.yaml response.h5 --controller controller.yaml -o observer.yaml"],
    "design block": ["design block list", "design block kalman plant.yaml -o block.yaml"],
    "simulate experiment": ["simulate experiment virtual-rig --kind constant-velocity -o strokes.h5"],
    "simulate circle": [
        'simulate circle xy-table --scheme a,c,f --velocity "50 mm/s"',
        "simulate circle found/machine.yaml --monte-carlo 100 --from-intervals -o run.h5",
    ],
    "simulate path": ["simulate path xy-table path.csv --scheme a,f"],
    "simulate map": ["simulate map xy-table --scheme a,f -o map.yaml"],
    "diagnose": ["diagnose circle.h5", "diagnose circle.h5 --machine found/machine.yaml --plot circle.png"],
    "tune": ["tune machine.yaml fast.h5 slow.h5 -o tuned"],
    "learn": ["learn xy-table --rounds 8 -o run.h5", "learn circle.h5 --machine machine.yaml -o next.h5"],
    "export": [
        "export c machine.yaml --axis x -o controller",
        "export linuxcnc found/machine.yaml --axis x --scheme c --run run.h5 --circle circle.h5 -o controller",
    ],
    "report": ["report friction.yaml run.h5 --circle circle.h5 -o report.html"],
    "reproduce": ["reproduce -o paper"],
    "schema": ["schema friction"],
}
"""Lines of the help of each command that show its use, without ``fric``."""

BELIEFS = ("nominal_files", "gain", "lead", "friction_model")
GROUPS: Mapping[str, Mapping[str, Sequence[str]]] = {
    "plan": {
        "Limits of the axis": ("stroke", "feed", "acceleration"),
        "What is known of it": ("friction", "plant", "machine", "axis", "like", "noise", "encoder"),
    },
    "identify plant": {"For responses": ("coherence", "lowest", "highest", "period", "segment", "hold")},
    "design controller": {"To check gains": ("K_p", "K_i", "K_v")},
    "simulate circle": {
        "What controllers know": BELIEFS,
        "Many machines": (
            "machines", "from_intervals", "measured", "spread", "seed", "accuracy", "workers", "scheduler",
        ),
    },
    "simulate path": {"What controllers know": BELIEFS},
    "simulate map": {"What controllers know": BELIEFS},
    "export": {"What the controller knows": BELIEFS, "Evidence for it": ("circles", "drawn")},
}  # fmt: skip
"""Options of a command by the title of their group."""
PREFIXES = {"Circle": "For circles", "Of a fleet": "For a fleet"}  # The same by the begin of an option's help
WIDTH = 80  # Largest width of a line of an example [columns]
OUTPUT = ("output", "plot", "plot_reversal", "json", "force", "help")  # Options for the places of results, listed last


def listed(homes: Mapping[str, Any], name: str, text_of: Any) -> dict[str, list[tuple[str, str]]]:
    """Return commands by part, each with a short description; by default the first sentence of its help.

    homes, name: The commands, and the name of their group.
    text_of: Returns the help of a command.
    """
    parts = {"Commands": PARTS.get(f"fric {name}", {})}
    if name == "fric":
        parts = {title: known for title, known in PARTS.items() if not title.startswith("fric ")}
    found = {title: [(key, text) for key, text in known.items() if key in homes] for title, known in parts.items()}
    known = {key for rows in found.values() for key, _ in rows}
    found[list(found)[-1]] += [
        (key, " ".join(text_of(key).partition("\n\n")[0].split())) for key in homes if key not in known
    ]
    return found


def _command(ctx: Any) -> str:
    """Return the name of a command without that of the program: ``identify gms``."""
    names = list[str]()
    while ctx.parent is not None:
        ctx, names = ctx.parent, [str(ctx.info_name), *names]
    return " ".join(names) or str(ctx.info_name).removeprefix("fric ")


class HelpfulCommand(TyperCommand):
    """A command whose help has its options in groups, and examples."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return places, required options, and the others in one word: ``LOGS… -o DIR [OPTIONS]``."""
        places, asked = list[str](), list[str]()
        for param in self.get_params(ctx):
            name = (param.metavar or str(param.name).upper()).strip("…")
            if param.param_type_name == "argument":
                name = f"{name}…" if param.nargs == -1 else name
                places.append(name if param.required else f"[{name}]")
            elif param.required:
                asked += [min(param.opts, key=len), name]
        return [*places, *asked, "[OPTIONS]"]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write places, then options by group."""
        parts = GROUPS.get(_command(ctx), {})
        named = {option: title for title, options in parts.items() for option in options}
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for param in self.get_params(ctx):
            if (record := param.get_help_record(ctx)) is None:
                continue
            names, text = record
            head, colon, rest = text.partition(": ")
            title = "Options" if param.param_type_name == "option" else "Arguments"
            if param.name in OUTPUT:
                title = "Output"
            elif colon and head in PREFIXES:
                title, text = PREFIXES[head], rest[0].upper() + rest[1:]
            title = named.get(str(param.name), title)
            if title == "Arguments":
                names = names.partition(" <")[0]
            groups.setdefault(title, []).append((names, text))
        groups["Output"] = groups.pop("Output", [])
        for title, records in groups.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the examples; a long line is continued as in a shell."""
        if lines := EXAMPLES.get(_command(ctx)):
            formatter.write("\nExamples:\n")
            for line in lines:
                words = re.split(r" (?=-)", f"  fric {line}")  # an option and its value stay together
                formatter.write(reduce(_continued, words) + "\n")


def _continued(text: str, words: str) -> str:
    """Return a command with more words, on a new line where they do not fit."""
    fits = len(text.rpartition("\n")[2]) + len(words) + 3 <= WIDTH
    return f"{text} {words}" if fits else f"{text} \\\n      {words}"
