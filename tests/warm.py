"""Import every module of fric: what is compiled is compiled then, and kept for all processes that follow."""

import importlib
import pkgutil

import fric


def modules() -> list[str]:
    """Return the names of all modules of fric that can be imported without being run."""
    return [one.name for one in pkgutil.walk_packages(fric.__path__, "fric.") if one.name != "fric.__main__"]


if __name__ == "__main__":
    for name in modules():
        importlib.import_module(name)
