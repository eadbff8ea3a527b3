"""Error over time as data: curves of single jobs, and their means over seeds as the daemon's reports have them."""

from __future__ import annotations

import math
from typing import List, NamedTuple, Optional, Sequence, Tuple, Union

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
    """Over the seeds of one row: geometric means, and 95 % intervals where there is more than one seed."""

    label: str
    parameters: Json
    seconds: List[float]
    errors: List[float]
    low: Optional[List[float]]
    high: Optional[List[float]]

    @property
    def name(self) -> str:
        return row_name(self.label, self.parameters)


def error_at_time(curve: Curve, seconds: float) -> Optional[float]:
    """By linear interpolation of log error over log time; None outside the curve's span.

    >>> round(error_at_time(Curve("", {}, 1, "J1", [1.0, 100.0], [1, 100], [1.0, 0.01]), 10), 9)
    0.1
    """
    times, errors = curve.seconds, curve.errors
    if not times or not times[0] <= seconds <= times[-1]:
        return None
    i = next(i for i, time in enumerate(times) if time >= seconds)
    if times[i] == seconds:
        return errors[i]
    share = math.log(seconds / times[i - 1]) / math.log(times[i] / times[i - 1])
    return math.exp(math.log(errors[i - 1]) + share * math.log(errors[i] / errors[i - 1]))


def time_to_error(curve: Union[Curve, MeanCurve], error: float) -> Optional[float]:
    """The time from which it stays at or below `error`, interpolated likewise; None when its last point is above. At or
    below from the first point on: that point's time, an upper bound.

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


def mean_curve(curves: Sequence[Curve]) -> Optional[MeanCurve]:
    """Where all overlap, at the times of the first one's points."""
    curves = [curve for curve in curves if curve.seconds]
    if not curves:
        return None
    begin, end = max(curve.seconds[0] for curve in curves), min(curve.seconds[-1] for curve in curves)
    first = curves[0]
    if end < begin:  # measured so rarely that there is no time they share: their ends
        times = [log_mean([curve.seconds[-1] for curve in curves])[0]]
        measured = [[curve.errors[-1] for curve in curves]]
    else:
        times = [begin, *(time for time in first.seconds if begin < time < end), *([end] if end > begin else [])]
        found = [[error_at_time(curve, time) for curve in curves] for time in times]
        measured = [[error for error in errors if error is not None] for errors in found]
    means = [log_mean(errors) for errors in measured]
    known = len(curves) > 1
    return MeanCurve(first.label, first.parameters, times, [mean for mean, _, _ in means],
                     [low for _, low, _ in means] if known else None, [high for _, _, high in means] if known else None)


def log_mean(values: Sequence[float]) -> Tuple[float, float, float]:
    """Mean of positive numbers and its 95 % interval, both of their logarithms (Student's t); of one number itself.

    >>> [round(value, 3) for value in log_mean([0.9, 1.0, 1.1, 1.0])]
    [0.997, 0.876, 1.136]
    """
    logs = [math.log(value) for value in values]
    mean = math.fsum(logs) / len(logs)
    if len(logs) == 1:
        return values[0], values[0], values[0]
    variance = math.fsum((value - mean) ** 2 for value in logs) / (len(logs) - 1)
    half_width = student_t(0.95, len(logs) - 1) * math.sqrt(variance / len(logs))
    return math.exp(mean), math.exp(mean - half_width), math.exp(mean + half_width)


def student_t(confidence: float, degrees: int) -> float:
    """Half the width of the central interval that holds `confidence` of Student's t.

    >>> [round(student_t(0.95, degrees), 3) for degrees in (1, 2, 3, 10, 30)]
    [12.706, 4.303, 3.182, 2.228, 2.042]
    """
    low, high = 0.0, 1.0
    while _central_share(high, degrees) < confidence:
        high *= 2
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if _central_share(middle, degrees) < confidence else (low, middle)
    return (low + high) / 2


def _central_share(t: float, degrees: int) -> float:
    """[Abramowitz and Stegun 1964, Eq. 26.7.3 and 26.7.4]"""
    angle = math.atan(t / math.sqrt(degrees))
    cosine = math.cos(angle)
    term, total = (cosine, 0.0) if degrees % 2 else (1.0, 0.0)
    for k in range(2 if degrees % 2 else 1, degrees, 2):
        total += term
        term *= cosine * cosine * k / (k + 1)
    total *= math.sin(angle)
    return 2 / math.pi * (angle + total) if degrees % 2 else total
