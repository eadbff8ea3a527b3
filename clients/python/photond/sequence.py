"""Sequences: the frames of a moving scene, or along a path of the camera."""

from __future__ import annotations

import os
from typing import Callable, Iterable, Iterator, List, Optional, cast

from ._files import Path
from ._text import counted
from .errors import PhotondError
from .job import Job
from .progress import Progress, shown
from .shapes import Frame, SequenceErrors
from .work import JobGroup


class Sequence(JobGroup):
    """Frames that are rendered in order by a worker that keeps what does not move.

    >>> sequence = client.sequence("moving/teleport", to=1, fps=2, width=16, height=12, passes=1)
    >>> sequence.state, [frame["time"] for frame in sequence.frames]
    ('succeeded', [0.0, 0.5, 1.0])
    >>> len({job.statistics["pixel_hash"] for job in sequence.jobs()})
    3
    """

    kind = "sequences"

    def _look(self) -> None:
        self.data = self._client.get(self._path(), {"frames": False})

    @property
    def frames(self) -> List[Frame]:
        """Of each its `time`, the `id` of its job, its `state` and the `seconds` of its rendering."""
        if "frames" not in self.data:  # one from a list, or that has been waited for
            self.refresh()
        return cast(List[Frame], self.data["frames"])

    @property
    def seconds_left(self) -> Optional[float]:
        """As frames that are done tell; None before the first one is."""
        return cast(Optional[float], self.data["seconds_left"])

    def jobs(self) -> Iterator[Job]:
        """Asked of the daemon one by one."""
        return (Job.fetch(self._client, frame["id"]) for frame in self.frames)

    def wait(self, timeout: Optional[float] = None, *, check: bool = True, cancel_on_interrupt: bool = False,
             on_change: Optional[Callable[["Sequence"], object]] = None,
             progress: "Progress[Sequence]" = None) -> "Sequence":
        """Until all frames are over. Raises TimedOut after `timeout` seconds (it goes on), and with `check` SequenceFailed
        where not all succeeded. `progress` as for a job's."""
        self._follow(timeout, cancel_on_interrupt, on_change, shown(progress))
        if check and self.state != "succeeded":
            wrong = [str(frame["frame"]) for frame in self.frames if frame["state"] != "succeeded"]
            raise SequenceFailed(self, f"sequence {self.id} {self.state}: frames " + ", ".join(wrong[:10]) +
                                 (" ..." if len(wrong) > 10 else ""))
        return self

    def __repr__(self) -> str:
        return f"<{self.describe().capitalize()}: {self.request['scene']}, {counted(self.request['frames'], 'frame')}>"

    def errors(self, first: "Sequence", second: "Sequence", *, layer: str = "beauty") -> SequenceErrors:
        """By frame its error, its flicker and its lag against two sequences of the same frames, whose seeds differ by more
        than they have frames.

        >>> of = {"to": 1, "fps": 2, "width": 16, "height": 12}
        >>> first, second = (client.sequence("moving/teleport", passes=16, seed=seed, **of) for seed in (100, 200))
        >>> errors = client.sequence("moving/teleport", passes=1, **of).errors(first, second)
        >>> [frame["frame"] for frame in errors["frames"]], errors["frames"][0]["flicker"]
        ([0, 1, 2], None)
        """
        return cast(SequenceErrors, self._client.get(self._path("/errors"), {"first": first.id, "second": second.id,
                                                                             "layer": layer}))

    def save(self, folder: Path, name: str = "image.exr") -> List[str]:
        """The images of the frames that succeeded, as `folder`/0000.exr; `name` may be preview.png."""
        os.makedirs(folder, exist_ok=True)
        paths = []
        for frame in self.frames:
            if frame["state"] == "succeeded":
                paths.append(os.path.join(folder, f"{frame['frame']:04d}{os.path.splitext(name)[1]}"))
                Job.fetch(self._client, frame["id"]).download(name, paths[-1])
        return paths

    def save_video(self, path: Path, *, fps: Optional[float] = None, exposure: float = 0, curve: str = "srgb") -> None:
        """The frames that succeeded, to look at, by what the path ends with: .mp4, for which the daemon needs an ffmpeg, or
        .png, at most 100 of them beside each other. `fps`: frames a second, else the sequence's own; `exposure`: stops."""
        kind = str(path).rpartition(".")[2].lower()
        if kind not in ("mp4", "png"):
            raise ValueError(f"cannot tell what to save as {path}: name it .mp4 or .png")
        query = {"format": kind, "exposure": exposure, "curve": curve, **({} if fps is None else {"fps": fps})}
        self.download("video", path, **query)

    def save_report(self, path: Path, first: Optional["Sequence"] = None, second: Optional["Sequence"] = None, *,
                    layer: str = "beauty", beside: Iterable["Sequence"] = ()) -> None:
        """A page that stands alone: its frames and, against two references as errors() takes them, error, flicker and lag
        by frame; `beside`: other sequences of the same frames."""
        query = {"layer": layer, "beside": ",".join(other.id for other in beside)}
        if first is not None and second is not None:
            query.update(first=first.id, second=second.id)
        self.download("report.html", path, **query)


class SequenceFailed(PhotondError):
    """`sequence` ended with failed or cancelled frames; the others are there."""

    def __init__(self, sequence: Sequence, text: str) -> None:
        super().__init__(text)
        self.sequence = sequence
