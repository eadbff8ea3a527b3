"""What the daemon works on and ends some time: jobs and comparisons."""

from __future__ import annotations

from typing import Optional, Tuple, Union, cast

from .scene import Resource
from .shapes import Json, Stop, Target

TargetLike = Union[Target, Tuple[str, float]]
OVER = ("succeeded", "failed", "cancelled")


class Work(Resource):
    @property
    def state(self) -> str:
        """queued, running, succeeded, failed or cancelled."""
        return str(self.data["state"])

    @property
    def is_over(self) -> bool:
        return self.state in OVER

    @property
    def progress(self) -> float:
        """0 to 1."""
        return float(self.data["progress"])

    @property
    def request(self) -> Json:
        """As the daemon understood it, every default filled in."""
        return cast(Json, self.data["request"])


def stop_of(passes: Optional[int], seconds: Optional[float], target: Optional[TargetLike]) -> Stop:
    """Until when a job goes on; empty where nothing is said."""
    stop: Stop = {}
    if passes is not None:
        stop["passes"] = passes
    if seconds is not None:
        stop["seconds"] = seconds
    if isinstance(target, tuple):
        stop["target"] = {"metric": target[0], "value": target[1]}
    elif target is not None:
        stop["target"] = target
    return stop
