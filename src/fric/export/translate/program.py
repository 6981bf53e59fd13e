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


@dataclass(frozen=True)
class Constant:
    """A number, or a truth value."""

    value: float | int | bool
    type: Scalar


@dataclass(frozen=True)
class Name:
    """A variable."""

    name: str
    type: Type


@dataclass(frozen=True)
class Element:
    """An element of an array."""

    array: Name
    index: Expression
    type: Scalar = REAL


@dataclass(frozen=True)
class Field:
    """A field of a record."""

    record: Name
    field: str
    type: Scalar


@dataclass(frozen=True)
class Operation:
    """An operation on one, two or (``select``: condition, then, else) three values.

    ``+ - * /`` on numbers, ``//`` and ``%`` on integers, ``< <= > >= == !=``, ``and or not``, ``negate``, ``select``,
    ``to real``.
    """

    operator: str
    operands: tuple[Expression, ...]
    type: Scalar


@dataclass(frozen=True)
class Call:
    """A call of a routine of the program, or of a function available in every language."""

    function: str
    arguments: tuple[Expression, ...]
    type: Type


Expression = Constant | Name | Element | Field | Operation | Call


@dataclass(frozen=True)
class Assign:
    """``target = value``."""

    target: Name | Element | Field
    value: Expression


@dataclass(frozen=True)
class Branch:
    """``if condition: then; else: otherwise``."""

    condition: Expression
    then: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class Count:
    """``for variable in range(stop): body``."""

    variable: Name
    stop: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True)
class Evaluate:
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


@dataclass(frozen=True)
class Program:
    """Routines in an order in which each comes after those that it calls."""

    routines: tuple[Routine, ...]  # The routines
    records: tuple[Record, ...]  # The records that they use

    def calls(self, intrinsic: str) -> bool:
        """Return whether the program calls an intrinsic function."""
        return any(
            isinstance(part, Call) and part.function == intrinsic
            for routine in self.routines
            for part in parts(routine.body, routine.result)
        )

    def changes(self, routine: Routine, array: str) -> bool:
        """Return whether a routine, or a routine that it calls, writes to an array."""
        targets = [statement.target for statement in every(routine.body) if isinstance(statement, Assign)]
        if any(isinstance(target, Element) and target.array.name == array for target in targets):
            return True
        called = {part.function for part in parts(routine.body, routine.result) if isinstance(part, Call)}
        return any(self.changes(routine, array) for routine in self.routines if routine.name in called)


def every(body: tuple[Statement, ...]) -> Iterator[Statement]:
    """Yield every statement of a body, including those in branches and loops."""
    for statement in body:
        yield statement
        if isinstance(statement, Branch):
            yield from every(statement.then)
            yield from every(statement.otherwise)
        elif isinstance(statement, Count):
            yield from every(statement.body)


def inside(expression: Expression) -> Iterator[Expression]:
    """Yield an expression and every expression inside it."""
    yield expression
    match expression:
        case Element(array, index):
            yield array
            yield from inside(index)
        case Field(record):
            yield record
        case Operation(_, operands) | Call(_, operands):
            for operand in operands:
                yield from inside(operand)


def of_statement(statement: Statement) -> tuple[Expression, ...]:
    """Return the expressions of a statement itself, its target among them."""
    match statement:
        case Assign(target, value):
            return target, value
        case Branch(condition):
            return (condition,)
        case Count(variable, stop):
            return variable, stop
        case Evaluate(call):
            return (call,)


def parts(body: tuple[Statement, ...], result: Expression | None = None) -> Iterator[Expression]:
    """Yield every expression of a body and of its result."""
    for statement in every(body):
        for expression in of_statement(statement):
            yield from inside(expression)
    if result is not None:
        yield from inside(result)
