"""Error over time on log axes, by matplotlib."""

from __future__ import annotations

from typing import Any, Optional, Sequence

from ._optional import needed
from .curves import MeanCurve

# Colours told apart by the colour-blind [Okabe and Ito 2008], Color Universal Design; as the daemon's reports have them.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999933")
DASHES = ("-", "--", ":", "-.")


def plot_curves(curves: Sequence[MeanCurve], metric: str, *, ax: Any = None,
                reference_noise: Optional[float] = None) -> Any:
    """Returns the Axes: `ax`, or a new one."""
    if ax is None:
        ax = needed("matplotlib.pyplot", "a plot").figure(figsize=(7, 4.5), layout="constrained").add_subplot()
    for i, curve in enumerate(curves):
        colour, dash = COLOURS[i % len(COLOURS)], DASHES[i // len(COLOURS) % len(DASHES)]
        alone = "o" if len(curve.seconds) == 1 else None
        ax.plot(curve.seconds, curve.errors, dash, color=colour, marker=alone, label=curve.name, linewidth=1.5)
        if curve.low is not None and curve.high is not None:
            ax.fill_between(curve.seconds, curve.low, curve.high, color=colour, alpha=0.15, linewidth=0)
    if reference_noise:
        ax.axhline(reference_noise, color="0.5", linewidth=1, linestyle=(0, (1, 2)), label="the reference's own noise")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("seconds")
    ax.set_ylabel(metric)
    ax.grid(True, which="major", color="0.85", linewidth=0.6)
    ax.set_axisbelow(True)
    if curves:
        ax.legend(fontsize="small", frameon=False)
    return ax
