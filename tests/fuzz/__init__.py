"""Mutated inputs of every kind: each must end well or in a sentence. `make fuzz` is the long run."""
