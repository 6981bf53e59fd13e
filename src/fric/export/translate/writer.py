"""A routine of a program as the text of a language: the notation is a table, what a language declares is its own."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar

from fric.export.translate import program as ir


class Writer(ABC):
    """Writes one routine."""

    loop: ClassVar[tuple[str, str]]  # first line with counter and number of passes, and last line
    branch: ClassVar[tuple[str, str, str]]  # first line with the condition, line before the other arm, and last line
    discarded = ""  # before a call whose result is not used
    constant: ClassVar[Callable[[str], str]]  # of whole numbers and truth values

    def __init__(self, routine: ir.Routine, prefix: str, depth: int, operations: Mapping[str, str]) -> None:
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
    def assign(self, target: ir.Name | ir.Element | ir.Field, value: str) -> None:
        """Write an assignment."""

    def field(self, name: str) -> str:
        """Return a valid name of a record's field."""
        return name

    def outer(self, value: ir.Expression) -> str:
        """Return an expression that stands alone."""
        return self.expression(value)

    def inner(self, body: tuple[ir.Statement, ...], *counters: str) -> None:
        """Write the statements of a branch, or of a loop with its counter."""
        self.depth += 1
        for statement in body:
            self.statement(statement)
        self.depth -= 1

    def write(self, text: str) -> None:
        """Write a line."""
        self.lines.append("    " * self.depth + text)

    def statement(self, statement: ir.Statement) -> None:
        """Write a statement."""
        match statement:
            case ir.Assign(target, value):
                self.assign(target, self.outer(value))
            case ir.Evaluate(call):
                self.write(f"{self.discarded if call.type is not None else ''}{self.expression(call)};")
            case ir.Count(variable, stop, body):
                self.write(self.loop[0].format(self.name(variable.name), self.expression(stop)))
                self.inner(body, variable.name)
                self.write(self.loop[1])
            case ir.Branch(condition, then, otherwise):
                self.write(self.branch[0].format(self.outer(condition)))
                self.inner(then)
                if otherwise:
                    self.write(self.branch[1])
                    self.inner(otherwise)
                self.write(self.branch[2])

    def expression(self, value: ir.Expression) -> str:
        """Return the text of an expression, in parentheses if it is an operation."""
        match value:
            case ir.Constant(number, of):
                return self.number(float(number)) if of == ir.REAL else type(self).constant(str(number))
            case ir.Name(name):
                return self.name(name)
            case ir.Element(array, index):
                return f"{self.name(array.name)}[{self.outer(index)}]"
            case ir.Field(record, name):
                return f"{self.name(record.name)}.{self.field(name)}"
            case ir.Operation(operator, operands):
                text = self.operations.get(operator, f"({{}} {operator} {{}})")
                return text.format(*map(self.expression, operands))
            case ir.Call(function, arguments):
                return f"{self.function(function)}({', '.join(map(self.outer, arguments))})"
