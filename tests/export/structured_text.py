"""Runs structured text, turned into Python a line at a time; it knows nothing of how fric emits it."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any

WORDS = {"AND": "and", "OR": "or", "NOT": "not", "MOD": "%", "TRUE": "True", "FALSE": "False"}
FUNCTIONS = {"ABS": abs, "EXP": math.exp, "EXPT": math.pow, "MIN": min, "MAX": max, "LN": math.log,
             "DINT_TO_LREAL": float}  # fmt: skip


def expression(text: str) -> str:
    text = re.sub(r"<>", "!=", text)
    text = re.sub(r"(?<![<>!:=])=(?!=)", "==", text)
    return re.sub(r"\b[A-Za-z_]\w*\b", lambda m: WORDS.get(m[0], m[0].lower()) if m[0] not in FUNCTIONS else m[0], text)


class Program:
    """Functions and function blocks of a text; names are alike whatever their case."""

    def __init__(self, text: str) -> None:
        text = re.sub(r"\(\*.*?\*\)", "", text, flags=re.S)
        self.names: dict[str, Any] = dict(FUNCTIONS)
        self.records: dict[str, list[str]] = {}
        for name, body in re.findall(r"TYPE (\w+) :\s*STRUCT(.*?)END_STRUCT", text, re.S):
            self.records[name.lower()] = [field.lower() for field in re.findall(r"(\w+) :", body)]
        for name, body in re.findall(r"^FUNCTION (\w+) : \w+\n(.*?)END_FUNCTION$", text, re.S | re.M):
            self._define(name.lower(), body)
        for name, body in re.findall(r"^FUNCTION_BLOCK (\w+)\n(.*?)END_FUNCTION_BLOCK$", text, re.S | re.M):
            self.block = name.lower()
            self.body = body

    def variables(self, body: str) -> dict[str, tuple[str, str, str]]:
        found = {}
        for section, inside in re.findall(r"(VAR\w*)\n(.*?)END_VAR", body, re.S):
            for name, kind, value in re.findall(r"(\w+) : ([^;:]+?)(?: :=(.*?))?;", inside, re.S):
                found[name.lower()] = (section, kind.strip(), value.strip())
        return found

    def _begin(self, kind: str, value: str) -> str:
        if value:
            return expression(value)
        if kind.lower() in self.records:
            fields = ", ".join(f"{field}=0.0" for field in self.records[kind.lower()])
            return f"SimpleNamespace({fields})"
        return {"LREAL": "0.0", "DINT": "0", "BOOL": "False"}[kind]

    def _lines(self, body: str, margin: str) -> list[str]:
        code = re.sub(r"VAR\w*\n.*?END_VAR", "", body, flags=re.S)
        lines, depth = [], 0
        for line in filter(None, map(str.strip, code.splitlines())):
            if match := re.fullmatch(r"IF (.*) THEN", line):
                lines.append((depth, f"if {expression(match[1])}:"))
                depth += 1
            elif match := re.fullmatch(r"ELSIF (.*) THEN", line):
                lines.append((depth - 1, f"elif {expression(match[1])}:"))
            elif line == "ELSE":
                lines.append((depth - 1, "else:"))
            elif match := re.fullmatch(r"FOR (\w+) := (.*) TO (.*) DO", line):
                lines.append(
                    (depth, f"for {match[1].lower()} in range({expression(match[2])}, {expression(match[3])} + 1):")
                )
                depth += 1
            elif line in {"END_IF;", "END_FOR;"}:
                depth -= 1
            elif match := re.fullmatch(r"([\w.\[\] +*()]+?) := (.*);", line):
                target = expression(match[1])
                value = expression(match[2])
                copied = f"copied({value})" if re.fullmatch(r"\w+", value) else value
                lines.append((depth, f"{target} = {copied}"))
            elif match := re.fullmatch(r"(\w+\(.*\));", line):
                lines.append((depth, expression(match[1])))
            else:
                raise AssertionError(f"not of the subset: {line}")
        assert depth == 0
        return [margin + "    " * level + text for level, text in lines]

    def _define(self, name: str, body: str) -> None:
        known = self.variables(body)
        given = [one for one, (section, _, _) in known.items() if section in {"VAR_INPUT", "VAR_IN_OUT"}]
        lines = [f"def {name}({', '.join(given)}):"]
        lines += [f"    {one} = {self._begin(kind, value)}" for one, (section, kind, value) in known.items()
                  if section == "VAR"]  # fmt: skip
        lines += [re.sub(rf"\b{name} =", "answer =", line) for line in self._lines(body, "    ")]
        self.run("\n".join([*lines, "    return answer"]))

    def run(self, source: str) -> None:
        self.names |= {"SimpleNamespace": SimpleNamespace, "copied": _copied}
        exec(source, self.names)

    def instance(self) -> Any:
        """Return the function block as a function of its inputs by name, which returns its variables."""
        known = self.variables(self.body)
        memory = {name: eval(self._begin(kind, value), self.names) for name, (_, kind, value) in known.items()}
        code = compile("\n".join(self._lines(self.body, "")), "block", "exec")

        def call(**inputs: Any) -> SimpleNamespace:
            memory.update(inputs)
            exec(code, self.names, memory)
            return SimpleNamespace(**memory)

        return call


def _copied(value: Any) -> Any:
    return SimpleNamespace(**vars(value)) if isinstance(value, SimpleNamespace) else value
