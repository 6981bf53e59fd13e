"""A compiled step as a program of a few kinds of statements that all languages of controllers have.

Types are real, integer, boolean, records of these, and two arrays: the state and the parameters, with the same names in
every routine. Statements are assignments, branches, and loops of a fixed number of passes; there is no recursion and no
allocation. A routine that is called on several parts of an array is written for each part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Scalar:
    """``real``, ``integer`` or ``boolean``."""

    kind: str


REAL, INTEGER, BOOLEAN = Scalar("real"), Scalar("integer"), Scalar("boolean")


@dataclass(frozen=True)
class Record:
    """A group of named values."""

    name: str
    fields: tuple[tuple[str, Scalar], ...]


@dataclass(frozen=True)
class Array:
    """An array of reals, or a part of an array."""

    symbol: str  # The name of the whole array, ``state`` or ``parameters``, in every routine
    size: int  # How many numbers it has
    first: int  # Where the part begins in the whole
    whole: int  # How many numbers the whole array has

    @classmethod
    def of(cls, symbol: str, size: int) -> Array:
        """Return a whole array."""
        return cls(symbol, size, 0, size)

    @property
    def base(self) -> Array:
        """The whole array."""
        return Array.of(self.symbol, self.whole)


@dataclass(frozen=True)
class Absent:
    """An argument of a step in the library that controllers lack: the table of future commands to an axis."""

    what: str


Type = Scalar | Record | Array | Absent


class Node:
    """An expression or a statement: what `walk` comes by."""


@dataclass(frozen=True)
class Constant(Node):
    """A number, or a truth value."""

    value: float | int | bool
    type: Scalar


@dataclass(frozen=True)
class Name(Node):
    """A variable."""

    name: str
    type: Type


@dataclass(frozen=True)
class Element(Node):
    """An element of an array."""

    array: Name
    index: Expression
    type: Scalar = REAL


@dataclass(frozen=True)
class Field(Node):
    """A field of a record."""

    record: Name
    field: str
    type: Scalar


@dataclass(frozen=True)
class Operation(Node):
    """An operation on one, two or (``select``: condition, then, else) three values.

    ``+ - * /`` on numbers, ``//`` and ``%`` on integers, ``< <= > >= == !=``, ``and or not``, ``negate``, ``select``,
    ``to real``.
    """

    operator: str
    operands: tuple[Expression, ...]
    type: Scalar


@dataclass(frozen=True)
class Call(Node):
    """A call of a routine of the program, or of a function available in every language."""

    function: str
    arguments: tuple[Expression, ...]
    type: Type


Expression = Constant | Name | Element | Field | Operation | Call


@dataclass(frozen=True)
class Assign(Node):
    """``target = value``."""

    target: Name | Element | Field
    value: Expression


@dataclass(frozen=True)
class Branch(Node):
    """``if condition: then; else: otherwise``."""

    condition: Expression
    then: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class Count(Node):
    """``for variable in range(stop): body``."""

    variable: Name
    stop: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True)
class Evaluate(Node):
    """A call for its effect."""

    call: Call


Statement = Assign | Branch | Count | Evaluate


@dataclass(frozen=True)
class Routine:
    """A function of a program."""

    name: str  # Its name, unique in the program
    arguments: tuple[Name, ...]  # What it takes
    body: tuple[Statement, ...]  # What it does
    result: Expression | None  # Its return value; None for none
    note: str  # The first line of its docstring

    @property
    def nodes(self) -> Iterator[Node]:
        """Every statement and expression of its body and its result, in their order."""
        return walk(*self.body, *(() if self.result is None else (self.result,)))


@dataclass(frozen=True)
class Program:
    """Routines in an order in which each comes after those that it calls."""

    routines: tuple[Routine, ...]
    records: tuple[Record, ...]  # The records that they use

    def calls(self, intrinsic: str) -> bool:
        """Return whether the program calls an intrinsic function."""
        nodes = (node for routine in self.routines for node in routine.nodes)
        return any(isinstance(node, Call) and node.function == intrinsic for node in nodes)

    def changes(self, routine: Routine, array: str) -> bool:
        """Return whether a routine, or a routine that it calls, writes to an array."""
        nodes = list(routine.nodes)
        targets = (node.target for node in nodes if isinstance(node, Assign))
        if any(isinstance(target, Element) and target.array.name == array for target in targets):
            return True
        called = {node.function for node in nodes if isinstance(node, Call)}
        return any(self.changes(routine, array) for routine in self.routines if routine.name in called)


def walk(*nodes: Node) -> Iterator[Node]:
    """Yield nodes with every node inside them, each before its parts."""
    for node in nodes:
        yield node
        for value in vars(node).values():
            parts = value if isinstance(value, tuple) else (value,)
            yield from walk(*(part for part in parts if isinstance(part, Node)))
