"""Analysis of records: resolution, reversals, steady segments, and uses."""
