"""Numbers as people read them."""

from __future__ import annotations


def count(value: int) -> str:
    """12345678 -> '12,345,678'."""
    return f"{value:,}"


def milliseconds(seconds: float) -> str:
    """0.0123 -> '12.3', 1.234 -> '1,234'."""
    value = seconds * 1e3
    return f"{value:,.0f}" if value >= 99.95 else f"{value:.1f}" if value >= 9.995 else f"{value:.2f}"


def mega(value: float) -> str:
    """Millions with three digits: 2345678 -> '2.35'."""
    value /= 1e6
    return f"{value:,.0f}" if value >= 99.95 else f"{value:.1f}" if value >= 9.995 else f"{value:.2f}"


def byte_count(value: int) -> str:
    """123456 -> '120.6 KiB'."""
    size, units = float(value), ["B", "KiB", "MiB", "GiB", "TiB"]
    while size >= 1024.0 and len(units) > 1:
        size /= 1024.0
        units.pop(0)
    return f"{size:.1f} {units[0]}" if units[0] != "B" else f"{value} B"


def coordinates(values) -> str:
    """Up to six digits each: '-1.5  0  12.25'."""
    return "  ".join(f"{float(value):.6g}" for value in values)


def bar(share: float, width: int = 24) -> str:
    """A bar of block characters, `share` of `width` columns wide."""
    eighths = round(max(0.0, min(1.0, share)) * width * 8)
    return "█" * (eighths // 8) + ("", "▏", "▎", "▍", "▌", "▋", "▊", "▉")[eighths % 8]
