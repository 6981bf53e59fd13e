"""Golden outputs: what every verb gives on the same inputs, before a change and after it.

A refactoring is checked so, from the commit before (in a `git worktree` of it, on its own PYTHONPATH) and from now:

    python -m tests.golden make build/golden/before
    python -m tests.golden make build/golden/after
    python -m tests.golden compare build/golden/before build/golden/after

The records of the machines with flaws are simulated once, into `records` beside the folder, so that what is identified
of them can be compared across a change of the simulation.
"""
