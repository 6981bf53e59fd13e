"""A program in C99 that strict compilers and checkers of MISRA C:2012 accept without a message."""

from collections.abc import Iterable
from dataclasses import dataclass

from fric.export.translate import program as ir

_POWERS = (64, 32, 16, 8, 4, 2, 1)
HELPERS = {
    "min": """static inline {real} {prefix}min({real} a, {real} b)
{{
    return (a < b) ? a : b;
}}""",
    "max": """static inline {real} {prefix}max({real} a, {real} b)
{{
    return (a > b) ? a : b;
}}""",
    "copysign": """/* The size of a with the sign of b. */
static inline {real} {prefix}copysign({real} a, {real} b)
{{
    return (b < {zero}) ? (-{fabs}(a)) : {fabs}(a);
}}""",
    "log1p": """/* ln(1 + x) for x > -1: powers of two are taken out of 1 + x, the series of artanh gives the rest. */
static inline {real} {prefix}log1p({real} x)
{{
    static const {real} factors[7] = {{{factors}}};
    static const {real} powers[7] = {{{powers}}};
    {real} y = {one} + x;
    {real} twos = {zero};
    {real} sum = {zero};
    for (int32_t i = 0; i < 7; ++i) {{
        if (y >= factors[i]) {{
            y = y / factors[i];
            twos = twos + powers[i];
        }}
        if ((y * factors[i]) <= {one}) {{
            y = y * factors[i];
            twos = twos - powers[i];
        }}
    }}
    {real} rest = ({fabs}(twos) > {zero}) ? (y - {one}) : x;
    {real} s = rest / ({two} + rest);
    {real} order = {last};
    for (int32_t n = 0; n < 21; ++n) {{
        sum = ((sum * s) * s) + ({one} / order);
        order = order - {two};
    }}
    return (twos * {ln_2}) + (({two} * s) * sum);
}}""",
}


@dataclass(frozen=True)
class Dialect:
    """Notation of numbers in double or single precision, with a prefix for every name."""

    prefix: str  # What every name of the file begins with
    single: bool = False  # True for ``float``
    avoid: frozenset[str] = frozenset()  # Names with another meaning in the environment of the C code

    @property
    def real(self) -> str:
        """The type of real numbers."""
        return "float" if self.single else "double"

    def number(self, value: float) -> str:
        """Return a real constant, exact in the precision of the dialect."""
        if not self.single:
            return repr(float(value))
        import numpy as np

        text = str(np.float32(value))
        return f"{text if any(c in text for c in '.e') else text + '.0'}F"

    def function(self, name: str) -> str:
        """Return the name of a function of the C library in this precision."""
        return f"{name}f" if self.single else name


def helper(name: str, dialect: Dialect) -> str:
    """Return the definition of an intrinsic function that does not come from the C library."""
    number, fabs = dialect.number, dialect.function("fabs")
    return HELPERS[name].format(
        real=dialect.real, prefix=dialect.prefix, fabs=fabs, zero=number(0.0), one=number(1.0), two=number(2.0),
        ln_2=number(0.6931471805599453), factors=", ".join(number(2.0**n) for n in _POWERS),
        powers=", ".join(number(n) for n in _POWERS), last=number(41.0),
    )  # fmt: skip


_WORDS = """
auto break case char const continue default do double else enum extern float for goto if inline int long register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool true false
exp pow fabs
"""
_RESERVED = frozenset(_WORDS.split())


def c_routines(program: ir.Program, dialect: Dialect) -> str:
    """Return records, helpers and routines of a program, all static, each after its dependencies."""
    pieces = [_record(record, dialect) for record in program.records]
    pieces += [helper(name, dialect) for name in HELPERS if program.calls(name)]
    return "\n\n".join([*pieces, *(_CRoutine(program, routine, dialect).text() for routine in program.routines)])


def c_type(of: ir.Type | None, dialect: Dialect) -> str:
    """Return a type as C names it."""
    if of is None:
        return "void"
    if isinstance(of, ir.Record):
        return f"{dialect.prefix}{of.name.lower()}_t"
    return {ir.REAL: dialect.real, ir.INTEGER: "int32_t", ir.BOOLEAN: "bool"}[of]  # type: ignore[index]


def _record(record: ir.Record, dialect: Dialect) -> str:
    members = "\n".join(f"    {c_type(of, dialect)} {name};" for name, of in record.fields)
    return f"typedef struct {{\n{members}\n}} {c_type(record, dialect)};"


class _CRoutine:
    """Writes one routine: variables are declared where they are first set, at the latest where all their uses lie."""

    def __init__(self, program: ir.Program, routine: ir.Routine, dialect: Dialect) -> None:
        self.program, self.routine, self.dialect = program, routine, dialect
        self.declared = {argument.name for argument in routine.arguments}
        self.lines: list[str] = []
        self.depth = 1

    def text(self) -> str:
        routine, dialect = self.routine, self.dialect
        changed = _set(routine.body) & self.declared
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
        used = {node.name for node in ir.parts(routine.body, routine.result) if isinstance(node, ir.Name)}
        unused = [
            f"    (void){self.name(argument.name)};" for argument in routine.arguments if argument.name not in used
        ]
        self.block(routine.body, routine.result)
        head = [f"/* {routine.note} */"] if routine.note else []
        head += [f"static inline {result} {dialect.prefix}{routine.name}({', '.join(taken)})", "{", *copied, *unused]
        last = [] if routine.result is None else [f"    return {self.plain(self.expression(routine.result))};"]
        return "\n".join([*head, *self.lines, *last, "}"])

    def name(self, name: str) -> str:
        """Return a valid C name of a variable; checkers mistake a name ending in ``ull`` for a number."""
        taken = name in _RESERVED or name in self.dialect.avoid or name.endswith("ull")
        return f"{name}_" if taken else name

    def write(self, text: str) -> None:
        self.lines.append("    " * self.depth + text)

    def block(self, body: tuple[ir.Statement, ...], result: ir.Expression | None = None) -> None:
        """Write a block; first declare variables that it sets in several parts, or in a part and after it."""
        for name in self.late(body, result):
            self.declared.add(name.name)
            self.write(f"{c_type(name.type, self.dialect)} {self.name(name.name)};")
        for statement in body:
            self.statement(statement)

    def late(self, body: tuple[ir.Statement, ...], result: ir.Expression | None) -> list[ir.Name]:
        """Return the undeclared variables that two statements of a block share without a preceding plain assignment."""
        found: dict[str, list[int]] = {}
        names: dict[str, ir.Name] = {}
        counted: set[str] = set()
        for n, statement in enumerate(body):
            for node in ir.parts((statement,)):
                if isinstance(node, ir.Name) and node.name not in self.declared:
                    found.setdefault(node.name, []).append(n)
                    names[node.name] = node
            counted |= _counters((statement,))
        if result is not None:
            for node in ir.inside(result):
                if isinstance(node, ir.Name) and node.name not in self.declared:
                    found.setdefault(node.name, []).append(len(body))
                    names[node.name] = node
        late = []
        for name, places in found.items():
            first = body[places[0]] if places[0] < len(body) else None
            begins = isinstance(first, ir.Assign) and first.target == names[name]
            inner = len(set(places)) == 1 and isinstance(first, (ir.Branch, ir.Count))
            if not begins and not inner and name not in counted:
                late.append(names[name])
        return late

    def statement(self, statement: ir.Statement) -> None:
        match statement:
            case ir.Assign(ir.Name(name, of) as target, value) if name not in self.declared:
                self.declared.add(name)
                begun = f"{c_type(of, self.dialect)} {self.expression(target)}"
                self.write(f"{begun} = {self.plain(self.expression(value))};")
            case ir.Assign(target, value):
                self.write(f"{self.expression(target)} = {self.plain(self.expression(value))};")
            case ir.Evaluate(call):
                void = "(void)" if call.type is not None else ""
                self.write(f"{void}{self.expression(call)};")
            case ir.Count(variable, stop, body):
                i = self.name(variable.name)
                self.write(f"for (int32_t {i} = 0; {i} < {self.expression(stop)}; ++{i}) {{")
                self.inner(body, {variable.name})
                self.write("}")
            case ir.Branch(condition, then, otherwise):
                self.write(f"if ({self.plain(self.expression(condition))}) {{")
                self.inner(then, set())
                if otherwise:
                    self.write("} else {")
                    self.inner(otherwise, set())
                self.write("}")

    def inner(self, body: tuple[ir.Statement, ...], known: set[str]) -> None:
        outside, self.declared = self.declared, self.declared | known
        self.depth += 1
        self.block(body)
        self.depth -= 1
        self.declared = outside

    def plain(self, text: str) -> str:
        """Return an expression without the parentheses around the whole of it."""
        if not text.startswith("("):
            return text
        level = 0
        for n, character in enumerate(text):
            level += (character == "(") - (character == ")")
            if level == 0:
                return text[1:-1] if n == len(text) - 1 else text
        return text

    def expression(self, value: ir.Expression) -> str:
        dialect = self.dialect
        match value:
            case ir.Constant(number, of) if of == ir.REAL:
                text = dialect.number(float(number))
                return f"({text})" if number < 0 else text
            case ir.Constant(number, of):
                return str(number).lower()
            case ir.Name(name):
                return self.name(name)
            case ir.Element(array, index):
                return f"{self.name(array.name)}[{self.plain(self.expression(index))}]"
            case ir.Field(record, name):
                return f"{self.name(record.name)}.{name}"
            case ir.Operation("negate", (one,)):
                return f"(-{self.expression(one)})"
            case ir.Operation("not", (one,)):
                return f"(!{self.expression(one)})"
            case ir.Operation("to real", (one,)):
                return f"(({dialect.real})({self.expression(one)}))"
            case ir.Operation("select", (condition, first, second)):
                return f"({self.expression(condition)} ? {self.expression(first)} : {self.expression(second)})"
            case ir.Operation(operator, (first, second)):
                c = {"and": "&&", "or": "||", "//": "/"}.get(operator, operator)
                return f"({self.expression(first)} {c} {self.expression(second)})"
            case ir.Call(function, arguments):
                given = ", ".join(self.plain(self.expression(argument)) for argument in arguments)
                library = {"exp": "exp", "pow": "pow", "abs": "fabs"}.get(function)
                return f"{dialect.function(library) if library else dialect.prefix + function}({given})"
        raise AssertionError(value)


def _set(body: Iterable[ir.Statement]) -> set[str]:
    """Return the names that the statements set."""
    found: set[str] = set()
    for statement in body:
        match statement:
            case ir.Assign(ir.Name(name)) | ir.Assign(ir.Field(ir.Name(name))):
                found.add(name)
            case ir.Branch(_, then, otherwise):
                found |= _set(then) | _set(otherwise)
            case ir.Count(_, _, inner):
                found |= _set(inner)
    return found


def _counters(body: Iterable[ir.Statement]) -> set[str]:
    """Return the variables of the loops in some statements."""
    found: set[str] = set()
    for statement in body:
        match statement:
            case ir.Branch(_, then, otherwise):
                found |= _counters(then) | _counters(otherwise)
            case ir.Count(variable, _, inner):
                found |= {variable.name} | _counters(inner)
    return found
