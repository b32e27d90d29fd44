"""How treelet's plots look: few lines, direct labels, colours that colour-blind readers can tell apart."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Theme:
    """Colours of a plot."""

    paper: str
    ink: str
    quiet: str  # axes, notes
    band: str  # light shading behind the data
    lines: tuple[str, ...]


# Lines follow Okabe and Ito's palette; the second, treelet's in every comparison, is the strongest.
LIGHT = Theme(
    "#ffffff",
    "#1d1f26",
    "#737885",
    "#f3f4f7",
    ("#e08a00", "#0067a8", "#7a7f8c", "#cc4c8a", "#009e73", "#56b4e9"),
)
DARK = Theme(
    "#14161c",
    "#eceef2",
    "#9aa0ad",
    "#1c1f27",
    ("#f0a830", "#56b4e9", "#a3a8b5", "#e07bb0", "#30c59b", "#f0e442"),
)
THEMES = {"light": LIGHT, "dark": DARK}


@contextmanager
def figure(
    path: str | Path, theme: Theme, width: float = 9.6, height: float = 5.4
) -> Iterator[tuple[Any, Any]]:
    """A figure and its axes in treelet's style, saved to `path` on leaving; sizes in inches at 150 dots.

    Figures are made without pyplot: no display, no global state. Raises ImportError where matplotlib is
    missing.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError as missing:
        raise ImportError("plots need matplotlib: pip install 'treelet[cli]'") from missing
    with matplotlib.rc_context(_settings(theme)):
        drawing = Figure(figsize=(width, height), layout="constrained")
        drawing.get_layout_engine().set(w_pad=0.12, h_pad=0.12)
        yield drawing, drawing.add_subplot()
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        # Without the library's version in the file, equal data gives equal bytes.
        drawing.savefig(path, dpi=150, metadata={"Software": None} if str(path).endswith(".png") else None)


def _settings(theme: Theme) -> dict[str, Any]:
    return {
        "font.size": 11,
        "font.family": "sans-serif",
        "text.color": theme.ink,
        "figure.facecolor": theme.paper,
        "axes.facecolor": theme.paper,
        "axes.edgecolor": theme.quiet,
        "axes.labelcolor": theme.quiet,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.spines.left": False,
        "xtick.color": theme.quiet,
        "ytick.color": theme.quiet,
        "ytick.left": False,
        "axes.grid": True,
        "axes.grid.axis": "y",
        "grid.color": theme.quiet,
        "grid.alpha": 0.25,
        "grid.linewidth": 0.6,
        "lines.linewidth": 2.4,
        "lines.solid_capstyle": "round",
        "svg.hashsalt": "treelet",
    }
