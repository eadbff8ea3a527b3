"""What the daemon works on and ends some time: jobs and comparisons."""

from __future__ import annotations

from typing import cast

from .scene import _Resource
from .shapes import Json

OVER = ("succeeded", "failed", "cancelled")


class Work(_Resource):
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
