"""Error over time on log axes, by matplotlib."""

from __future__ import annotations

from typing import Any, List, Mapping, Optional, Sequence, Tuple

from ._optional import needed
from ._text import human_number
from .curves import MeanCurve

# Colours told apart by the colour-blind [Okabe and Ito 2008], Color Universal Design; as the daemon's reports have them.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999933")
DASHES = ("-", "--", ":", "-.")
ROOM_BELOW = 3  # bands that reach 0 end at this part of the least error
ARROW = 0.4  # of an upper bound: down to this part less of it


def _band(curve: MeanCurve) -> List[Tuple[float, float, float]]:
    """(seconds, low, high): 95 % over the seeds; of one seed what the reference's noise leaves open, at 90 %."""
    if curve.low is not None and curve.high is not None:
        return list(zip(curve.seconds, curve.low, curve.high))
    known = [(time, ends.least, ends.greatest) for time, ends in zip(curve.seconds, curve.intervals) if ends is not None]
    return known if len(known) == len(curve.seconds) else []


def plot_curves(curves: Sequence[MeanCurve], metric: str, *, ax: Any = None,
                reference_noise: Optional[float] = None, floors: Optional[Mapping[str, float]] = None) -> Any:
    """Returns the Axes: `ax`, or a new one. Where an error is not told apart from 0, an arrow goes down from what it is
    below. `floors`: by a curve's name, what it reaches no less than (`Comparison.floors`), as dotted lines."""
    if ax is None:
        ax = needed("matplotlib.pyplot", "a plot").figure(figsize=(7, 4.5), layout="constrained").add_subplot()
    shown = [error for curve in curves for error in [*curve.errors, *(bound.below for bound in curve.bounds)]]
    bottom = min(shown) / ROOM_BELOW if shown else 0.0
    for i, curve in enumerate(curves):
        colour, dash = COLOURS[i % len(COLOURS)], DASHES[i // len(COLOURS) % len(DASHES)]
        # The line ends before what is only bounded, and goes on after it.
        points = sorted([*zip(curve.seconds, curve.errors), *((bound.seconds, float("nan")) for bound in curve.bounds)])
        alone = "o" if len(curve.seconds) == 1 else None
        ax.plot([time for time, _ in points], [error for _, error in points], dash, color=colour, marker=alone,
                label=curve.name, linewidth=1.5)
        band = _band(curve)
        if band:
            ax.fill_between([time for time, _, _ in band], [max(low, bottom) for _, low, _ in band],
                            [max(high, bottom) for _, _, high in band], color=colour, alpha=0.15, linewidth=0)
        if curve.bounds:
            below = [bound.below for bound in curve.bounds]
            ax.errorbar([bound.seconds for bound in curve.bounds], below, yerr=[ARROW * bound for bound in below],
                        uplims=True, fmt="none", ecolor=colour, elinewidth=1.2)
        if floors and curve.name in floors:
            ax.axhline(floors[curve.name], color=colour, linewidth=1.2, linestyle=(0, (1, 2)),
                       label=f"{curve.name}: reaches no less than {human_number(floors[curve.name])}")
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
