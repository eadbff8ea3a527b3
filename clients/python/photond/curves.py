"""Error over time as data: curves of single jobs, and their means over seeds as the daemon's reports have them."""

from __future__ import annotations

import math
from typing import List, NamedTuple, Optional, Union

from ._text import row_name
from .shapes import Json


class Curve(NamedTuple):
    """Of one job and one metric; only points where it was measured and above 0."""

    label: str
    parameters: Json
    seed: int
    job: str
    seconds: List[float]
    passes: List[int]
    errors: List[float]

    @property
    def name(self) -> str:
        """"photon mapping, photons 5000": the label and what the sweep gave."""
        return row_name(self.label, self.parameters)


class MeanCurve(NamedTuple):
    """Over the seeds of one row, where all their curves overlap: geometric means, and 95 % intervals where there is more
    than one seed."""

    label: str
    parameters: Json
    seconds: List[float]
    errors: List[float]
    low: Optional[List[float]]
    high: Optional[List[float]]

    @property
    def name(self) -> str:
        return row_name(self.label, self.parameters)


def time_to_error(curve: Union[Curve, MeanCurve], error: float) -> Optional[float]:
    """The time from which it stays at or below `error`, by linear interpolation of log error over log time; None when its
    last point is above. At or below from the first point on: that point's time, an upper bound.

    >>> round(time_to_error(Curve("", {}, 1, "J1", [1.0, 100.0], [1, 100], [1.0, 0.01]), 0.1), 9)
    10.0
    """
    times, errors = curve.seconds, curve.errors
    if not times or errors[-1] > error:
        return None
    i = len(errors) - 1
    while i > 0 and errors[i - 1] <= error:
        i -= 1
    if i == 0 or errors[i] == error:
        return times[i]
    share = math.log(error / errors[i - 1]) / math.log(errors[i] / errors[i - 1])
    return math.exp(math.log(times[i - 1]) + share * math.log(times[i] / times[i - 1]))
