from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from treelet.bench import Curve
from treelet.plots import plot_effective
from treelet.plots.effective import ray_count_text, spread_apart

CURVES = [Curve("LBVH", 0.05, 1.4e6), Curve("treelet", 0.12, 2.05e6), Curve("sweep SAH", 1.4, 2.12e6)]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_plot_is_written_and_repeats(tmp_path, theme):
    first = plot_effective(CURVES, tmp_path / "new" / "a.png", "city", "a note", theme).read_bytes()
    second = plot_effective(CURVES, tmp_path / "b.png", "city", "a note", theme).read_bytes()
    assert first.startswith(b"\x89PNG")
    assert first == second


def test_plot_names_lines_best_ranges_and_crossovers(tmp_path, monkeypatch):
    import matplotlib

    monkeypatch.setitem(matplotlib.rcParams, "svg.fonttype", "none")
    text = plot_effective(CURVES, tmp_path / "plot.svg", "city", "a note").read_text()
    for part in (
        "LBVH",
        "sweep SAH",
        "treelet best",
        "sweep SAH best",
        "79M rays",
        "interactive",
        "film",
        "a note",
    ):
        assert part in text


def test_one_curve_is_enough(tmp_path):
    assert plot_effective(CURVES[:1], tmp_path / "one.png").exists()


def test_bad_plots_are_refused(tmp_path):
    with pytest.raises(ValueError, match="there are no curves to plot"):
        plot_effective([], tmp_path / "none.png")
    with pytest.raises(ValueError, match="unknown theme 'neon': choose one of light, dark"):
        plot_effective(CURVES, tmp_path / "none.png", theme="neon")


@pytest.mark.parametrize(
    ("rays", "text"),
    [
        (1e6, "1M"),
        (1e12, "1T"),
        (7.93e7, "79M"),
        (3.16e9, "3.2G"),
        (9.99e8, "999M"),
        (9.999e8, "1G"),
        (42, "42"),
    ],
)
def test_ray_counts_read_well(rays, text):
    assert ray_count_text(rays) == text


def test_labels_keep_their_order_and_distance():
    moved = spread_apart([0.5, 0.49, 0.1, 0.51], 0.1)
    assert np.argsort(moved).tolist() == [2, 1, 0, 3]
    assert np.diff(np.sort(moved)).min() == pytest.approx(0.1, abs=1e-4)
    assert moved[2] == pytest.approx(0.1)
