"""fric: friction identification and compensation for feed drives.

    static = fric.identify_static("strokes.h5")
    static.F_c                                  # a value with its unit and 95 % interval
    friction = fric.identify_gms("sines.h5", static=static)
    fric.circle("machine.yaml", "all")          # the glitch under each compensation

The names below are records, models, machines, and verbs on them: ``fric.__all__`` lists them. Each is loaded when it is
first used; ``__init__.pyi`` says where it is from, for type checkers and for this.
"""

import re
from importlib import import_module
from pathlib import Path
from sys import modules
from typing import Any

__version__ = "0.2.0"

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOMES = {name: module for module, name in re.findall(r"^from (\S+) import (\w+) as \2$", _STUB, re.MULTILINE)}

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if (home := _HOMES.get(name)) is None and not name.startswith("_"):
        from fric.verb import verbs_in

        home = verbs_in("fric.results").get(name, "").partition(":")[0]  # of a verb that the stub does not name
    if not home:
        from fric.errors import near

        alike = [other for other in __all__ if name in other.split("_") or other == name.rpartition("_")[2]]
        meant = f"Is it {' or '.join(alike)}?" if alike else near(name, __all__).rstrip()
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'{'. ' if meant else ''}{meant}")
    if isinstance(found := getattr(import_module(home, __name__), name), type):
        from fric.verb import explained, typed

        found = explained(typed(found) if hasattr(found, "report") else found)  # a result takes anything
    globals()[name] = found
    return found


def explain_loaded() -> None:
    """Let the classes among the names below that are loaded explain their arguments, as `__getattr__` does."""
    for name, home in _HOMES.items():
        if name not in globals() and hasattr(modules.get(__name__ + home), name):
            __getattr__(name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
