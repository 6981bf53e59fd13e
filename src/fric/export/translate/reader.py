"""Reads a compiled step from its own definition: Python, with the types that it was compiled for."""

import ast
import inspect
import textwrap
from dataclasses import dataclass, field, replace
from functools import cache
from types import FunctionType
from typing import Any, get_type_hints

from numba import types
from numba.core.dispatcher import Dispatcher

from fric.errors import FricError
from fric.export.translate import program as ir
from fric.export.translate.body import Body

INTERFACE = ("init", "reset", "step")
"""Names that the exported part itself has."""


@dataclass(frozen=True)
class Entry:
    """A compiled step to read."""

    name: str  # What it is called in the program
    step: Any  # The step as `fric.kernels.signatures` compiles it
    # states, parameters: sizes of its two arrays
    states: int
    parameters: int
    inner: Any = None  # The step whose address the parameters hold, where this one calls another


def read_program(*entries: Entry) -> ir.Program:
    """Return compiled steps, and all that they call, as one program.

    Raises FricError: When a step does what a controller's program cannot, or must not: a loop whose length depends on
        the data, a function that controllers do not have, a look at what will be asked of the axis.
    """
    reader = _Reader(names={*INTERFACE, *(entry.name for entry in entries)})
    routines: list[ir.Routine] = []
    for entry in entries:
        if not isinstance(entry.step, Dispatcher):
            raise FricError("the step is not compiled", hint="Unset NUMBA_DISABLE_JIT.")
        sizes = {"state": entry.states, "parameters": entry.parameters}
        names = inspect.signature(entry.step.py_func).parameters
        given = tuple(ir.Array.of(one, sizes[one]) if one in sizes else None for one in names)
        reader.inner = entry.inner
        whole = reader.routine(entry.step, given)
        routines += [one for one in reader.routines.values() if one is not whole and one not in routines]
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
        """Return a function as a routine on the arrays, or parts of them, that it is given, in place of its own."""
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
            body = Body(self, python, known)
            statements, result = body.whole(definition.body, self.type(signature.return_type))
            note = (inspect.getdoc(python) or "").partition("\n")[0]
            name = self._unique(definition.name.strip("_"), python.__module__.rpartition(".")[2])
            self.routines[key] = ir.Routine(name, tuple(arguments), statements, result, note)
        return self.routines[key]

    def _unique(self, name: str, module: str) -> str:
        candidates = [name, f"{module}_{name}", *(f"{name}_{n}" for n in range(2, 100))]
        found = next(one for one in candidates if one not in self.names)
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
