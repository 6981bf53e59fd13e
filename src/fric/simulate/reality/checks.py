"""What the numbers of a flaw must be."""

from dataclasses import fields

from fric.errors import FricError


def not_negative(flaw: object, name: str) -> None:
    """Raise `FricError` where a number of a flaw is negative."""
    for field in fields(flaw):  # type: ignore[arg-type]
        value = getattr(flaw, field.name)
        if isinstance(value, float) and not value >= 0.0:
            raise FricError(f"{name}: {field.name} is {value:g}", hint="Give zero or a positive value.")


def positive(flaw: object, name: str, *which: str) -> None:
    """Raise `FricError` where one of these fields is not positive."""
    for field in which:
        if not getattr(flaw, field) > 0.0:
            raise FricError(f"{name}: {field} is {getattr(flaw, field):g}", hint="Give a positive value.")


def below_one(flaw: object, name: str, field: str) -> None:
    """Raise `FricError` where a share is not below 1."""
    if not abs(getattr(flaw, field)) < 1.0:
        raise FricError(f"{name}: {field} is {getattr(flaw, field):g}", hint="Give a share below 1.")
