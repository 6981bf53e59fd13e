"""Where `fric.output` was; goes as soon as nobody looks here."""

from fric.output import refuse_existing, staged

__all__ = ["refuse_existing", "staged"]
