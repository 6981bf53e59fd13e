"""A command of fric's in this process, where its imports are made: its start alone would take longer than most."""

from typer.testing import CliRunner, Result

from fric.cli.main import app

RUN = CliRunner()


def fric(*words: object) -> Result:
    """Run a command that is to succeed; return its status and what it printed."""
    done = RUN.invoke(app, [*map(str, words)])
    if done.exception is not None:
        raise done.exception
    return done
