"""How a record is read: its resolution, reversals, steady segments, and what it is good for."""
