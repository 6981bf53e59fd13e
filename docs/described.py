"""What the library page adds to docstrings: shared arguments, and the comments behind the fields of results."""

from __future__ import annotations

from inspect import cleandoc
from typing import Any

from griffe import Attribute, Class, Docstring, ExprSubscript, Extension, Function

from fric.verb import SHARED, documented


def shown(annotation: Any) -> Any:
    """Return a type without what only a command needs, ``Annotated[Quantity, "force"]`` as ``Quantity (force)``."""
    if not (isinstance(annotation, ExprSubscript) and str(annotation.left) == "Annotated"):
        return annotation
    kind, *beside = getattr(annotation.slice, "elements", [annotation.slice])
    dimensions = [str(one).strip("\"'") for one in beside if not str(one).startswith("Kind(")]
    return f"{shown(kind)} ({dimensions[0]})" if dimensions else shown(kind)


class Described(Extension):
    """Complete the docstrings of verbs and of the fields of dataclasses, as they stand in the source."""

    def on_function_instance(self, *, func: Function, **_: Any) -> None:
        """Make the sections of its docstring, of a verb with shared arguments, and show plain types."""
        for one in func.parameters:
            one.annotation = shown(one.annotation)
        if func.docstring:
            shared = SHARED if any(str(one.value) == "verb" for one in func.decorators) else {}
            names = [one.name for one in func.parameters]
            func.docstring.value = documented(cleandoc(func.docstring.value), names, shared)

    def on_class_members(self, *, cls: Class, **_: Any) -> None:
        """Make the sections of a class of the lines that describe its fields, its bases' among them."""
        if cls.docstring:
            names = [name for one in (cls, *cls.mro()) for name in one.attributes]
            made = (cls.members.get(name) for name in ("__init__", "__new__"))
            names += [one.name for function in made if isinstance(function, Function) for one in function.parameters]
            text = documented(cleandoc(cls.docstring.value), names, {})
            if "__init__" not in cls.members and "__new__" in cls.members:  # griffe looks for parameters in __init__
                text = text.replace("Parameters\n----------", "Attributes\n----------")
            cls.docstring.value = text

    def on_attribute_instance(self, *, attr: Attribute, **_: Any) -> None:
        """Take the comment behind a field for its docstring."""
        if attr.docstring is None and attr.annotation is not None and attr.lineno and attr.lines_collection:
            _, mark, text = attr.lines_collection[attr.filepath][attr.lineno - 1].partition("  # ")
            if mark:
                attr.docstring = Docstring(f"{text}.", lineno=attr.lineno, parent=attr)
