"""A program in structured text (IEC 61131-3): functions and structures, without vendor-specific parts."""

from fric.export.translate import program as ir

_WORDS = """
abs acos add and any array asin at atan bool by byte case concat configuration constant continue cos ct ctd ctu d
date delete dint div do ds dt dword else elsif en end eno eq exit exp expt f_edge f_trig false find for from
function ge gt if in insert int interval jmp l ld le left len limit lint ln log lreal lt lword max method mid min
mod move mul mux n namespace ne not of on or p priority program r r1 r_edge r_trig read real ref repeat replace
resource ret retain return right rol ror rs s s1 sd sel shl shr sin single sint sl sqrt sr st step string struct sub
super tan task then this time to tod tof ton tp transition true trunc type udint uint ulint until usint var while
with word write wstring xor result reference
"""
_RESERVED = frozenset(_WORDS.split())
_FUNCTIONS = {"exp": "EXP", "pow": "EXPT", "abs": "ABS", "min": "MIN", "max": "MAX"}
HELPERS = {
    "copysign": """(* The size of a with the sign of b. *)
FUNCTION {prefix}copysign : LREAL
VAR_INPUT
    a : LREAL;
    b : LREAL;
END_VAR
IF b < 0.0 THEN
    {prefix}copysign := -ABS(a);
ELSE
    {prefix}copysign := ABS(a);
END_IF;
END_FUNCTION""",
    "log1p": """(* ln(1 + x), exact for small x too: W. Kahan's form. *)
FUNCTION {prefix}log1p : LREAL
VAR_INPUT
    x : LREAL;
END_VAR
VAR
    y : LREAL;
END_VAR
y := 1.0 + x;
IF y = 1.0 THEN
    {prefix}log1p := x;
ELSE
    {prefix}log1p := (LN(y) * x) / (y - 1.0);
END_IF;
END_FUNCTION""",
}


def st_number(value: float) -> str:
    """Return a real constant as IEC 61131-3 writes it."""
    mantissa, exponent = repr(float(value)).partition("e")[::2]
    mantissa = mantissa if "." in mantissa else f"{mantissa}.0"
    text = f"{mantissa}E{int(exponent)}" if exponent else mantissa
    return f"({text})" if value < 0 else text


def st_type(of: ir.Type, prefix: str) -> str:
    """Return a type as structured text names it."""
    if isinstance(of, ir.Array):
        return f"ARRAY[0..{max(of.whole, 1) - 1}] OF LREAL"
    if isinstance(of, ir.Record):
        return f"{prefix}{of.name.lower()}"
    return {ir.REAL: "LREAL", ir.INTEGER: "DINT", ir.BOOLEAN: "BOOL"}[of]  # type: ignore[index]


def st_routines(program: ir.Program, prefix: str) -> str:
    """Return records, helpers and routines of a program, in an order in which each is declared before its use."""
    pieces = [_record(record, prefix) for record in program.records]
    pieces += [text.format(prefix=prefix) for name, text in HELPERS.items() if program.calls(name)]
    return "\n\n".join([*pieces, *(_StRoutine(routine, prefix).text() for routine in program.routines)])


def _record(record: ir.Record, prefix: str) -> str:
    members = "\n".join(f"    {_word(name)} : {st_type(of, prefix)};" for name, of in record.fields)
    return f"TYPE {st_type(record, prefix)} :\nSTRUCT\n{members}\nEND_STRUCT\nEND_TYPE"


def _word(name: str) -> str:
    """Return a name that is no word of the language."""
    return f"{name}_x" if name.lower() in _RESERVED else name


class _StRoutine:
    """Writes a routine. Names differ by more than their case, which the language ignores."""

    def __init__(self, routine: ir.Routine, prefix: str) -> None:
        self.routine, self.prefix, self.lines, self.depth = routine, prefix, list[str](), 0
        self.names: dict[str, str] = {}
        self.types: dict[str, ir.Type] = {}
        used = [*routine.arguments, *(p for p in ir.parts(routine.body, routine.result) if isinstance(p, ir.Name))]
        for node in used:
            if node.name not in self.names:
                name = _word(node.name)
                while name.lower() in {other.lower() for other in self.names.values()}:
                    name += "_x"
                self.names[node.name], self.types[node.name] = name, node.type
        self.chosen = 0

    def text(self) -> str:
        routine = self.routine
        for statement in routine.body:
            self.statement(statement)
        name = f"{self.prefix}{routine.name}"
        if routine.result is not None:
            self.write(f"{name} := {self.expression(routine.result)};")
        else:
            self.write(f"{name} := TRUE;")
        result = "BOOL" if routine.result is None else st_type(routine.result.type, self.prefix)
        given = [argument.name for argument in routine.arguments]
        arrays = [n for n in given if isinstance(self.types[n], ir.Array)]
        head = [f"(* {routine.note} *)"] if routine.note else []
        head.append(f"FUNCTION {name} : {result}")
        head += self.declared("VAR_INPUT", [n for n in given if n not in arrays])
        head += self.declared("VAR_IN_OUT", arrays)
        head += self.declared("VAR", [n for n in self.names if n not in given])
        return "\n".join([*head, *self.lines, "END_FUNCTION"])

    def declared(self, section: str, names: list[str]) -> list[str]:
        if not names:
            return []
        return [section, *(f"    {self.names[n]} : {st_type(self.types[n], self.prefix)};" for n in names), "END_VAR"]

    def write(self, text: str) -> None:
        self.lines.append("    " * self.depth + text)

    def inner(self, body: tuple[ir.Statement, ...]) -> None:
        self.depth += 1
        for statement in body:
            self.statement(statement)
        self.depth -= 1

    def statement(self, statement: ir.Statement) -> None:
        match statement:
            case ir.Assign(target, value):
                text = self.expression(value)
                self.write(f"{self.expression(target)} := {text};")
            case ir.Evaluate(call):
                self.write(f"{self.expression(call)};")
            case ir.Count(variable, stop, body):
                last = self.expression(stop)
                self.write(f"FOR {self.names[variable.name]} := 0 TO {last} - 1 DO")
                self.inner(body)
                self.write("END_FOR;")
            case ir.Branch(condition, then, otherwise):
                self.write(f"IF {self.expression(condition)} THEN")
                self.inner(then)
                if otherwise:
                    self.write("ELSE")
                    self.inner(otherwise)
                self.write("END_IF;")

    def expression(self, value: ir.Expression) -> str:
        match value:
            case ir.Constant(number, of) if of == ir.REAL:
                return st_number(float(number))
            case ir.Constant(number, of):
                return str(number).upper()
            case ir.Name(name):
                return self.names[name]
            case ir.Element(array, index):
                return f"{self.names[array.name]}[{self.expression(index)}]"
            case ir.Field(record, name):
                return f"{self.names[record.name]}.{_word(name)}"
            case ir.Operation("negate", (one,)):
                return f"(-{self.expression(one)})"
            case ir.Operation("not", (one,)):
                return f"(NOT {self.expression(one)})"
            case ir.Operation("to real", (one,)):
                return f"DINT_TO_LREAL({self.expression(one)})"
            case ir.Operation("select", (condition, first, second)):
                return self.selected(value, condition, first, second)
            case ir.Operation(operator, (first, second)):
                word = {"and": "AND", "or": "OR", "//": "/", "%": "MOD", "==": "=", "!=": "<>"}.get(operator, operator)
                return f"({self.expression(first)} {word} {self.expression(second)})"
            case ir.Call(function, arguments) if function in _FUNCTIONS:
                return f"{_FUNCTIONS[function]}({', '.join(self.expression(argument) for argument in arguments)})"
            case ir.Call(function, arguments):
                return f"{self.prefix}{function}({', '.join(self.expression(argument) for argument in arguments)})"
        raise AssertionError(value)

    def selected(
        self, value: ir.Operation, condition: ir.Expression, first: ir.Expression, second: ir.Expression
    ) -> str:
        """Return a new variable with one of two values: only that value is computed (SEL may compute both)."""
        self.chosen += 1
        name = f"chosen_{self.chosen}"
        self.names[name], self.types[name] = name, value.type
        self.write(f"IF {self.expression(condition)} THEN")
        self.inner((ir.Assign(ir.Name(name, value.type), first),))
        self.write("ELSE")
        self.inner((ir.Assign(ir.Name(name, value.type), second),))
        self.write("END_IF;")
        return name
