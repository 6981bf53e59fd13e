"""Measured circle tests: diagnosis, comparison with a prediction, and what a controller learns from them."""
