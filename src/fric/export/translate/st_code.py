"""A program in structured text (IEC 61131-3): functions and structures, without vendor-specific parts."""

from fric.export.templates import render
from fric.export.translate import program as ir

_RESERVED = ir.reserved("st")
_OPERATIONS = {
    "negate": "(-{})", "not": "(NOT {})", "to real": "DINT_TO_LREAL({})", "and": "({} AND {})", "or": "({} OR {})",
    "//": "({} / {})", "%": "({} MOD {})", "==": "({} = {})", "!=": "({} <> {})",
}  # fmt: skip


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
    pieces = []
    for record in program.records:
        members = "\n".join(f"    {_word(name)} : {st_type(of, prefix)};" for name, of in record.fields)
        pieces.append(f"TYPE {st_type(record, prefix)} :\nSTRUCT\n{members}\nEND_STRUCT\nEND_TYPE")
    called = [name for name in ("copysign", "log1p") if program.calls(name)]
    pieces += filter(None, [render("helpers.st.j2", called=called, prefix=prefix).rstrip()])
    return "\n\n".join([*pieces, *(_StRoutine(routine, prefix).text() for routine in program.routines)])


def _word(name: str) -> str:
    return f"{name}_x" if name.lower() in _RESERVED else name


class _StRoutine(ir.Writer):
    """Writes a routine. Names differ by more than their case, which the language ignores."""

    loop = ("FOR {} := 0 TO {} - 1 DO", "END_FOR;")
    branch = ("IF {} THEN", "ELSE", "END_IF;")
    constant = str.upper

    def __init__(self, routine: ir.Routine, prefix: str) -> None:
        super().__init__(routine, prefix, 0, _OPERATIONS)
        self.names: dict[str, str] = {}
        self.types: dict[str, ir.Type] = {}
        for node in (*routine.arguments, *(node for node in routine.nodes if isinstance(node, ir.Name))):
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
        self.write(f"{name} := {'TRUE' if routine.result is None else self.expression(routine.result)};")
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

    def name(self, name: str) -> str:
        return self.names[name]

    def field(self, name: str) -> str:
        return _word(name)

    def number(self, value: float) -> str:
        return st_number(value)

    def function(self, name: str) -> str:
        return {"exp": "EXP", "pow": "EXPT", "abs": "ABS", "min": "MIN", "max": "MAX"}.get(name, self.prefix + name)

    def assign(self, target: ir.Name | ir.Element | ir.Field, value: str) -> None:
        self.write(f"{self.expression(target)} := {value};")

    def expression(self, value: ir.Expression) -> str:
        """Return a text; of a choice a new variable: only one value is computed then (SEL may compute both)."""
        if not (isinstance(value, ir.Operation) and value.operator == "select"):
            return super().expression(value)
        condition, *values = value.operands
        self.chosen += 1
        name = ir.Name(f"chosen_{self.chosen}", value.type)
        self.names[name.name], self.types[name.name] = name.name, value.type
        self.statement(ir.Branch(condition, *((ir.Assign(name, value),) for value in values)))
        return name.name
