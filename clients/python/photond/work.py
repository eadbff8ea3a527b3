"""What the daemon works on and ends some time: jobs, comparisons and sequences."""

from __future__ import annotations

import time
from typing import Callable, Optional, Tuple, TypeVar, Union, cast

from .errors import TimedOut
from .scene import Resource
from .shapes import Json, Stop, Target

TargetLike = Union[Target, Tuple[str, float]]
OVER = ("succeeded", "failed", "cancelled")
POLL_SECONDS = 0.3
LONGEST_POLL_SECONDS = 1.0


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

    def describe(self) -> str:
        """One line: what it is, its state and how far it is."""
        return f"{self.kind[:-1]} {self.id} {self.state}, {self.progress:.0%}"

    @property
    def request(self) -> Json:
        """As the daemon understood it, every default filled in."""
        return cast(Json, self.data["request"])


G = TypeVar("G", bound="JobGroup")


class JobGroup(Work):
    """What consists of jobs: a comparison or a sequence."""

    def refresh(self: G) -> G:
        self.data = self._client.get(self._path())
        return self

    def _look(self) -> None:
        """As refresh(), where what is followed may be less."""
        self.refresh()

    def cancel(self: G) -> G:
        """Ends the jobs it still has; what was rendered stays."""
        self.data = self._client.send("DELETE", self._path())
        return self

    def purge(self) -> None:
        """Removes it with its jobs and their files."""
        self._client.send("DELETE", self._path(), query={"purge": True})

    def _follow(self: G, timeout: Optional[float], cancel_on_interrupt: bool,
                on_change: Optional[Callable[[G], object]], show: Optional[Callable[[G], object]]) -> None:
        """Asks until it is over. Raises TimedOut after `timeout` seconds; it goes on then. `show`: once more at the end."""
        deadline = None if timeout is None else time.monotonic() + timeout
        pause = POLL_SECONDS
        try:
            while True:
                before = self.data
                self._look()
                if on_change is not None and self.data != before:
                    on_change(self)
                if show is not None and (self.data != before or self.is_over):
                    show(self)
                if self.is_over:
                    return
                left = pause if deadline is None else min(pause, deadline - time.monotonic())
                if left <= 0:
                    raise TimedOut(f"{self.kind[:-1]} {self.id} is {self.state} after {timeout:g} s; it goes on")
                time.sleep(left)
                pause = min(pause * 1.1, LONGEST_POLL_SECONDS)
        except KeyboardInterrupt:
            if cancel_on_interrupt:
                self.cancel()
            raise


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
