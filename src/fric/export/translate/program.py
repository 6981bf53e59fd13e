"""A compiled step as a program of a few kinds of statements that all languages of controllers have; and its writer.

Types are real, integer, boolean, records of these, and two arrays: the state and the parameters, with the same names in
every routine. Statements are assignments, branches, and loops of a fixed number of passes; there is no recursion and no
allocation. A routine that is called on several parts of an array is written for each part.
Each language has a table of its notation for routines, and declares variables by methods of its class.
"""

from __future__ import annotations

import tomllib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar


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


def reserved(language: str) -> frozenset[str]:
    """Return the words of a language, ``c`` or ``st``, that are no names."""
    return frozenset(tomllib.loads(Path(__file__).with_name("reserved.toml").read_text("utf-8"))[language].split())


class Writer(ABC):
    """Writes one routine."""

    loop: ClassVar[tuple[str, str]]  # first line with counter and number of passes, and last line
    branch: ClassVar[tuple[str, str, str]]  # first line with the condition, line before the other arm, and last line
    discarded = ""  # before a call whose result is not used
    constant: ClassVar[Callable[[str], str]]  # of whole numbers and truth values

    def __init__(self, routine: Routine, prefix: str, depth: int, operations: Mapping[str, str]) -> None:
        self.routine, self.prefix, self.depth, self.lines = routine, prefix, depth, list[str]()
        self.operations = operations  # texts of operators that are not ``({} OPERATOR {})``

    @abstractmethod
    def name(self, name: str) -> str:
        """Return a variable's valid name."""

    @abstractmethod
    def number(self, value: float) -> str:
        """Return a real constant."""

    @abstractmethod
    def function(self, name: str) -> str:
        """Return the name of a routine, or of a function that every language has."""

    @abstractmethod
    def assign(self, target: Name | Element | Field, value: str) -> None:
        """Write an assignment."""

    def field(self, name: str) -> str:
        """Return a valid name of a record's field."""
        return name

    def outer(self, value: Expression) -> str:
        """Return an expression that stands alone."""
        return self.expression(value)

    def inner(self, body: tuple[Statement, ...], *counters: str) -> None:
        """Write the statements of a branch, or of a loop with its counter."""
        self.depth += 1
        for statement in body:
            self.statement(statement)
        self.depth -= 1

    def write(self, text: str) -> None:
        """Write a line."""
        self.lines.append("    " * self.depth + text)

    def statement(self, statement: Statement) -> None:
        """Write a statement."""
        match statement:
            case Assign(target, value):
                self.assign(target, self.outer(value))
            case Evaluate(call):
                self.write(f"{self.discarded if call.type is not None else ''}{self.expression(call)};")
            case Count(variable, stop, body):
                self.write(self.loop[0].format(self.name(variable.name), self.expression(stop)))
                self.inner(body, variable.name)
                self.write(self.loop[1])
            case Branch(condition, then, otherwise):
                self.write(self.branch[0].format(self.outer(condition)))
                self.inner(then)
                if otherwise:
                    self.write(self.branch[1])
                    self.inner(otherwise)
                self.write(self.branch[2])

    def expression(self, value: Expression) -> str:
        """Return the text of an expression, in parentheses if it is an operation."""
        match value:
            case Constant(number, of):
                return self.number(float(number)) if of == REAL else type(self).constant(str(number))
            case Name(name):
                return self.name(name)
            case Element(array, index):
                return f"{self.name(array.name)}[{self.outer(index)}]"
            case Field(record, name):
                return f"{self.name(record.name)}.{self.field(name)}"
            case Operation(operator, operands):
                return self.operations.get(operator, f"({{}} {operator} {{}})").format(*map(self.expression, operands))
            case Call(function, arguments):
                return f"{self.function(function)}({', '.join(map(self.outer, arguments))})"
