"""A program in C99 that strict compilers and checkers of MISRA C:2012 accept without a message."""

from dataclasses import dataclass

import numpy as np

from fric.export.templates import render
from fric.export.translate import program as ir

_POWERS = (64, 32, 16, 8, 4, 2, 1)
INTRINSIC = ("min", "max", "copysign", "log1p")  # Functions that do not come from the C library
_RESERVED = ir.reserved("c")


@dataclass(frozen=True)
class Dialect:
    """Notation of numbers in double or single precision, with a prefix for every name."""

    prefix: str  # What every name of the file begins with
    single: bool = False  # True for ``float``

    @property
    def real(self) -> str:
        """The type of real numbers."""
        return "float" if self.single else "double"

    def number(self, value: float) -> str:
        """Return a real constant, exact in the precision of the dialect."""
        if not self.single:
            return repr(float(value))
        text = str(np.float32(value))
        return f"{text if any(c in text for c in '.e') else text + '.0'}F"

    def function(self, name: str) -> str:
        """Return the name of a function of the C library in this precision."""
        return f"{name}f" if self.single else name


def helpers(program: ir.Program, dialect: Dialect) -> str:
    """Return the definitions of intrinsic functions that a program calls and the C library lacks."""
    number, fabs = dialect.number, dialect.function("fabs")
    return render(
        "helpers.c.j2", called=[name for name in INTRINSIC if program.calls(name)], real=dialect.real,
        prefix=dialect.prefix, fabs=fabs, zero=number(0.0), one=number(1.0), two=number(2.0),
        ln_2=number(0.6931471805599453), factors=", ".join(number(2.0**n) for n in _POWERS),
        powers=", ".join(number(n) for n in _POWERS), last=number(41.0),
    ).rstrip()  # fmt: skip


def c_routines(program: ir.Program, dialect: Dialect) -> str:
    """Return records, helpers and routines of a program, all static, each after its dependencies."""
    pieces = []
    for record in program.records:
        members = "\n".join(f"    {c_type(of, dialect)} {name};" for name, of in record.fields)
        pieces.append(f"typedef struct {{\n{members}\n}} {c_type(record, dialect)};")
    pieces += filter(None, [helpers(program, dialect)])
    return "\n\n".join([*pieces, *(_CRoutine(program, routine, dialect).text() for routine in program.routines)])


def c_type(of: ir.Type | None, dialect: Dialect) -> str:
    """Return a type as C names it."""
    if of is None:
        return "void"
    if isinstance(of, ir.Record):
        return f"{dialect.prefix}{of.name.lower()}_t"
    return {ir.REAL: dialect.real, ir.INTEGER: "int32_t", ir.BOOLEAN: "bool"}[of]  # type: ignore[index]


class _CRoutine(ir.Writer):
    """Writes one routine: variables are declared where they are first set, at the latest where all their uses lie."""

    loop = ("for (int32_t {0} = 0; {0} < {1}; ++{0}) {{", "}")
    branch = ("if ({}) {{", "} else {", "}")
    discarded = "(void)"
    constant = str.lower

    def __init__(self, program: ir.Program, routine: ir.Routine, dialect: Dialect) -> None:
        operations = {
            "negate": "(-{})", "not": "(!{})", "to real": f"(({dialect.real})({{}}))", "select": "({} ? {} : {})",
            "and": "({} && {})", "or": "({} || {})", "//": "({} / {})",
        }  # fmt: skip
        super().__init__(routine, dialect.prefix, 1, operations)
        self.program, self.dialect = program, dialect
        self.declared = {argument.name for argument in routine.arguments}

    def text(self) -> str:
        routine, dialect = self.routine, self.dialect
        targets = (node.target for node in routine.nodes if isinstance(node, ir.Assign))
        places = (target.record if isinstance(target, ir.Field) else target for target in targets)
        changed = {place.name for place in places if isinstance(place, ir.Name)}
        taken, copied = [], []
        for argument in routine.arguments:
            name = self.name(argument.name)
            if isinstance(argument.type, ir.Array):
                const = "" if self.program.changes(routine, argument.name) else "const "
                taken.append(f"{const}{dialect.real} {name}[]")
            elif argument.name in changed:
                taken.append(f"{c_type(argument.type, dialect)} {name}_0")
                copied.append(f"    {c_type(argument.type, dialect)} {name} = {name}_0;")
            else:
                taken.append(f"{c_type(argument.type, dialect)} {name}")
        result = c_type(None if routine.result is None else routine.result.type, dialect)
        used = {node.name for node in routine.nodes if isinstance(node, ir.Name)}
        unused = [f"    (void){self.name(given.name)};" for given in routine.arguments if given.name not in used]
        self.block(routine.body, routine.result)
        head = [f"/* {routine.note} */"] if routine.note else []
        head += [f"static inline {result} {dialect.prefix}{routine.name}({', '.join(taken)})", "{", *copied, *unused]
        last = [] if routine.result is None else [f"    return {self.outer(routine.result)};"]
        return "\n".join([*head, *self.lines, *last, "}"])

    def name(self, name: str) -> str:
        """Return a valid C name of a variable; checkers mistake a name ending in ``ull`` for a number."""
        return f"{name}_" if name in _RESERVED or name.endswith("ull") else name

    def number(self, value: float) -> str:
        text = self.dialect.number(value)
        return f"({text})" if value < 0 else text

    def function(self, name: str) -> str:
        library = {"exp": "exp", "pow": "pow", "abs": "fabs"}.get(name)
        return self.dialect.function(library) if library else self.prefix + name

    def block(self, body: tuple[ir.Statement, ...], result: ir.Expression | None = None) -> None:
        """Write a block; first declare variables that it sets in several parts, or in a part and after it."""
        for name in self.late([*body, *([] if result is None else [result])]):
            self.declared.add(name.name)
            self.write(f"{c_type(name.type, self.dialect)} {self.name(name.name)};")
        for statement in body:
            self.statement(statement)

    def late(self, block: list[ir.Statement | ir.Expression]) -> list[ir.Name]:
        """Return the undeclared variables that two parts of a block share without a preceding plain assignment."""
        found: dict[str, list[ir.Node]] = {}
        names: dict[str, ir.Name] = {}
        for part in block:
            for node in ir.walk(part):
                if isinstance(node, ir.Name) and node.name not in self.declared:
                    found.setdefault(node.name, []).append(part)
                    names[node.name] = node
        counted = {node.variable.name for node in ir.walk(*block) if isinstance(node, ir.Count)}
        late = []
        for name, places in found.items():
            begins = isinstance(places[0], ir.Assign) and places[0].target == names[name]
            inner = isinstance(places[0], (ir.Branch, ir.Count)) and all(place is places[0] for place in places)
            if not begins and not inner and name not in counted:
                late.append(names[name])
        return late

    def assign(self, target: ir.Name | ir.Element | ir.Field, value: str) -> None:
        new = isinstance(target, ir.Name) and target.name not in self.declared
        if isinstance(target, ir.Name):
            self.declared.add(target.name)
        begun = f"{c_type(target.type, self.dialect)} " if new else ""
        self.write(f"{begun}{self.expression(target)} = {value};")

    def inner(self, body: tuple[ir.Statement, ...], *counters: str) -> None:
        outside, self.declared = self.declared, self.declared | set(counters)
        self.depth += 1
        self.block(body)
        self.depth -= 1
        self.declared = outside

    def outer(self, value: ir.Expression) -> str:
        """Return an expression without the parentheses around the whole of it."""
        text = self.expression(value)
        level = 0
        for n, character in enumerate(text):
            level += (character == "(") - (character == ")")
            if level == 0:
                return text[1:-1] if n and n == len(text) - 1 and text[0] == "(" else text
        return text
