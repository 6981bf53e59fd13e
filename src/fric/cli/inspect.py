"""`fric inspect`: what log files hold, and what they are good for."""

import fric
from fric.cli.console import finish
from fric.cli.options import Force, Json, LogFiles, Plot


def inspect(logs: LogFiles, plot: Plot = None, json: Json = False, force: Force = False) -> None:
    """Tell what each record of log files holds, and what it is good for."""
    finish(lambda _: fric.inspect(*logs), None, plot, json=json, force=force)
