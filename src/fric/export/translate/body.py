"""Reads the statements of a compiled step: one way out, and loops whose number of turns is known."""

import ast
from typing import Any

from fric.export.translate import program as ir
from fric.export.translate.expressions import Expressions, is_group
from fric.kernels.inner import step_at

MOST_PASSES = 64
"""Passes of a loop that is written out, at most."""


class Body(Expressions):
    """Reads the body of one function."""

    def whole(self, body: list[ast.stmt], result: Any) -> tuple[tuple[ir.Statement, ...], ir.Expression | None]:
        """Return the statements of a function with one way out, and what it returns."""
        if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:]  # the docstring
        if result is None:
            return tuple(self.block(body)), None
        self.result = ir.Name("result", result)
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

    def block(self, body: list[ast.stmt]) -> list[ir.Statement]:
        """Return the statements of a block; behind a branch that returns, what follows stands in its other arm."""
        statements: list[ir.Statement] = []
        for n, node in enumerate(body):
            if isinstance(node, ast.If) and _returns(node):
                rest = body[n + 1 :]
                then = self.condition(node.test, statements)
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

    def condition(self, node: ast.expr, statements: list[ir.Statement]) -> ir.Expression:
        """Return a condition, and write before it what it needs."""
        read = self.expression(node)
        statements += self.flush()
        return read

    def statement(self, node: ast.stmt) -> list[ir.Statement]:
        """Return a statement, and before it what its expressions need."""
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
                    made = [ir.Assign(self.result, self.made(self.result.type, value))]
                else:
                    made = [ir.Assign(self.result, self.as_type(self.expression(value), self.result.type))]
            case ast.If(test=test, body=body, orelse=orelse):
                before: list[ir.Statement] = []
                condition = self.condition(test, before)
                made = [*before, ir.Branch(condition, tuple(self.block(body)), tuple(self.block(orelse)))]
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=[stop]), body=body):
                variable = ir.Name(name, ir.INTEGER)
                until = self.expression(stop)
                self.variables[name] = ir.INTEGER
                made = [ir.Count(variable, until, tuple(self.block(body)))]
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
        """Return a loop between limits that are known, turn by turn, for loops that do not count up from 0."""
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
        """Return what assigns a value to a variable, an element, or several of them."""
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            return self.several(target, value)
        if isinstance(target, ast.Tuple):  # the parts of what a function returns
            whole = self.kept(self.expression(value))
            assert isinstance(whole.type, ir.Record)
            statements = self.flush()
            for one, (name, of) in zip(target.elts, whole.type.fields, strict=True):
                if not (isinstance(one, ast.Name) and one.id == "_"):
                    statements.append(ir.Assign(self.place(one, of), ir.Field(whole, name, of)))
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
        """Assign several values at once: each is kept aside where an earlier target stands in a later value."""
        statements: list[ir.Statement] = []
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
            statements.append(ir.Assign(self.place(target, one.type), one))
        return statements

    def place(self, target: ast.expr, of: ir.Type) -> ir.Name | ir.Element:
        """Return what is assigned to: a variable, made known with its type, or an element of an array."""
        if isinstance(target, ast.Name):
            known = self.variables.setdefault(target.id, of)
            if known != of and not (known == ir.REAL and of == ir.INTEGER):
                raise self.refuse(f"{target.id} changes its type", target)
            return ir.Name(target.id, known)
        read = self.expression(target)
        if not isinstance(read, ir.Element):
            raise self.refuse(f"'{ast.unparse(target)}' is no place to write to", target)
        return read

    def made(self, record: Any, value: ast.expr) -> ir.Name:
        """Return a new variable that holds a tuple."""
        self.temporaries += 1
        name = ir.Name(f"kept_{self.temporaries}", record)
        assert isinstance(value, ast.Tuple)
        self.before += self.filled(name, value.elts)
        return name


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
