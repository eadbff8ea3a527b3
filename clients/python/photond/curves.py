"""Error over time as data: curves of single jobs, and their means over seeds as the daemon's reports have them."""

from __future__ import annotations

import math
from typing import Any, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from ._text import row_name, upper_bound
from .shapes import Json


class Interval(NamedTuple):
    """What the noise of two reference films leaves open of an error, at 90 %."""

    least: float
    greatest: float

    @property
    def width(self) -> float:
        return self.greatest - self.least


class Bound(NamedTuple):
    """A point where an error is not told apart from 0: no more is known than that it is below the upper end of its
    interval (half of the interval's width where that end is not above 0 either, by luck)."""

    seconds: float
    below: float
    interval: Interval


class Curve(NamedTuple):
    """Of one job and one metric; only points where it was measured and above 0. `intervals`: one for each of these, None
    where it is not known. `bounds`: the points at which the error is not told apart from 0."""

    label: str
    parameters: Json
    seed: int
    job: str
    seconds: List[float]
    passes: List[int]
    errors: List[float]
    intervals: Sequence[Optional[Interval]] = ()
    bounds: Sequence[Bound] = ()

    @property
    def name(self) -> str:
        """"photon mapping, photons 5000": the label and what the sweep gave."""
        return row_name(self.label, self.parameters)


class MeanCurve(NamedTuple):
    """Over the seeds of one row, where all their curves overlap: means, and 95 % intervals where there is more than one
    seed. `intervals` and `bounds` as those of a `Curve`."""

    label: str
    parameters: Json
    seconds: List[float]
    errors: List[float]
    low: Optional[List[float]]
    high: Optional[List[float]]
    intervals: Sequence[Optional[Interval]] = ()
    bounds: Sequence[Bound] = ()

    @property
    def name(self) -> str:
        return row_name(self.label, self.parameters)


class Drawable(NamedTuple):
    """Points of a curve as a logarithmic axis has them; what is neither above 0 nor may be is in none of the lists."""

    points: List[Mapping[str, Any]]
    intervals: List[Optional[Interval]]
    bounds: List[Bound]


def drawable(measured: Sequence[Tuple[Mapping[str, Any], Optional[float], Optional[Sequence[float]]]]) -> Drawable:
    """Of (point, error, interval).

    >>> found = drawable([({"seconds": 1}, 0.5, [0.4, 0.6]), ({"seconds": 2}, -1, [-3, 1]), ({"seconds": 3}, -2, None)])
    >>> found.points, found.intervals, [(bound.seconds, bound.below) for bound in found.bounds]
    ([{'seconds': 1}], [Interval(least=0.4, greatest=0.6)], [(2, 1)])
    """
    found = Drawable([], [], [])
    for point, error, ends in measured:
        if not point["seconds"] > 0:
            continue
        if (error or 0) > 0:
            found.points.append(point)
            found.intervals.append(Interval(*ends) if ends else None)
        elif ends and ends[1] > ends[0]:
            found.bounds.append(Bound(point["seconds"], upper_bound(ends), Interval(*ends)))
    return found


def _upper_ends(curve: Union[Curve, MeanCurve]) -> List[Tuple[float, float]]:
    """(seconds, what the error is at most), by rising seconds."""
    intervals = curve.intervals or [None] * len(curve.errors)
    values = [(time, interval.greatest if interval else error)
              for time, error, interval in zip(curve.seconds, curve.errors, intervals)]
    return sorted([*values, *((bound.seconds, max(bound.interval.greatest, bound.interval.width / 2))
                              for bound in curve.bounds)])


def _falling_fit(values: Sequence[float]) -> List[float]:
    """The non-increasing sequence at the least squared distance: pooled adjacent violators [Barlow et al. 1972]."""
    pools: List[Tuple[float, int]] = []
    for value in values:
        pools.append((value, 1))
        while len(pools) > 1 and pools[-1][0] > pools[-2][0]:
            (last, more), (mean, count) = pools.pop(), pools.pop()
            pools.append((mean + (last - mean) * more / (count + more), count + more))
    return [mean for mean, count in pools for _ in range(count)]


def time_to_error(curve: Union[Curve, MeanCurve], error: float) -> Optional[float]:
    """When it comes to `error`, as the daemon reads it: what a point and the next one are both at most (the upper end of
    the interval where there is one) is fitted by a falling curve in log error and read where that crosses, linear in log
    error over log time. So a single dip does not count, nor does the last point. At the first point: its time, an upper
    bound. None where it does not come down to `error`.

    >>> round(time_to_error(Curve("", {}, 1, "J1", [1.0, 100.0, 200.0], [1, 100, 200], [1.0, 0.01, 0.001]), 0.1), 9)
    10.0
    >>> known = Curve("", {}, 1, "J1", [1.0, 2.0, 4.0, 8.0], [1, 2, 4, 8], [0.8, 0.4, 0.2, 0.1])
    >>> time_to_error(known, 0.4), time_to_error(known, 0.1)
    (2.0, None)
    """
    points = _upper_ends(curve)
    borne_out = [(time, max(value, after)) for (time, value), (_, after) in zip(points, points[1:])]
    times = [time for time, _ in borne_out]
    logs = _falling_fit([math.log(value) for _, value in borne_out])
    goal = math.log(error)
    # What the fit left alone is compared as it was, not as its logarithm.
    there = [value <= error if log == math.log(value) else log <= goal for (_, value), log in zip(borne_out, logs)]
    if True not in there:
        return None
    i = there.index(True)
    if i == 0 or logs[i] == goal:
        return times[i]
    share = (goal - logs[i - 1]) / (logs[i] - logs[i - 1])
    return times[i - 1] * math.pow(times[i] / times[i - 1], share)
