"""Files that come with fric: machines, schemes and mappings by name, from a checkout or an installed wheel."""

import re
from functools import cache
from pathlib import Path
from textwrap import fill

import fric
from fric.documents import document_types
from fric.errors import FricError, as_options, near, require_known
from fric.input import missing
from fric.verb import verb

RIG = "rig"  # The example of the README: logs of the virtual rig, and the rig itself


def folder(name: str) -> Path:
    """Return a folder that comes with fric: ``configs``, ``data`` or ``docs``."""
    package = Path(fric.__file__).parent
    return next((place / name for place in (package, package.parents[1]) if (place / name).is_dir()), package / name)


@verb
@cache
def bundled(kind: str) -> dict[str, Path]:
    """Return the bundled documents of a type by their names: ``xy-table`` and ``virtual-rig`` of ``machine``, …."""
    head, files = f"fric: {kind}/", sorted(folder("configs").rglob("*.yaml"))
    if not (found := {path.stem: path for path in files if head in path.read_text("utf-8")}):
        require_known(kind, document_types(), "there is no type of document")
    return found


def located(path: Path, kind: str) -> Path:
    """Return a path, or the bundled document of that name if there is no such file, or that in a folder of `auto`."""
    known, inside = bundled(kind), path / f"{kind}.yaml"
    if str(path) in known and not path.is_file():
        return known[str(path)]
    if inside.is_file():
        return inside
    if path.exists():
        return path
    raise missing(path, [name for name, file in known.items() if file.parent == folder("configs")], kind)


KINDS = ("machine", "mapping", "schemes", "spread", "controller")  # Types of documents that are examples by their names


def examples() -> dict[str, str]:
    """Return the names that `example` takes, each with the type of its document; `RIG` is of logs and a machine."""
    return {RIG: "logs"} | {name: kind for kind in KINDS for name in bundled(kind)}


def example(name: str) -> dict[str, bytes]:
    """Return the files of an example by their paths: a bundled document, and its files; of `RIG` logs, too.

    Raises FricError: When there is no such example; the message has a similar name.
    """
    require_known(name, examples(), "there is no example")
    files: dict[str, bytes] = {}
    if name == RIG:
        logs = (path for path in sorted(folder("data").rglob("*")) if path.suffix in {".h5", ".csv"})
        files = {f"data/{path.relative_to(folder('data')).as_posix()}": path.read_bytes() for path in logs}
        name = "virtual-rig"
    pending = [bundled(examples()[name])[name]]
    while pending:
        path = pending.pop()
        files[f"configs/{path.relative_to(folder('configs')).as_posix()}"] = path.read_bytes()
        for other in (path.parent / word for word in re.findall(r"[\w./-]+\.yaml\b", path.read_text("utf-8"))):
            if other.is_file() and other not in pending and f"configs/{_within(other)}" not in files:
                pending.append(folder("configs") / _within(other))
    return files


def _within(path: Path) -> str:
    return path.resolve().relative_to(folder("configs").resolve()).as_posix()


def topics() -> dict[str, Path]:
    """Return the pages of `fric help` by their names."""
    return {path.stem: path for path in sorted(folder("docs").glob("*.md"))}


def page(name: str) -> str:
    """Return the text of a page, or the meaning of a warning's code, or of a term or symbol of the glossary."""
    known = topics()
    if name in known:
        return known[name].read_text("utf-8")
    from fric.flaws import CATALOGUE, entry

    if name in CATALOGUE:
        parts = as_options(entry(CATALOGUE[name])).split("\n\n")
        return "\n\n".join(fill(part, 80, break_long_words=False, break_on_hyphens=False) for part in parts) + "\n"
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", known["glossary"].read_text("utf-8"), re.MULTILINE)[1:]
    if found := [f"{word}: {meaning}\n" for word, meaning in rows if _folded(name) in _folded(word)]:
        return "".join(found)
    hint = f"{near(name, [*known, *CATALOGUE, *dict(rows)])}`fric help` lists the pages; the glossary has the symbols."
    raise FricError(f"there is no page '{name}'", hint=hint)


def _folded(words: str) -> str:
    return f" {re.sub('[-(),]', '', words.casefold())} "
