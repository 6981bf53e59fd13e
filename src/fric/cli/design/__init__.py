"""The group `fric design`: one subcommand a file."""

from fric.cli.group import group

app = group(
    "design",
    "Design controller, disturbance observer and other control blocks of an axis.",
    {name: f"fric.cli.design.{name}:{name}" for name in ("controller", "observer", "block")},
)
