"""Numbers and tables as people read them, in the same words as photonctl."""

from __future__ import annotations

import html
import json
from typing import Any, Iterable, List, Optional, Sequence


def _three_digits(value: float) -> str:
    return f"{value:.0f}" if value >= 99.95 else f"{value:.1f}" if value >= 9.995 else f"{value:.2f}"


def human_bytes(count: Optional[float]) -> str:
    """
    >>> human_bytes(1.8e6)
    '1.80 MB'
    """
    if count is None:
        return "-"
    units = ("B", "kB", "MB", "GB", "TB")
    unit = 0
    while count >= 999.5 and unit + 1 < len(units):
        count /= 1000
        unit += 1
    return (f"{count:.0f}" if unit == 0 else _three_digits(count)) + " " + units[unit]


def human_seconds(seconds: Optional[float]) -> str:
    """
    >>> human_seconds(0.0123), human_seconds(75)
    ('12.3 ms', '1 min 15 s')
    """
    if seconds is None or not seconds >= 0:
        return "-"
    if seconds == 0:
        return "0 s"
    if seconds < 9.995e-4:
        return _three_digits(seconds * 1e6) + " us"
    if seconds < 0.9995:
        return _three_digits(seconds * 1e3) + " ms"
    if seconds < 59.95:
        return _three_digits(seconds) + " s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole // 60 % 60:02d} min"


def counted(count: int, one: str, several: str = "") -> str:
    """
    >>> counted(1, "frame"), counted(2, "frame"), counted(0, "entry", "entries")
    ('1 frame', '2 frames', '0 entries')
    """
    return f"{count} {one if count == 1 else several or one + 's'}"


def human_number(value: Any) -> str:
    """Three digits that count; whole numbers whole; None is a dash."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        if value == int(value) and abs(value) < 1e7:
            return str(int(value))
        return f"{value:.3g}"
    return str(value) if isinstance(value, str) else json.dumps(value)


def upper_bound(interval: Sequence[float]) -> float:
    """Of an error that is not told apart from 0: the upper end of its interval. Where that lies below 0 too, by luck: half
    of the width, which is what an error of 0 would have."""
    return interval[1] if interval[1] > 0 else (interval[1] - interval[0]) / 2


def human_error(value: Optional[float], interval: Optional[Sequence[float]] = None) -> str:
    """With what is left open of it; an error that is not told apart from 0 is an upper bound.

    >>> human_error(0.0012, [0.0008, 0.0016]), human_error(-0.001, [-0.006, 0.004]), human_error(None)
    ('0.0012 (0.0008 to 0.0016)', 'below 0.004 (not told apart from 0)', '-')
    """
    if interval and not (value or 0) > 0 and interval[1] > interval[0]:
        return f"below {human_number(upper_bound(interval))} (not told apart from 0)"
    if interval and value:
        return f"{human_number(value)} ({human_number(interval[0])} to {human_number(interval[1])})"
    return human_number(value)


def row_name(label: str, parameters: Any) -> str:
    """
    >>> row_name("photon mapping", {"photons": 5000})
    'photon mapping, photons 5000'
    """
    return ", ".join([label] + [f"{key} {human_number(value)}" for key, value in (parameters or {}).items()])


class TextTable:
    """Columns in line; a head that begins with '>' is set to the right."""

    def __init__(self, heads: Sequence[str]) -> None:
        self.right = [head.startswith(">") for head in heads]
        self.heads = [head.lstrip(">") for head in heads]
        self.rows: List[List[str]] = []

    def add(self, cells: Iterable[str]) -> None:
        row = list(cells)
        assert len(row) == len(self.heads), (row, self.heads)
        self.rows.append(row)

    def __str__(self) -> str:
        lines = ([self.heads] if any(self.heads) else []) + self.rows
        widths = [max(len(line[i]) for line in lines) for i in range(len(self.heads))] if lines else []
        texts = []
        for line in lines:
            cells = [cell.rjust(width) if right else cell.ljust(width)
                     for cell, width, right in zip(line, widths, self.right)]
            texts.append("  ".join(cells).rstrip())
        return "\n".join(texts)

    def html(self, caption: str = "") -> str:
        def row(cells: Sequence[str], tag: str) -> str:
            return "<tr>" + "".join(
                f'<{tag} style="text-align:{"right" if right else "left"}">{html.escape(cell)}</{tag}>'
                for cell, right in zip(cells, self.right)) + "</tr>"

        head = f"<thead>{row(self.heads, 'th')}</thead>" if any(self.heads) else ""
        title = f"<caption>{html.escape(caption)}</caption>" if caption else ""
        return f"<table>{title}{head}<tbody>{''.join(row(line, 'td') for line in self.rows)}</tbody></table>"
