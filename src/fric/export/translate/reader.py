"""Reads a compiled step from its definition: Python, with the types that it was compiled for."""

import ast
import builtins
import inspect
import math
import operator as op
import textwrap
from dataclasses import dataclass, field, replace
from functools import cache, reduce
from types import FunctionType
from typing import Any, get_type_hints

import numpy as np
from numba import types
from numba.core.dispatcher import Dispatcher

from fric.errors import FricError
from fric.export.translate import program as ir
from fric.kernels import elementary
from fric.kernels.inner import step_at

_OPERATORS: dict[type[ast.AST], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
    ast.And: "and", ast.Or: "or",
}  # fmt: skip
_FOLDED: dict[str, Any] = {"+": op.add, "-": op.sub, "*": op.mul, "/": op.truediv, "//": op.floordiv, "%": op.mod}
_INTRINSICS: dict[object, str] = {
    math.exp: "exp", math.copysign: "copysign", math.log1p: "log1p", builtins.abs: "abs", builtins.min: "min",
    builtins.max: "max", math.fabs: "abs", np.abs: "abs", np.exp: "exp",
    elementary.exp: "exp", elementary.log1p: "log1p", elementary.power: "pow",
}  # fmt: skip

MOST_PASSES = 64  # Largest number of passes of an unrolled loop
INTERFACE = ("init", "reset", "step")  # Names of the exported part itself


class Body:
    """Reads the body of one function; statements that must precede an expression wait in ``before``."""

    def __init__(self, reader: "_Reader", python: Any, variables: dict[str, ir.Type]) -> None:
        self.reader, self.python, self.variables = reader, python, variables
        self.fixed: dict[str, ir.Constant] = {}  # whole numbers that are known: sizes of arrays, and what follows
        self.before: list[ir.Statement] = []  # what must be done before the expression that is being read
        self.temporaries = 0
        self.steps: dict[str, Any] = {}  # names that denote a step whose address is in the parameters

    def refuse(self, what: str, node: ast.AST) -> FricError:
        """Return the error of a step that cannot be exported, with the responsible line."""
        line = self.python.__code__.co_firstlineno + getattr(node, "lineno", 1) - 1
        where = f"{self.python.__module__}.{self.python.__name__}, line {line}"
        return FricError(f"cannot be exported: {what} ({where})")

    def flush(self) -> list[ir.Statement]:
        """Return and clear the statements that must precede the expression."""
        before, self.before = self.before, []
        return before

    def temporary(self, of: ir.Type) -> ir.Name:
        """Return a new variable."""
        self.temporaries += 1
        return ir.Name(f"kept_{self.temporaries}", of)

    def kept(self, value: ir.Expression) -> ir.Name:
        """Return a new variable that holds a value, to be set before the present statement."""
        name = self.temporary(value.type)
        self.before.append(ir.Assign(name, value))
        return name

    def made(self, record: ir.Record, values: list[ast.expr]) -> ir.Name:
        """Return a new variable that holds a record of values."""
        name = self.temporary(record)
        self.before += self.filled(name, values)
        return name

    def filled(self, place: Any, values: list[ast.expr]) -> list[ir.Statement]:
        """Return the statements that fill the fields of a record."""
        if len(fields := place.type.fields) != len(values):
            raise self.refuse(f"{place.type.name} is not given all its fields", values[0])
        kept = [self.as_type(self.expression(value), of) for value, (_, of) in zip(values, fields, strict=True)]
        return [ir.Assign(ir.Field(place, name, of), value) for value, (name, of) in zip(kept, fields, strict=True)]

    def part(self, node: ast.expr) -> ir.Array | None:
        """Return an array, or a part of it between known limits; None for anything else."""
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
        """Return the object of a name or a dotted name outside the function; None for a variable."""
        if isinstance(node, ast.Name) and node.id in self.steps:
            return self.steps[node.id]
        if isinstance(node, ast.Name) and node.id not in self.variables:
            return self.python.__globals__.get(node.id, getattr(builtins, node.id, None))
        if isinstance(node, ast.Attribute):
            return None if (holder := self.known(node.value)) is None else getattr(holder, node.attr, None)
        return None

    def as_type(self, value: ir.Expression, of: ir.Type) -> ir.Expression:
        """Return a whole number as a real number where requested."""
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
                if not isinstance(known := self.known(node), (int, float)):
                    raise self.refuse(f"'{ast.unparse(node)}' has no counterpart", node)
                return self.number(known, node) if isinstance(known, float) else ir.Constant(known, ir.INTEGER)
            case ast.Subscript(value=ast.Name(id=name), slice=index) if isinstance(self.variables.get(name), ir.Array):
                return self.element(self.variables[name], self.expression(index))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                if isinstance(read := self.expression(operand), ir.Constant):
                    return ir.Constant(-read.value, read.type)
                assert isinstance(read.type, ir.Scalar)
                return ir.Operation("negate", (read,), read.type)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return ir.Operation("not", (self.expression(operand),), ir.BOOLEAN)
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                both = (self.as_type(self.expression(left), ir.REAL), self.as_type(self.expression(right), ir.REAL))
                return ir.Call("pow", both, ir.REAL)
            case ast.BinOp(left=left, op=op, right=right):
                return self.arithmetic(_OPERATORS[type(op)], self.expression(left), self.expression(right))
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                first, second = self.alike(self.expression(left), self.expression(right))
                return ir.Operation(_OPERATORS[type(op)], (first, second), ir.BOOLEAN)
            case ast.BoolOp(op=op, values=values):
                operator = _OPERATORS[type(op)]
                return reduce(lambda a, b: ir.Operation(operator, (a, b), ir.BOOLEAN), map(self.expression, values))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                condition, waiting = self.expression(test), len(self.before)
                first, second = self.alike(self.expression(body), self.expression(orelse))
                if len(self.before) > waiting:
                    raise self.refuse("a choice between two values does something besides", node)
                assert isinstance(first.type, ir.Scalar)
                return ir.Operation("select", (condition, first, second), first.type)
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

    def alike(self, first: ir.Expression, second: ir.Expression) -> tuple[ir.Expression, ir.Expression]:
        """Return two values of the same type: both real where either is."""
        if ir.REAL in (first.type, second.type):
            return self.as_type(first, ir.REAL), self.as_type(second, ir.REAL)
        return first, second

    def arithmetic(self, operator: str, first: ir.Expression, second: ir.Expression) -> ir.Expression:
        """Return an operation on two numbers, evaluated if both are known."""
        first, second = self.alike(first, second)
        if operator == "/":
            first, second = self.as_type(first, ir.REAL), self.as_type(second, ir.REAL)
        if isinstance(first, ir.Constant) and isinstance(second, ir.Constant):
            return ir.Constant(_FOLDED[operator](first.value, second.value), first.type)
        assert isinstance(first.type, ir.Scalar)
        return ir.Operation(operator, (first, second), first.type)

    def call(self, node: ast.Call, function: Any, arguments: list[ast.expr]) -> ir.Expression:
        """Return a call: of a routine, of a function that languages have, or of a record."""
        name = _INTRINSICS.get(function) if getattr(function, "__hash__", None) else None
        if name is None and isinstance(function, Dispatcher):
            signature = function.nopython_signatures[0]
            views = tuple(self.part(argument) for argument in arguments)
            given = [
                self.as_type(self.expression(argument), self.reader.type(of))
                for argument, of, view in zip(arguments, signature.args, views, strict=True) if view is None
            ]  # fmt: skip
            routine = self.reader.routine(function, views)
            given += [argument for argument in routine.arguments if isinstance(argument.type, ir.Array)]
            return ir.Call(routine.name, tuple(given), self.reader.type(signature.return_type))
        if is_group(function):
            return self.made(self.reader.group(function), arguments)
        if name is None:
            raise self.refuse(f"its step calls {ast.unparse(node.func)}, which controllers do not have", node)
        read = [self.as_type(self.expression(argument), ir.REAL) for argument in arguments]
        if name not in {"min", "max"}:
            return ir.Call(name, tuple(read), ir.REAL)
        return reduce(lambda made, other: ir.Call(name, (made, other), ir.REAL), read)

    def whole(self, body: list[ast.stmt], result: Any) -> tuple[tuple[ir.Statement, ...], ir.Expression | None]:
        """Return the statements of a function with a single exit, and its return value."""
        if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:]  # the docstring
        if result is None:
            return tuple(self.block(body)), None
        self.result = ir.Name("result", result)
        last = body[-1]
        if isinstance(last, ast.Return) and not any(_returns(statement) for statement in body[:-1]):
            statements = self.block(body[:-1])
            value = self.returned(last.value, result)
            return (*statements, *self.flush()), value
        self.variables["result"] = result
        return tuple(self.block(body)), self.result

    def returned(self, value: Any, of: Any) -> ir.Expression:
        """Return what a function returns, of its type."""
        return self.made(of, value.elts) if isinstance(value, ast.Tuple) else self.as_type(self.expression(value), of)

    def block(self, body: list[ast.stmt]) -> list[ir.Statement]:
        """Return the statements of a block; statements after a returning branch move to its other arm."""
        statements: list[ir.Statement] = []
        for n, node in enumerate(body):
            if isinstance(node, ast.If) and _returns(node):
                rest = body[n + 1 :]
                then = self.expression(node.test)
                statements += self.flush()
                known = dict(self.variables)
                first = self.block(node.body if _ends(node.body) else [*node.body, *rest])
                after, self.variables = self.variables, known | {"result": self.result.type}
                second = self.block([*node.orelse, *([] if node.orelse and _ends(node.orelse) else rest)])
                self.variables = after | self.variables
                return [*statements, ir.Branch(then, tuple(first), tuple(second))]
            statements += self.statement(node)
            if isinstance(node, ast.Return):
                break
        return statements

    def statement(self, node: ast.stmt) -> list[ir.Statement]:
        """Return a statement, preceded by the statements that its expressions need."""
        match node:
            case ast.Assign(targets=[target], value=value) | ast.AnnAssign(target=target, value=ast.expr() as value):
                made = self.assign(target, value)
            case ast.AugAssign(target=target, op=op, value=value):
                load = ast.parse(ast.unparse(target), mode="eval").body
                made = self.assign(target, ast.copy_location(ast.BinOp(left=load, op=op, right=value), node))
            case ast.Return(value=ast.expr() as value):
                made = [ir.Assign(self.result, self.returned(value, self.result.type))]
            case ast.If(test=test, body=body, orelse=orelse):
                condition = self.expression(test)
                made = [*self.flush(), ir.Branch(condition, tuple(self.block(body)), tuple(self.block(orelse)))]
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=[stop]), body=body):
                until = self.expression(stop)
                self.variables[name] = ir.INTEGER
                made = [ir.Count(ir.Name(name, ir.INTEGER), until, tuple(self.block(body)))]
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=limits), body=body):
                made = self.unrolled(name, [self.expression(limit) for limit in limits], body, node)
            case ast.Expr(value=ast.Call() as value):
                call = self.expression(value)
                assert isinstance(call, ir.Call)
                made = [ir.Evaluate(call)]
            case ast.Pass():
                made = []
            case ast.While() | ast.For():
                raise self.refuse("how often a loop of its step turns depends on the data", node)
            case _:
                raise self.refuse(f"'{ast.unparse(node).splitlines()[0]}' has no counterpart", node)
        return [*self.flush(), *made]

    def unrolled(
        self, name: str, limits: list[ir.Expression], body: list[ast.stmt], node: ast.stmt
    ) -> list[ir.Statement]:
        """Return an unrolled loop between known limits, for loops that do not count up from 0."""
        known = [int(limit.value) for limit in limits if isinstance(limit, ir.Constant)]
        if len(known) < len(limits) or len(indices := range(*known)) > MOST_PASSES:
            raise self.refuse("how often a loop of its step turns depends on the data", node)
        made: list[ir.Statement] = []
        for index in indices:
            self.fixed[name] = ir.Constant(index, ir.INTEGER)
            made += self.block(body)
        self.fixed.pop(name, None)
        return made

    def assign(self, target: ast.expr, value: ast.expr) -> list[ir.Statement]:
        """Return the assignments of a value to a variable, an element, or several of these."""
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            return self.several(target, value)
        if isinstance(target, ast.Tuple):  # the parts of what a function returns
            whole = self.kept(self.expression(value))
            assert isinstance(whole.type, ir.Record)
            statements = self.flush()
            for node, (name, of) in zip(target.elts, whole.type.fields, strict=True):
                if not (isinstance(node, ast.Name) and node.id == "_"):
                    statements.append(ir.Assign(self.place(node, of), ir.Field(whole, name, of)))
            return statements
        if isinstance(value, ast.Call) and is_group(group := self.known(value.func)):
            filled = self.filled(self.place(target, self.reader.group(group)), value.args)
            return [*self.flush(), *filled]
        if isinstance(target, ast.Name) and isinstance(value, ast.Call) and self.known(value.func) is step_at:
            if self.reader.inner is None:
                raise self.refuse("its step calls another, which is not known", value)
            self.steps[target.id] = self.reader.inner
            return []
        if isinstance(target, ast.Name) and (part := self.part(value)) is not None:
            self.variables[target.id] = part
            return []
        read_value = self.expression(value)
        if isinstance(target, ast.Name) and isinstance(read_value, ir.Constant) and read_value.type == ir.INTEGER:
            if self.fixed.setdefault(target.id, read_value) != read_value:
                raise self.refuse(f"the whole number {target.id} changes", target)
            return []
        place = self.place(target, read_value.type)
        return [*self.flush(), ir.Assign(place, self.as_type(read_value, place.type))]

    def several(self, targets: ast.Tuple, values: ast.Tuple) -> list[ir.Statement]:
        """Assign several values at once, with a temporary if a later value contains an earlier target."""
        written: set[str] = set()
        aside = False
        for target, value in zip(targets.elts, values.elts, strict=True):
            aside = aside or bool({node.id for node in ast.walk(value) if isinstance(node, ast.Name)} & written)
            written |= {node.id for node in ast.walk(target) if isinstance(node, ast.Name)}
        if not aside:
            pairs = zip(targets.elts, values.elts, strict=True)
            return [made for target, value in pairs for made in self.assign(target, value)]
        kept = [self.kept(self.expression(value)) for value in values.elts]
        before = self.flush()
        places = (self.place(target, node.type) for target, node in zip(targets.elts, kept, strict=True))
        return [*before, *map(ir.Assign, places, kept)]

    def place(self, target: ast.expr, of: ir.Type) -> ir.Name | ir.Element:
        """Return the target of an assignment: a variable, declared with its type, or an element of an array."""
        if isinstance(target, ast.Name):
            known = self.variables.setdefault(target.id, of)
            if known != of and not (known == ir.REAL and of == ir.INTEGER):
                raise self.refuse(f"{target.id} changes its type", target)
            return ir.Name(target.id, known)
        if not isinstance(read := self.expression(target), ir.Element):
            raise self.refuse(f"'{ast.unparse(target)}' is not a place to write to", target)
        return read


def is_group(function: object) -> bool:
    """Return whether something is a class of named tuples."""
    return isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields")


def _returns(node: ast.stmt) -> bool:
    return any(isinstance(node, ast.Return) for node in ast.walk(node))


def _ends(body: list[ast.stmt]) -> bool:
    """Return whether every way through a block ends in a return."""
    if isinstance(last := body[-1], ast.If):
        return bool(last.orelse) and _ends(last.body) and _ends(last.orelse)
    return isinstance(last, ast.Return)


@dataclass(frozen=True)
class Entry:
    """A compiled step to read."""

    name: str  # Its name in the program
    step: Any  # The step as `fric.kernels.signatures` compiles it
    states: int  # states, parameters: sizes of its two arrays
    parameters: int
    inner: Any = None  # The step whose address the parameters hold, where this one calls another


def read_program(*entries: Entry) -> ir.Program:
    """Return compiled steps, and all functions that they call, as a program.

    Raises FricError: When a step does what a controller's program cannot or must not do: a loop whose length depends on
    the data, a function that controllers do not have, access to later commands to the axis.
    """
    reader = _Reader(names={*INTERFACE, *(entry.name for entry in entries)})
    routines: list[ir.Routine] = []
    for entry in entries:
        if not isinstance(entry.step, Dispatcher):
            raise FricError("the step is not compiled", hint="Unset NUMBA_DISABLE_JIT.")
        sizes = {"state": entry.states, "parameters": entry.parameters}
        names = inspect.signature(entry.step.py_func).parameters
        given = tuple(ir.Array.of(name, sizes[name]) if name in sizes else None for name in names)
        reader.inner = entry.inner
        whole = reader.routine(entry.step, given)
        routines += [made for made in reader.routines.values() if made is not whole and made not in routines]
        routines.append(replace(whole, name=entry.name))
        del reader.routines[entry.step, given]
    return ir.Program(tuple(routines), tuple(reader.records.values()))


@cache
def _definition(function: FunctionType) -> ast.FunctionDef:
    (found,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(found, ast.FunctionDef)
    return found


@dataclass
class _Reader:
    routines: dict[tuple[Any, tuple[ir.Array | None, ...]], ir.Routine] = field(default_factory=dict)
    records: dict[Any, ir.Record] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)
    inner: Any = None

    def routine(self, function: Any, given: tuple[ir.Array | None, ...]) -> ir.Routine:
        """Return a function as a routine on the given arrays, or parts of them, in place of its parameters."""
        key = function, given
        if key not in self.routines:
            python = function.py_func
            definition = _definition(python)
            signature = function.nopython_signatures[0]
            known: dict[str, ir.Type] = {}
            for argument, compiled, array in zip(definition.args.args, signature.args, given, strict=True):
                known[argument.arg] = array or self.type(compiled)
            if any(isinstance(of, ir.Absent) for of in known.values()):  # with the table of a motion goes its counter
                known |= {name: ir.Absent(name) for name in ("n",) if name in known}
            arrays = {of.symbol: of.base for of in known.values() if isinstance(of, ir.Array)}
            arguments = [ir.Name(name, of) for name, of in known.items() if not isinstance(of, (ir.Array, ir.Absent))]
            arguments += [ir.Name(symbol, of) for symbol, of in arrays.items()]
            statements, result = Body(self, python, known).whole(definition.body, self.type(signature.return_type))
            note = (inspect.getdoc(python) or "").partition("\n")[0]
            name = self._unique(definition.name.strip("_"), python.__module__.rpartition(".")[2])
            self.routines[key] = ir.Routine(name, tuple(arguments), statements, result, note)
        return self.routines[key]

    def _unique(self, name: str, module: str) -> str:
        candidates = [name, f"{module}_{name}", *(f"{name}_{n}" for n in range(2, 100))]
        found = next(candidate for candidate in candidates if candidate not in self.names)
        self.names.add(found)
        return found

    def type(self, compiled: Any) -> Any:
        """Return a type as the compiler knows it; None for no result, `Absent` for what no controller has."""
        if isinstance(compiled, types.Float):
            return ir.REAL
        if isinstance(compiled, types.Boolean):
            return ir.BOOLEAN
        if isinstance(compiled, types.Integer):
            return ir.INTEGER
        if isinstance(compiled, types.NoneType):
            return None
        if isinstance(compiled, types.BaseNamedTuple):
            return self.group(compiled.instance_class)  # type: ignore[attr-defined]
        if isinstance(compiled, types.BaseTuple):
            members: list[Any] = list(compiled)  # type: ignore[call-overload]
            items = [(f"item_{i}", self.type(of)) for i, of in enumerate(members)]
            return self.record(tuple(map(str, members)), f"tuple_{len(items)}", items)
        return ir.Absent(str(compiled))

    def group(self, of: Any) -> ir.Record:
        """Return a named tuple's class as a record."""
        kinds = {float: ir.REAL, int: ir.INTEGER, bool: ir.BOOLEAN}
        hints = get_type_hints(of)
        return self.record(of, of.__name__.strip("_"), [(name, kinds[hints[name]]) for name in of._fields])

    def record(self, key: Any, name: str, members: list[tuple[str, ir.Scalar]]) -> ir.Record:
        """Return a record of the program, made where it is met first."""
        if key not in self.records:
            self.records[key] = ir.Record(self._unique(name, "record"), tuple(members))
        return self.records[key]
