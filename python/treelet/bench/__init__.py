"""Measuring recipes: build times and ray rates into JSON lines, effective performance out of them."""

from treelet.bench.effective import Curve, best_ranges, crossover, curves_of, effective_rate
from treelet.bench.measure import Candidate, Plan, measure
from treelet.bench.records import Measurement, read_measurements, write_measurements

__all__ = [
    "Candidate",
    "Curve",
    "Measurement",
    "Plan",
    "best_ranges",
    "crossover",
    "curves_of",
    "effective_rate",
    "measure",
    "read_measurements",
    "write_measurements",
]
