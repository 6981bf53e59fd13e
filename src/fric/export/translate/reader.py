"""Reads a compiled step from its own definition: Python, with the types that it was compiled for."""

from __future__ import annotations

import ast
import builtins
import inspect
import math
import textwrap
from dataclasses import dataclass, field, replace
from typing import Any, get_type_hints

import numpy as np
from numba import types
from numba.core.dispatcher import Dispatcher

from fric.errors import FricError
from fric.export.translate.program import (
    BOOLEAN,
    INTEGER,
    REAL,
    Array,
    Assign,
    Branch,
    Call,
    Constant,
    Count,
    Element,
    Evaluate,
    Expression,
    Field,
    Name,
    Operation,
    Program,
    Record,
    Routine,
    Scalar,
    Statement,
    Type,
)

_OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.And: "and", ast.Or: "or",
}  # fmt: skip
_INTRINSICS: dict[object, str] = {
    math.exp: "exp", math.copysign: "copysign", math.log1p: "log1p", builtins.abs: "abs", builtins.min: "min",
    builtins.max: "max", math.fabs: "abs", np.abs: "abs", np.exp: "exp",
}  # fmt: skip


@dataclass(frozen=True)
class Entry:
    """A compiled step to read.

    Parameters
    ----------
    name
        What it is called in the program.
    step
        The step as `fric.kernels.signatures` compiles it.
    states, parameters
        Sizes of its two arrays.
    """

    name: str
    step: Any
    states: int
    parameters: int


def read_program(*entries: Entry) -> Program:
    """Return compiled steps, and all that they call, as one program.

    Raises
    ------
    FricError
        When a step does what a controller's program cannot, or must not: a loop whose length depends on the data, a
        function that controllers do not have, a look at what will be asked of the axis.
    """
    reader = _Reader(names={entry.name for entry in entries})
    routines: list[Routine] = []
    for entry in entries:
        if not isinstance(entry.step, Dispatcher):
            raise FricError("the step is not compiled", mend="Unset NUMBA_DISABLE_JIT.")
        sizes = {"state": entry.states, "parameters": entry.parameters}
        names = inspect.signature(entry.step.py_func).parameters
        given = tuple(Array.of(one, sizes[one]) if one in sizes else None for one in names)
        whole = reader.routine(entry.step, given)
        routines += [one for one in reader.routines.values() if one is not whole and one not in routines]
        routines.append(replace(whole, name=entry.name))
        del reader.routines[entry.step, given]
    return Program(tuple(routines), tuple(reader.records.values()))


@dataclass(frozen=True)
class Absent:
    """What a step takes in the library, and no controller has: the table of what will be asked of an axis."""

    what: str


@dataclass
class _Reader:
    routines: dict[tuple[Any, tuple[Array | None, ...]], Routine] = field(default_factory=dict)
    records: dict[Any, Record] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)

    def routine(self, function: Any, given: tuple[Array | None, ...]) -> Routine:
        """Return a function as a routine on the arrays, or parts of them, that it is given, in place of its own."""
        key = function, given
        if key not in self.routines:
            python = function.py_func
            (definition,) = ast.parse(textwrap.dedent(inspect.getsource(python))).body
            assert isinstance(definition, ast.FunctionDef)
            signature = function.nopython_signatures[0]
            known: dict[str, Type] = {}
            for argument, compiled, array in zip(definition.args.args, signature.args, given, strict=True):
                known[argument.arg] = array or self.type(compiled)
            arrays = {of.symbol: of.base for of in known.values() if isinstance(of, Array)}
            arguments = [Name(name, of) for name, of in known.items() if not isinstance(of, (Array, Absent))]
            arguments += [Name(symbol, of) for symbol, of in arrays.items()]
            body = _Body(self, python, known)
            statements, result = body.whole(definition.body, self.type(signature.return_type))
            note = (inspect.getdoc(python) or "").partition("\n")[0]
            name = self._unique(definition.name.strip("_"), python.__module__.rpartition(".")[2])
            self.routines[key] = Routine(name, tuple(arguments), statements, result, note)
        return self.routines[key]

    def _unique(self, name: str, module: str) -> str:
        candidates = [name, f"{module}_{name}", *(f"{name}_{n}" for n in range(2, 100))]
        found = next(one for one in candidates if one not in self.names)
        self.names.add(found)
        return found

    def type(self, compiled: Any) -> Any:
        """Return a type as the compiler knows it; None for no result, `Absent` for what no controller has."""
        if isinstance(compiled, types.Float):
            return REAL
        if isinstance(compiled, types.Boolean):
            return BOOLEAN
        if isinstance(compiled, types.Integer):
            return INTEGER
        if isinstance(compiled, types.NoneType):
            return None
        if isinstance(compiled, types.BaseNamedTuple):
            return self.group(compiled.instance_class)  # type: ignore[attr-defined]
        if isinstance(compiled, types.BaseTuple):
            members: list[Any] = list(compiled)  # type: ignore[call-overload]
            items = [(f"item_{i}", self.type(of)) for i, of in enumerate(members)]
            return self.record(tuple(map(str, members)), f"tuple_{len(items)}", items)
        return Absent(str(compiled))

    def group(self, of: Any) -> Record:
        """Return a named tuple's class as a record."""
        kinds = {float: REAL, int: INTEGER, bool: BOOLEAN}
        hints = get_type_hints(of)
        return self.record(of, of.__name__.strip("_"), [(name, kinds[hints[name]]) for name in of._fields])

    def record(self, key: Any, name: str, members: list[tuple[str, Scalar]]) -> Record:
        """Return a record of the program, made where it is met first."""
        if key not in self.records:
            self.records[key] = Record(self._unique(name, "record"), tuple(members))
        return self.records[key]


class _Body:
    """Reads the body of one function."""

    def __init__(self, reader: _Reader, python: Any, variables: dict[str, Type]) -> None:
        self.reader, self.python, self.variables = reader, python, variables
        self.fixed: dict[str, Constant] = {}  # whole numbers that are known: sizes of arrays, and what is made of them
        self.before: list[Statement] = []  # what must be done before the expression that is being read
        self.temporaries = 0

    def refuse(self, what: str, node: ast.AST) -> FricError:
        line = self.python.__code__.co_firstlineno + getattr(node, "lineno", 1) - 1
        where = f"{self.python.__module__}.{self.python.__name__}, line {line}"
        return FricError(f"cannot be exported: {what} ({where})")

    # --- statements

    def whole(self, body: list[ast.stmt], result: Any) -> tuple[tuple[Statement, ...], Expression | None]:
        """Return the statements of a function with one way out, and what it returns."""
        if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:]  # the docstring
        if result is None:
            return tuple(self.block(body)), None
        self.result = Name("result", result)
        last = body[-1]
        if isinstance(last, ast.Return) and not any(_returns(one) for one in body[:-1]):
            statements = self.block(body[:-1])
            assert last.value is not None
            value = self.expression(last.value) if not isinstance(last.value, ast.Tuple) else None
            if value is None:
                value = self.made(result, last.value)
            return (*statements, *self.flush()), value
        self.variables["result"] = result
        return tuple(self.block(body)), self.result

    def block(self, body: list[ast.stmt]) -> list[Statement]:
        statements: list[Statement] = []
        for n, node in enumerate(body):
            if isinstance(node, ast.If) and _returns(node):
                rest = body[n + 1 :]
                then = self.condition(node.test, statements)
                known = dict(self.variables)
                first = self.block(node.body if _ends(node.body) else [*node.body, *rest])
                after, self.variables = self.variables, known | {"result": self.result.type}
                second = self.block([*node.orelse, *([] if node.orelse and _ends(node.orelse) else rest)])
                self.variables = after | self.variables
                return [*statements, Branch(then, tuple(first), tuple(second))]
            statements += self.statement(node)
            if isinstance(node, ast.Return):
                break
        return statements

    def condition(self, node: ast.expr, statements: list[Statement]) -> Expression:
        read = self.expression(node)
        statements += self.flush()
        return read

    def flush(self) -> list[Statement]:
        before, self.before = self.before, []
        return before

    def statement(self, node: ast.stmt) -> list[Statement]:
        match node:
            case ast.Assign(targets=[target], value=value):
                made = self.assign(target, value)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                made = self.assign(target, value)
            case ast.AugAssign(target=target, op=op, value=value):
                both = ast.BinOp(left=_as_load(target), op=op, right=value)
                made = self.assign(target, ast.copy_location(both, node))
            case ast.Return(value=ast.expr() as value):
                if isinstance(value, ast.Tuple):
                    made = [Assign(self.result, self.made(self.result.type, value))]
                else:
                    made = [Assign(self.result, self.as_type(self.expression(value), self.result.type))]
            case ast.If(test=test, body=body, orelse=orelse):
                before: list[Statement] = []
                condition = self.condition(test, before)
                made = [*before, Branch(condition, tuple(self.block(body)), tuple(self.block(orelse)))]
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=[stop]), body=body):
                variable = Name(name, INTEGER)
                until = self.expression(stop)
                self.variables[name] = INTEGER
                made = [Count(variable, until, tuple(self.block(body)))]
            case ast.Expr(value=ast.Call() as value):
                call = self.expression(value)
                assert isinstance(call, Call)
                made = [Evaluate(call)]
            case ast.Pass():
                made = []
            case ast.While() | ast.For():
                raise self.refuse("how often a loop of its step turns depends on the data", node)
            case _:
                raise self.refuse(f"'{ast.unparse(node).splitlines()[0]}' has no counterpart", node)
        return [*self.flush(), *made]

    def assign(self, target: ast.expr, value: ast.expr) -> list[Statement]:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            return self.several(target, value)
        if isinstance(target, ast.Tuple):  # the parts of what a function returns
            whole = self.kept(self.expression(value))
            assert isinstance(whole.type, Record)
            statements = self.flush()
            for one, (name, of) in zip(target.elts, whole.type.fields, strict=True):
                if not (isinstance(one, ast.Name) and one.id == "_"):
                    statements.append(Assign(self.place(one, of), Field(whole, name, of)))
            return statements
        if isinstance(value, ast.Call) and _is_group(group := self.known(value.func)):
            filled = self.filled(self.place(target, self.reader.group(group)), value.args)
            return [*self.flush(), *filled]
        if isinstance(target, ast.Name) and (part := self.part(value)) is not None:
            self.variables[target.id] = part
            return []
        read_value = self.expression(value)
        if isinstance(target, ast.Name) and isinstance(read_value, Constant) and read_value.type == INTEGER:
            if self.fixed.setdefault(target.id, read_value) != read_value:
                raise self.refuse(f"the whole number {target.id} changes", target)
            return []
        place = self.place(target, read_value.type)
        return [*self.flush(), Assign(place, self.as_type(read_value, place.type))]

    def part(self, node: ast.expr) -> Array | None:
        """Return an array, or a part of one between limits that are known; None for anything else."""
        if isinstance(node, ast.Name) and isinstance(of := self.variables.get(node.id), Array):
            return of
        if not (isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.step is None):
            return None
        if not (isinstance(node.value, ast.Name) and isinstance(of := self.variables.get(node.value.id), Array)):
            return None
        limits = []
        for limit, default in ((node.slice.lower, 0), (node.slice.upper, of.size)):
            read = Constant(default, INTEGER) if limit is None else self.expression(limit)
            if not isinstance(read, Constant):
                raise self.refuse("which part of an array its step works on depends on the data", node)
            limits.append(int(read.value))
        return Array(of.symbol, limits[1] - limits[0], of.first + limits[0], of.whole)

    def several(self, targets: ast.Tuple, values: ast.Tuple) -> list[Statement]:
        """Assign several values at once: each is kept aside where an earlier target stands in a later value."""
        statements: list[Statement] = []
        written: set[str] = set()
        aside = False
        for target, value in zip(targets.elts, values.elts, strict=True):
            used = {one.id for one in ast.walk(value) if isinstance(one, ast.Name)}
            aside = aside or bool(used & written)
            written |= {one.id for one in ast.walk(target) if isinstance(one, ast.Name)}
        if not aside:
            for target, value in zip(targets.elts, values.elts, strict=True):
                statements += self.assign(target, value)
            return statements
        kept = []
        for value in values.elts:
            kept.append(self.kept(self.expression(value)))
            statements += self.flush()
        for target, one in zip(targets.elts, kept, strict=True):
            statements.append(Assign(self.place(target, one.type), one))
        return statements

    def place(self, target: ast.expr, of: Type) -> Name | Element:
        if isinstance(target, ast.Name):
            known = self.variables.setdefault(target.id, of)
            if known != of and not (known == REAL and of == INTEGER):
                raise self.refuse(f"{target.id} changes its type", target)
            return Name(target.id, known)
        read = self.expression(target)
        if not isinstance(read, Element):
            raise self.refuse(f"'{ast.unparse(target)}' is no place to write to", target)
        return read

    def kept(self, value: Expression) -> Name:
        """Return a new variable that holds a value, to be set before the present statement."""
        self.temporaries += 1
        name = Name(f"kept_{self.temporaries}", value.type)
        self.variables[name.name] = value.type
        self.before.append(Assign(name, value))
        return name

    def filled(self, place: Any, values: list[ast.expr]) -> list[Statement]:
        fields = place.type.fields
        if len(fields) != len(values):
            raise self.refuse(f"{place.type.name} is not given all its fields", values[0])
        kept = [self.as_type(self.expression(value), of) for value, (_, of) in zip(values, fields, strict=True)]
        return [Assign(Field(place, name, of), one) for one, (name, of) in zip(kept, fields, strict=True)]

    def made(self, record: Any, value: ast.expr) -> Name:
        """Return a new variable that holds a tuple."""
        self.temporaries += 1
        name = Name(f"kept_{self.temporaries}", record)
        assert isinstance(value, ast.Tuple)
        self.before += self.filled(name, value.elts)
        return name

    # --- expressions

    def known(self, node: ast.expr) -> Any:
        """Return what a name or a dotted name stands for outside the function; None for a variable."""
        if isinstance(node, ast.Name) and node.id not in self.variables:
            return self.python.__globals__.get(node.id, getattr(builtins, node.id, None))
        if isinstance(node, ast.Attribute):
            holder = self.known(node.value)
            return None if holder is None else getattr(holder, node.attr, None)
        return None

    def as_type(self, value: Expression, of: Type) -> Expression:
        if of == REAL and value.type == INTEGER:
            if isinstance(value, Constant):
                return Constant(float(value.value), REAL)
            return Operation("to real", (value,), REAL)
        return value

    def expression(self, node: ast.expr) -> Expression:
        match node:
            case ast.Constant(value=bool() as value):
                return Constant(value, BOOLEAN)
            case ast.Constant(value=int() as value):
                return Constant(value, INTEGER)
            case ast.Constant(value=float() as value):
                return self.number(value, node)
            case ast.Name(id=name) if name in self.fixed:
                return self.fixed[name]
            case (
                ast.Name(id=name) | ast.Attribute(value=ast.Name(id=name)) | ast.Subscript(value=ast.Name(id=name))
            ) if isinstance(self.variables.get(name), Absent):
                raise self.refuse(f"its step reads '{name}', which no controller has", node)
            case ast.Name(id=name) if name in self.variables:
                return Name(name, self.variables[name])
            case ast.Attribute(value=ast.Name(id=name), attr=attr) if name in self.variables:
                holder = Name(name, self.variables[name])
                if isinstance(holder.type, Array) and attr == "size":
                    return Constant(holder.type.size, INTEGER)
                if isinstance(holder.type, Record):
                    return Field(holder, attr, dict(holder.type.fields)[attr])
                raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)
            case ast.Name() | ast.Attribute():
                known = self.known(node)
                if not isinstance(known, (int, float)):
                    raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)
                return self.number(known, node) if isinstance(known, float) else Constant(known, INTEGER)
            case ast.Subscript(value=ast.Name(id=name), slice=index) if isinstance(self.variables.get(name), Array):
                return self.element(self.variables[name], self.expression(index))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.negated(self.expression(operand))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return Operation("not", (self.expression(operand),), BOOLEAN)
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                both = (self.as_type(self.expression(left), REAL), self.as_type(self.expression(right), REAL))
                return Call("pow", both, REAL)
            case ast.BinOp(left=left, op=op, right=right):
                return self.arithmetic(_OPERATORS[type(op)], self.expression(left), self.expression(right))
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                first, second = self.expression(left), self.expression(right)
                first, second = self.alike(first, second)
                return Operation(_OPERATORS[type(op)], (first, second), BOOLEAN)
            case ast.BoolOp(op=op, values=values):
                made = self.expression(values[0])
                for other in values[1:]:
                    made = Operation(_OPERATORS[type(op)], (made, self.expression(other)), BOOLEAN)
                return made
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self.select(node, self.expression(test), body, orelse)
            case ast.Call(func=func, args=arguments, keywords=[]):
                return self.call(node, self.known(func), arguments)
        raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)

    def element(self, array: Any, index: Expression) -> Element:
        if array.first:
            index = self.arithmetic("+", Constant(array.first, INTEGER), index)
        return Element(Name(array.symbol, array.base), index)

    def number(self, value: float, node: ast.expr) -> Constant:
        if not math.isfinite(value):
            raise self.refuse("its step uses an infinite number", node)
        return Constant(value, REAL)

    def negated(self, value: Expression) -> Expression:
        if isinstance(value, Constant):
            return Constant(-value.value, value.type)
        assert isinstance(value.type, Scalar)
        return Operation("negate", (value,), value.type)

    def alike(self, first: Expression, second: Expression) -> tuple[Expression, Expression]:
        if REAL in (first.type, second.type):
            return self.as_type(first, REAL), self.as_type(second, REAL)
        return first, second

    def arithmetic(self, operator: str, first: Expression, second: Expression) -> Expression:
        first, second = self.alike(first, second)
        if operator == "/":
            first, second = self.as_type(first, REAL), self.as_type(second, REAL)
        if isinstance(first, Constant) and isinstance(second, Constant):
            folded = {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b,
                      "/": lambda a, b: a / b, "//": lambda a, b: a // b, "%": lambda a, b: a % b}  # fmt: skip
            return Constant(folded[operator](first.value, second.value), first.type)
        assert isinstance(first.type, Scalar)
        return Operation(operator, (first, second), first.type)

    def select(self, node: ast.expr, condition: Expression, body: ast.expr, orelse: ast.expr) -> Expression:
        waiting = len(self.before)
        first, second = self.alike(self.expression(body), self.expression(orelse))
        if len(self.before) > waiting:
            raise self.refuse("a choice between two values does something besides", node)
        assert isinstance(first.type, Scalar)
        return Operation("select", (condition, first, second), first.type)

    def call(self, node: ast.Call, function: Any, arguments: list[ast.expr]) -> Expression:
        if isinstance(function, Dispatcher):
            signature = function.nopython_signatures[0]
            views = tuple(self.part(argument) for argument in arguments)
            given = [
                self.as_type(self.expression(argument), self.reader.type(of))
                for argument, of, view in zip(arguments, signature.args, views, strict=True)
                if view is None
            ]
            routine = self.reader.routine(function, views)
            given += [one for one in routine.arguments if isinstance(one.type, Array)]
            return Call(routine.name, tuple(given), self.reader.type(signature.return_type))
        if _is_group(function):
            self.temporaries += 1
            place = Name(f"kept_{self.temporaries}", self.reader.group(function))
            self.before += self.filled(place, arguments)
            return place
        name = _INTRINSICS.get(function) if getattr(function, "__hash__", None) else None
        if name is None:
            raise self.refuse(f"its step calls {ast.unparse(node.func)}, which controllers do not have", node)
        read = [self.as_type(self.expression(argument), REAL) for argument in arguments]
        made = read[0] if name in {"min", "max"} else Call(name, tuple(read), REAL)
        for other in read[1:] if name in {"min", "max"} else ():
            made = Call(name, (made, other), REAL)
        return made


def _is_group(function: object) -> bool:
    return isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields")


def _as_load(target: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(target), mode="eval").body


def _returns(node: ast.stmt) -> bool:
    return any(isinstance(one, ast.Return) for one in ast.walk(node))


def _ends(body: list[ast.stmt]) -> bool:
    """Return whether every way through a block ends in a return."""
    last = body[-1]
    if isinstance(last, ast.If):
        return bool(last.orelse) and _ends(last.body) and _ends(last.orelse)
    return isinstance(last, ast.Return)
