"""Reads the expressions of a compiled step."""

import ast
import builtins
import math
from typing import Any, Protocol

import numpy as np
from numba.core.dispatcher import Dispatcher

from fric.errors import FricError
from fric.export.translate import program as ir
from fric.kernels import elementary

_OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.And: "and", ast.Or: "or",
}  # fmt: skip
_INTRINSICS: dict[object, str] = {
    math.exp: "exp", math.copysign: "copysign", math.log1p: "log1p", builtins.abs: "abs", builtins.min: "min",
    builtins.max: "max", math.fabs: "abs", np.abs: "abs", np.exp: "exp",
    elementary.exp: "exp", elementary.log1p: "log1p", elementary.power: "pow",
}  # fmt: skip


class Routines(Protocol):
    """What a body asks of the reader of the whole program: other routines, and types."""

    inner: Any
    """The step that stands behind an address in the parameters; None where there is none."""

    def routine(self, function: Any, given: tuple[ir.Array | None, ...]) -> ir.Routine:
        """Return a function that is called as a routine."""

    def type(self, compiled: Any) -> Any:
        """Return a type as the compiler knows it."""

    def group(self, of: Any) -> ir.Record:
        """Return a named tuple's class as a record."""


class Expressions:
    """Reads expressions of one function; what must be done before one of them waits in ``before``."""

    def __init__(self, reader: Routines, python: Any, variables: dict[str, ir.Type]) -> None:
        self.reader, self.python, self.variables = reader, python, variables
        self.fixed: dict[str, ir.Constant] = {}  # whole numbers that are known: sizes of arrays, and what follows
        self.before: list[ir.Statement] = []  # what must be done before the expression that is being read
        self.temporaries = 0
        self.steps: dict[str, Any] = {}  # names that stand for a step of which the parameters hold the address

    def refuse(self, what: str, node: ast.AST) -> FricError:
        """Return the error of a step that cannot be exported, with the line that is why."""
        line = self.python.__code__.co_firstlineno + getattr(node, "lineno", 1) - 1
        where = f"{self.python.__module__}.{self.python.__name__}, line {line}"
        return FricError(f"cannot be exported: {what} ({where})")

    def flush(self) -> list[ir.Statement]:
        """Return what must be done before the expression that was read, and forget it."""
        before, self.before = self.before, []
        return before

    def kept(self, value: ir.Expression) -> ir.Name:
        """Return a new variable that holds a value, to be set before the present statement."""
        self.temporaries += 1
        name = ir.Name(f"kept_{self.temporaries}", value.type)
        self.variables[name.name] = value.type
        self.before.append(ir.Assign(name, value))
        return name

    def filled(self, place: Any, values: list[ast.expr]) -> list[ir.Statement]:
        """Return what fills the fields of a record."""
        fields = place.type.fields
        if len(fields) != len(values):
            raise self.refuse(f"{place.type.name} is not given all its fields", values[0])
        kept = [self.as_type(self.expression(value), of) for value, (_, of) in zip(values, fields, strict=True)]
        return [ir.Assign(ir.Field(place, name, of), one) for one, (name, of) in zip(kept, fields, strict=True)]

    def part(self, node: ast.expr) -> ir.Array | None:
        """Return an array, or a part of one between limits that are known; None for anything else."""
        if isinstance(node, ast.Name) and isinstance(of := self.variables.get(node.id), ir.Array):
            return of
        if not (isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.step is None):
            return None
        if not (isinstance(node.value, ast.Name) and isinstance(of := self.variables.get(node.value.id), ir.Array)):
            return None
        limits = []
        for limit, default in ((node.slice.lower, 0), (node.slice.upper, of.size)):
            read = ir.Constant(default, ir.INTEGER) if limit is None else self.expression(limit)
            if not isinstance(read, ir.Constant):
                raise self.refuse("which part of an array its step works on depends on the data", node)
            limits.append(int(read.value))
        return ir.Array(of.symbol, limits[1] - limits[0], of.first + limits[0], of.whole)

    def known(self, node: ast.expr) -> Any:
        """Return what a name or a dotted name stands for outside the function; None for a variable."""
        if isinstance(node, ast.Name) and node.id in self.steps:
            return self.steps[node.id]
        if isinstance(node, ast.Name) and node.id not in self.variables:
            return self.python.__globals__.get(node.id, getattr(builtins, node.id, None))
        if isinstance(node, ast.Attribute):
            holder = self.known(node.value)
            return None if holder is None else getattr(holder, node.attr, None)
        return None

    def as_type(self, value: ir.Expression, of: ir.Type) -> ir.Expression:
        """Return a whole number as a real one where that is asked for."""
        if of == ir.REAL and value.type == ir.INTEGER:
            if isinstance(value, ir.Constant):
                return ir.Constant(float(value.value), ir.REAL)
            return ir.Operation("to real", (value,), ir.REAL)
        return value

    def expression(self, node: ast.expr) -> ir.Expression:  # noqa: C901 - a case for each kind of expression
        """Return an expression as the program has it."""
        match node:
            case ast.Constant(value=bool() as value):
                return ir.Constant(value, ir.BOOLEAN)
            case ast.Constant(value=int() as value):
                return ir.Constant(value, ir.INTEGER)
            case ast.Constant(value=float() as value):
                return self.number(value, node)
            case ast.Name(id=name) if name in self.fixed:
                return self.fixed[name]
            case (
                ast.Name(id=name) | ast.Attribute(value=ast.Name(id=name)) | ast.Subscript(value=ast.Name(id=name))
            ) if isinstance(self.variables.get(name), ir.Absent):
                raise self.refuse(f"its step reads '{name}', which no controller has", node)
            case ast.Name(id=name) if name in self.variables:
                return ir.Name(name, self.variables[name])
            case ast.Attribute(value=ast.Name(id=name), attr=attr) if name in self.variables:
                holder = ir.Name(name, self.variables[name])
                if isinstance(holder.type, ir.Array) and attr == "size":
                    return ir.Constant(holder.type.size, ir.INTEGER)
                if isinstance(holder.type, ir.Record):
                    return ir.Field(holder, attr, dict(holder.type.fields)[attr])
                raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)
            case ast.Name() | ast.Attribute():
                known = self.known(node)
                if not isinstance(known, (int, float)):
                    raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)
                return self.number(known, node) if isinstance(known, float) else ir.Constant(known, ir.INTEGER)
            case ast.Subscript(value=ast.Name(id=name), slice=index) if isinstance(self.variables.get(name), ir.Array):
                return self.element(self.variables[name], self.expression(index))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.negated(self.expression(operand))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return ir.Operation("not", (self.expression(operand),), ir.BOOLEAN)
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                both = (self.as_type(self.expression(left), ir.REAL), self.as_type(self.expression(right), ir.REAL))
                return ir.Call("pow", both, ir.REAL)
            case ast.BinOp(left=left, op=op, right=right):
                return self.arithmetic(_OPERATORS[type(op)], self.expression(left), self.expression(right))
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                first, second = self.expression(left), self.expression(right)
                first, second = self.alike(first, second)
                return ir.Operation(_OPERATORS[type(op)], (first, second), ir.BOOLEAN)
            case ast.BoolOp(op=op, values=values):
                made = self.expression(values[0])
                for other in values[1:]:
                    made = ir.Operation(_OPERATORS[type(op)], (made, self.expression(other)), ir.BOOLEAN)
                return made
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self.select(node, self.expression(test), body, orelse)
            case ast.Call(func=func, args=arguments, keywords=[]):
                return self.call(node, self.known(func), arguments)
        raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)

    def element(self, array: Any, index: ir.Expression) -> ir.Element:
        """Return an element of an array, or of the whole that it is a part of."""
        if array.first:
            index = self.arithmetic("+", ir.Constant(array.first, ir.INTEGER), index)
        return ir.Element(ir.Name(array.symbol, array.base), index)

    def number(self, value: float, node: ast.expr) -> ir.Constant:
        """Return a real constant."""
        if not math.isfinite(value):
            raise self.refuse("its step uses an infinite number", node)
        return ir.Constant(value, ir.REAL)

    def negated(self, value: ir.Expression) -> ir.Expression:
        """Return the negative of a value."""
        if isinstance(value, ir.Constant):
            return ir.Constant(-value.value, value.type)
        assert isinstance(value.type, ir.Scalar)
        return ir.Operation("negate", (value,), value.type)

    def alike(self, first: ir.Expression, second: ir.Expression) -> tuple[ir.Expression, ir.Expression]:
        """Return two values of one type: both real where one is."""
        if ir.REAL in (first.type, second.type):
            return self.as_type(first, ir.REAL), self.as_type(second, ir.REAL)
        return first, second

    def arithmetic(self, operator: str, first: ir.Expression, second: ir.Expression) -> ir.Expression:
        """Return an operation on two numbers, computed here where both are known."""
        first, second = self.alike(first, second)
        if operator == "/":
            first, second = self.as_type(first, ir.REAL), self.as_type(second, ir.REAL)
        if isinstance(first, ir.Constant) and isinstance(second, ir.Constant):
            folded = {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b,
                      "/": lambda a, b: a / b, "//": lambda a, b: a // b, "%": lambda a, b: a % b}  # fmt: skip
            return ir.Constant(folded[operator](first.value, second.value), first.type)
        assert isinstance(first.type, ir.Scalar)
        return ir.Operation(operator, (first, second), first.type)

    def select(self, node: ast.expr, condition: ir.Expression, body: ast.expr, orelse: ast.expr) -> ir.Expression:
        """Return a choice between two values."""
        waiting = len(self.before)
        first, second = self.alike(self.expression(body), self.expression(orelse))
        if len(self.before) > waiting:
            raise self.refuse("a choice between two values does something besides", node)
        assert isinstance(first.type, ir.Scalar)
        return ir.Operation("select", (condition, first, second), first.type)

    def call(self, node: ast.Call, function: Any, arguments: list[ast.expr]) -> ir.Expression:
        """Return a call: of a routine, of a function that languages have, or of a record."""
        name = _INTRINSICS.get(function) if getattr(function, "__hash__", None) else None
        if name is None and isinstance(function, Dispatcher):
            signature = function.nopython_signatures[0]
            views = tuple(self.part(argument) for argument in arguments)
            given = [
                self.as_type(self.expression(argument), self.reader.type(of))
                for argument, of, view in zip(arguments, signature.args, views, strict=True)
                if view is None
            ]
            routine = self.reader.routine(function, views)
            given += [one for one in routine.arguments if isinstance(one.type, ir.Array)]
            return ir.Call(routine.name, tuple(given), self.reader.type(signature.return_type))
        if is_group(function):
            self.temporaries += 1
            place = ir.Name(f"kept_{self.temporaries}", self.reader.group(function))
            self.before += self.filled(place, arguments)
            return place
        if name is None:
            raise self.refuse(f"its step calls {ast.unparse(node.func)}, which controllers do not have", node)
        read = [self.as_type(self.expression(argument), ir.REAL) for argument in arguments]
        made = read[0] if name in {"min", "max"} else ir.Call(name, tuple(read), ir.REAL)
        for other in read[1:] if name in {"min", "max"} else ():
            made = ir.Call(name, (made, other), ir.REAL)
        return made


def is_group(function: object) -> bool:
    """Return whether something is a class of named tuples."""
    return isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields")
