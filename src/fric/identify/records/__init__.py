"""How a record is read: its resolution, reversals, steady stretches, and what it is good for."""
