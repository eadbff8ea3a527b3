"""Render jobs."""

from __future__ import annotations

import json
import pathlib
import time
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Mapping, Optional, cast

from ._daemon import Daemon
from ._events import EventParser, ServerEvent
from ._files import Path
from ._http import ConnectionLost
from ._text import counted, human_error, human_number, human_seconds
from .curves import Interval
from .errors import NothingYet, PhotondError, TimedOut, WithProblem
from .pixels import Pixels
from .progress import Progress, shown
from .shapes import CurvePoint, Json, Stop
from .work import OVER, Work, stop_of

if TYPE_CHECKING:
    import numpy
    import numpy.typing

SILENCE_SECONDS = 45.0  # a few of the stream's heartbeats
POLL_SECONDS = 0.5
STREAM_TRIES = 3  # without one event between them; then polling


class Event:
    """Something that happened to a job: `kind` is state, progress or curve, `changes` the fields that changed."""

    def __init__(self, kind: str, id: Optional[int], changes: Json) -> None:
        self.kind = kind
        #: Rising over the whole daemon; None where a look at the job told it, not the stream.
        self.id = id
        self.changes = changes

    @property
    def job(self) -> Optional[str]:
        """The job's id."""
        return self.changes.get("id")

    def __repr__(self) -> str:
        values = [f"{key} {human_number(value)}" for key, value in self.changes.items()
                 if key != "id" and isinstance(value, (str, int, float))]
        if "curve" in self.changes:
            values.append(counted(len(self.changes["curve"] or []), "point"))
        return f"<Event {self.kind} of {self.job}: {', '.join(values)}>"


def parsed(event: ServerEvent) -> Optional[Event]:
    """None where its data is not what photond sends."""
    try:
        changes = json.loads(event.data)
    except ValueError:
        return None
    if not isinstance(changes, dict):
        return None
    return Event(event.kind, int(event.id) if event.id.isdigit() else None, changes)


class Job(Work):
    """One render job. Its properties say what the daemon told last; `refresh` and `wait` ask anew. Shown in a notebook,
    it is its image so far.

    >>> job = client.render("furnace", width=16, height=8, passes=4, layers=["depth"])
    >>> job.state, job.passes_done
    ('succeeded', 4)
    >>> image = job.image()  # numpy
    >>> image.shape, image.dtype.name
    ((8, 16, 3), 'float32')
    >>> float(job.image(layer="emitted").mean())  # the furnace's walls emit 1 W m^-2 sr^-1
    1.0
    >>> job.image(layer="depth").shape
    (8, 16)
    >>> job.statistics["counts"]["passes"]
    4
    """

    kind = "jobs"

    # --- what is known of it ------------------------------------------------------------------------------------------
    @property
    def passes_done(self) -> int:
        return int(self.data["passes_done"])

    @property
    def seconds(self) -> float:
        """Of rendering, so far."""
        return float(self.data["seconds"])

    @property
    def labels(self) -> Dict[str, str]:
        return self.request.get("labels") or {}

    @property
    def statistics(self) -> Json:
        """Stages, counts, memory, hashes, errors; empty until the job is over."""
        return cast(Json, self.data.get("statistics") or {})

    @property
    def warning(self) -> Optional[str]:
        """Where other processes took more than 2 % of the processor time that it wanted: how much and who, in a sentence.
        Its clock cannot be compared then."""
        return cast(Optional[str], (self.statistics.get("shared") or {}).get("warning"))

    @property
    def left_out(self) -> List[str]:
        """Kinds of path that its image does not have, as phrases; empty until the job is over.

        >>> one_bounce = client.methods["path_tracing"](indirect_bounces=1)
        >>> job = client.render("cornell-box", one_bounce, width=8, height=8, passes=1)
        >>> job.left_out
        ['light of more than 1 bounce']
        """
        return [kind["text"] for kind in self.statistics.get("left_out") or []]

    @property
    def reference_jobs(self) -> List[str]:
        """The jobs it is measured against: two films of different seeds where the reference was made by a method, one where
        a job was named; empty where it was an image, and without a reference."""
        return list(self.data.get("reference_jobs") or ([self.data["reference_job"]] if self.data.get("reference_job") else []))

    @property
    def errors(self) -> Json:
        """By metric, against the reference, at the end; empty without a reference. Means of squares that two films measured
        may be negative where they are near 0, and their roots None: `error_intervals` says what they may be.

        >>> job = client.render("cornell-box", width=16, height=16, passes=2, reference="path_tracing:64")
        >>> least, greatest = job.error_intervals["relative_mse"]
        >>> least < job.errors["relative_mse"] < greatest, len(job.reference_jobs)
        (True, 2)
        """
        return self.statistics.get("error") or {}

    @property
    def error_intervals(self) -> Dict[str, Interval]:
        """What the reference's noise leaves open of `errors`, at 90 %, by metric; empty where it was not measured by two
        films."""
        known = self.statistics.get("error_interval") or {}
        return {metric: Interval(*ends) for metric, ends in known.items() if ends is not None}

    @property
    def curve(self) -> List[CurvePoint]:
        """Error over time, so far; `intervals` of a point as `error_intervals`."""
        return cast(List[CurvePoint], self.data.get("curve") or [])

    @property
    def failure(self) -> Optional[Json]:
        """The problem that ended it."""
        return cast(Optional[Json], self.data.get("failure"))

    def refresh(self) -> "Job":
        self.data = self._client.get(self._path())
        return self

    # --- following it -------------------------------------------------------------------------------------------------
    def wait(self, timeout: Optional[float] = None, *, check: bool = True, cancel_on_interrupt: bool = False,
             on_event: Optional[Callable[["Job", Event], object]] = None, progress: "Progress[Job]" = None) -> "Job":
        """Until it is over, by the event stream, or by asking again where there is none. Raises TimedOut after `timeout`
        seconds (the job goes on), and with `check` JobFailed or JobCancelled. `on_event(job, event)` is called at each
        change. `progress`: True shows how far it is, a function is called with the job at each change; not said, it is shown
        in a notebook. Ctrl-C leaves the job running unless it is to be cancelled.

        >>> looks = []
        >>> job = client.submit("furnace", width=16, height=8, passes=4).wait(progress=lambda job: looks.append(job.state))
        >>> looks[-1]
        'succeeded'
        """
        show = shown(progress)
        try:
            for event in self.events(timeout):
                if on_event is not None:
                    on_event(self, event)
                if show is not None and not self.is_over:
                    show(self)
            if show is not None:
                show(self)
        except KeyboardInterrupt:
            if cancel_on_interrupt:
                self.cancel()
            raise
        if check:
            self.check()
        return self

    def check(self) -> "Job":
        """Raises JobFailed or JobCancelled where it is."""
        if self.state == "failed":
            raise JobFailed(self, self.failure)
        if self.state == "cancelled":
            raise JobCancelled(self)
        return self

    def events(self, timeout: Optional[float] = None) -> Iterator[Event]:
        """What happens to it until it is over, beginning with the state it is in; the job itself is kept up to date
        meanwhile. A broken stream is taken up where it broke.

        >>> job = client.submit("furnace", width=16, height=8, passes=4)
        >>> [event.changes["state"] for event in job.events() if event.kind == "state"][-1]
        'succeeded'
        """
        return _Follower(self._client, self, timeout).run()

    # --- changing it --------------------------------------------------------------------------------------------------
    def cancel(self) -> "Job":
        """What was rendered stays; a job that is over is left as it is."""
        self.data = self._client.send("DELETE", self._path())
        return self

    def purge(self) -> None:
        """Cancels it and removes it with its files."""
        self._client.send("DELETE", self._path(), query={"purge": True})

    def repeat(self) -> "Job":
        """The same request as a new job; one of a comparison in its place, where that was disturbed."""
        return Job(self._client, self._client.send("POST", self._path("/repeat"), safe=False))

    def retry(self) -> "Job":
        """Queues a failed or cancelled job again."""
        self.data = self._client.send("POST", self._path("/retry"), safe=False)
        return self

    def extend(self, *, passes: Optional[int] = None, seconds: Optional[float] = None,
               target: Any = None) -> "Job":
        """More passes on the same film, counted from its first: a job of 64 goes on with `passes=256`, to the same bits
        as 256 at once.

        >>> job = client.render("cornell-box", width=16, height=16, passes=2)
        >>> whole = client.render("cornell-box", width=16, height=16, passes=4)
        >>> job.extend(passes=4).wait().statistics["pixel_hash"] == whole.statistics["pixel_hash"]
        True
        """
        stop = stop_of(passes, seconds, target)
        if not stop:
            raise ValueError("until when? passes, seconds or target is needed; they count from the first pass")
        self.data = self._client.send("POST", self._path("/extend"), {"stop": stop}, safe=False)
        return self

    def reprioritise(self, priority: int) -> "Job":
        """-100 to 100, higher first; a running job keeps it for its next attempt. Raises WrongState when it is over."""
        self.data = self._client.send("PATCH", self._path(), {"priority": priority})
        return self

    # --- what it made -------------------------------------------------------------------------------------------------
    def pixels(self, layer: str = "beauty", *, precision: str = "float") -> Pixels:
        """One layer without numpy; while the job runs, of the film so far. Raises NothingYet before the first pass."""
        return self._pixels(layer, precision)

    def image(self, layer: str = "beauty", *, precision: str = "float"
              ) -> "numpy.typing.NDArray[numpy.floating[Any]]":
        """One layer as ndarray: height x width x 3, float32, linear light, the top row first; height x width for layers
        of one value."""
        return self.pixels(layer, precision=precision).array()

    def exr(self, path: Optional[Path] = None, *, precision: Optional[str] = None) -> bytes:
        """All layers; saved where a path is given, else returned. `precision` is float or half."""
        return self.download("image.exr", path, precision=precision)

    def preview(self, path: Optional[Path] = None, *, layer: Optional[str] = None, exposure: Optional[float] = None,
                curve: Optional[str] = None, max_size: Optional[int] = None) -> bytes:
        """A PNG for the eye: `exposure` in stops, `curve` srgb or filmic, `max_size` of its longer side."""
        return self.download("preview.png", path, layer=layer, exposure=exposure, curve=curve, max_size=max_size)

    def save(self, path: Path, **query: Any) -> pathlib.Path:
        """`exr` or `preview`, by what the path ends with.

        >>> client.render("furnace", width=8, height=8, passes=1).save(folder / "furnace.exr").name
        'furnace.exr'
        """
        path = pathlib.Path(path)
        if path.suffix.lower() == ".exr":
            self.exr(path, **query)
        elif path.suffix.lower() == ".png":
            self.preview(path, **query)
        else:
            raise ValueError(f"cannot tell what to save as {path}: name it .exr (all layers) or .png (preview)")
        return path

    def difference(self, path: Optional[Path] = None) -> bytes:
        """An EXR: the image less its reference, layer by layer."""
        return self.download("difference.exr", path)

    def flip(self, path: Optional[Path] = None, *, layer: Optional[str] = None, range: Optional[str] = None) -> bytes:
        """A PNG: the FLIP map against the reference; `range` is hdr or ldr."""
        return self.download("flip.png", path, layer=layer, range=range)

    def error_map(self, path: Optional[Path] = None, *, layer: Optional[str] = None) -> bytes:
        """A PNG: each pixel's relative error, on one scale for all jobs."""
        return self.download("error.png", path, layer=layer)

    def log(self) -> str:
        """What happened to it."""
        return self.download("log.txt").decode("utf-8", "replace")

    def describe(self) -> str:
        """One line: state, passes, time, error.

        >>> client.render("furnace", width=8, height=8, passes=2).describe()  # doctest: +ELLIPSIS
        'J... succeeded, 2/2 passes, ...s, estimated_relative_mse ...'
        """
        stop: Stop = cast(Stop, self.request.get("stop") or {})
        passes = stop.get("passes")
        of = f"{self.passes_done}/" if passes else ""
        words = [f"{self.id} {self.state}", of + counted(passes or self.passes_done, "pass", "passes"),
                 human_seconds(self.seconds)]
        error = self.data.get("error_now")
        if error and (error["value"] is not None or error.get("interval")):
            target = stop.get("target") or None
            goal = f", target {human_number(target['value'])}" if target else ""
            words.append(f"{error['metric']} {human_error(error['value'], error.get('interval'))}{goal}")
        return ", ".join(words)

    def __repr__(self) -> str:
        request = self.request
        image = request["image"]
        return (f"<Job {self.describe()}: {request['scene']} by {request['method']['name']}, "
                f"{image['width']} x {image['height']}>")

    def __str__(self) -> str:
        return "\n".join([repr(self), *([self.warning] if self.warning else [])])

    def _repr_png_(self) -> Optional[bytes]:
        try:
            return self.preview()
        except NothingYet:
            return None


class _Follower:
    """One run of `Job.events`."""

    def __init__(self, client: Daemon, job: Job, timeout: Optional[float]) -> None:
        self._client = client
        self._job = job
        self._timeout = timeout
        self._deadline = None if timeout is None else time.monotonic() + timeout
        self._parser = EventParser()
        self._events = 0

    def run(self) -> Iterator[Event]:
        job = self._job
        job.refresh()
        yield Event("state", None, {"id": job.id, "state": job.state})
        fruitless = 0
        while not job.is_over:
            before = self._events
            if fruitless < STREAM_TRIES:
                yield from self._stream()
            fruitless = 0 if self._events > before else fruitless + 1
            if job.is_over:
                job.refresh()  # the whole object; the last word over any event
            else:
                self._sleep(POLL_SECONDS)
                yield from self._look()

    def _remaining(self) -> float:
        if self._deadline is None:
            return SILENCE_SECONDS
        remaining = self._deadline - time.monotonic()
        if remaining <= 0:
            raise TimedOut(f"job {self._job.id} is {self._job.state} after {self._timeout:g} s; it goes on")
        return remaining

    def _sleep(self, seconds: float) -> None:
        time.sleep(min(seconds, self._remaining()))

    def _look(self) -> Iterator[Event]:
        """What a look at the job finds changed, as an event."""
        before = self._job.data
        now = self._job.refresh().data
        if now != before:
            changes = {key: value for key, value in now.items() if before.get(key) != value}
            yield Event("state" if "state" in changes else "progress", None, {"id": self._job.id, **changes})

    def _stream(self) -> Iterator[Event]:
        """One connection to the event stream, until the job is over or the connection is."""
        headers = {"Last-Event-ID": self._parser.last_event_id} if self._parser.last_event_id else {}
        self._parser.reconnect()
        try:
            stream = self._client.event_stream(self._job._path("/events"), headers, min(self._remaining(), SILENCE_SECONDS))
            if stream is None:
                return
            try:
                # The stream stands; what happened between the last look and now is not in it.
                yield from self._look()
                while not self._job.is_over:
                    data = stream.read(min(self._remaining(), SILENCE_SECONDS))
                    if not data:
                        return
                    for server_event in self._parser.feed(data):
                        event = parsed(server_event)
                        if event is not None:
                            self._take(event)
                            yield event
            finally:
                stream.close()
        except ConnectionLost:
            self._remaining()  # what fell silent may be the deadline

    def _take(self, event: Event) -> None:
        self._events += 1
        changes: Mapping[str, Any] = event.changes
        data = {**self._job.data, **changes}
        if event.kind == "curve":  # only the points that are new, of which a look may have shown some
            curve = self._job.curve
            last = curve[-1]["passes"] if curve else -1
            data["curve"] = curve + [point for point in changes.get("curve") or [] if point["passes"] > last]
        self._job.data = data


class JobFailed(WithProblem):
    """`job` came to its end without success. `problem` and `faults` say why."""

    def __init__(self, job: Job, problem: Optional[Mapping[str, Any]]) -> None:
        self.job = job
        problem = problem or {}
        why = str(problem.get("detail") or problem.get("title") or "no reason was given")
        super().__init__(f"job {job.id} failed: {why}", problem)


class JobCancelled(PhotondError):
    """`job` was cancelled; what it rendered stays."""

    def __init__(self, job: Job) -> None:
        self.job = job
        super().__init__(f"job {job.id} was cancelled after {job.passes_done} passes")
