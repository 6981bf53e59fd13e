"""The group `fric simulate`: one subcommand a file."""

from fric.cli.group import group

app = group(
    "simulate",
    "Virtual experiments, and the circular test.",
    {name: f"fric.cli.simulate.{name}:{name}" for name in ("experiment", "circle", "path")}
    | {"map": "fric.cli.simulate.circle_map:circle_map"},
)
