"""The group `fric identify`: one subcommand a file."""

from functools import partial

from fric.cli.group import Home, group
from fric.cli.identify import by_replay

OWN: dict[str, Home] = {name: f"fric.cli.identify.{name}:{name}" for name in ("plant", "static", "gms")}
"""What has a subcommand of its own."""

app = group(
    "identify",
    "Identify friction and plant from logs.",
    OWN
    | {model: partial(by_replay.command, model) for model in by_replay.MODELS if model not in OWN}
    | {"replay": by_replay.command},
)
