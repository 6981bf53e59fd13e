"""Benchmarks: each module measures a ratio against a named baseline in the same run; `make bench` prints them."""
