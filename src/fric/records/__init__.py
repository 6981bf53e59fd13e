"""How a record is read: its resolution, reversals, steady segments, and its uses."""
