"""Plots from measurements."""

from treelet.plots.effective import plot_effective

__all__ = ["plot_effective"]
