"""Virtual experiments and the circular test."""
