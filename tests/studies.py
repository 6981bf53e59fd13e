"""Studies of many machines, as tests run them."""

from fric.simulate.processes import MonteCarlo, Study, run_all


def monte_carlo(study: Study, machines: int, *, workers: int | None = None) -> MonteCarlo:
    """Run a study on a number of machines."""
    return MonteCarlo(study, machines, tuple(run_all(study, machines, workers=workers)))
