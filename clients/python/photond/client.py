"""The way in."""

from __future__ import annotations

import difflib
import functools
import inspect
from typing import (TYPE_CHECKING, Any, Callable, Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence,
                    Tuple, TypeVar, Union, cast)

from . import requests
from ._daemon import Daemon
from ._events import EventParser
from ._files import Path
from ._http import ConnectionLost, Query
from ._text import human_bytes, human_seconds
from .comparison import Comparison
from .errors import ProtocolError
from .job import SILENCE_SECONDS, STREAM_TRIES, Event, Job, parsed
from .methods import Methods
from .pixels import FlipMap, Pixels
from .requests import ComparisonSubmission, ImageLike, SequenceSubmission, Submission, image_name, random_key
from .scene import Scene, UploadedImage
from .sequence import Sequence as Frames
from .shapes import Device, JobSummary, Json, Measurement, Status

if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    P = ParamSpec("P")
R = TypeVar("R")
S = TypeVar("S")


class Estimate(NamedTuple):
    """What a job or comparison would take. `seconds` is None while the daemon has rendered nothing with the method."""

    memory_bytes: int
    device_memory_bytes: Optional[int]
    seconds: Optional[float]
    data: Json

    def __str__(self) -> str:
        device = f", and {human_bytes(self.device_memory_bytes)} of the GPU's" if self.device_memory_bytes else ""
        time = "not known" if self.seconds is None else human_seconds(self.seconds)
        return f"memory {human_bytes(self.memory_bytes)}{device}; time {time}"


OF_WAITING = ("timeout", "progress")


def _takes(build: "Callable[Concatenate[Client, P], S]", waits: bool = False
           ) -> "Callable[[Callable[[Client, S], R]], Callable[Concatenate[Client, P], R]]":
    """Makes a method of what takes a submission: its arguments are those that build it, without those of waiting where it
    does not wait. What is wrong with them is a TypeError of the method that was called."""

    def decorate(take: "Callable[[Client, S], R]") -> "Callable[Concatenate[Client, P], R]":
        parameters = _parameters_of(build, () if waits else OF_WAITING)

        @functools.wraps(take)
        def method(client: "Client", /, *arguments: "P.args", **named: "P.kwargs") -> R:
            _check_names(f"{take.__qualname__}()", list(parameters)[1:], named)
            try:
                signature.bind(client, *arguments, **named)
            except TypeError as error:
                raise TypeError(f"{take.__qualname__}(): {error}") from None
            return take(client, build(client, *arguments, **named))

        signature = inspect.Signature(list(parameters.values()), return_annotation=inspect.signature(take).return_annotation)
        method.__signature__ = signature  # type: ignore[attr-defined]
        method.__doc__ = f"{inspect.getdoc(take)}\n\n{inspect.getdoc(build)}"
        return method

    return decorate


def _parameters_of(build: Callable[..., Any], without: Sequence[str]) -> Dict[str, inspect.Parameter]:
    """By name, the client as `self`; in the place of **job stand those of a job that the function has not itself."""
    own = list(inspect.signature(build).parameters.values())
    if own[-1].kind is inspect.Parameter.VAR_KEYWORD:
        names = {parameter.name for parameter in own}
        of_a_job = inspect.signature(requests.job_request).parameters.values()
        own[-1:] = [parameter for parameter in of_a_job if parameter.name not in names]
    own[0] = own[0].replace(name="self", annotation=inspect.Parameter.empty)
    return {parameter.name: parameter for parameter in own if parameter.name not in without}


def _check_names(call: str, known: List[str], given: Mapping[str, Any]) -> None:
    for name, value in given.items():
        if name in known:
            continue
        near = difflib.get_close_matches(name, known, 1)
        hint = (f"did you mean {near[0]!r}?" if near else
                f"a method's own parameters are given as parameters={{{name!r}: {value!r}}}" if "parameters" in known else
                f"its arguments are {', '.join(known)}")
        raise TypeError(f"{call} has no argument {name!r}; {hint}")


class Client(Daemon):
    """A daemon to talk to. It may be used by several threads at once.

    url, token    default: PHOTOND_URL and PHOTOND_TOKEN, as photonctl has them; else http://127.0.0.1:8080 and none
    token_file    read the token from there
    retry_seconds how long failures that may pass are repeated: 429 and 503 after the Retry-After they name, lost
                  connections where repeating is harmless (submissions carry an Idempotency-Key), refused ones once the
                  daemon has been spoken to; 0: never
    tls           for https; default: the system's certificates

    >>> client.status()["ready"]
    True
    >>> sorted(client.methods)[:2]
    ['bidirectional_path_tracing', 'image_based_lighting']
    """

    @functools.cached_property
    def methods(self) -> Methods:
        """What the daemon renders with, by name."""
        return Methods(self)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Client {self.url}>"

    # --- the daemon -----------------------------------------------------------------------------------------------------
    def status(self) -> Status:
        """Version, uptime, queue, workers."""
        return cast(Status, self.get("/v1/status"))

    def devices(self) -> List[Device]:
        return cast(List[Device], self.get("/v1/devices")["items"])

    def metrics_text(self) -> str:
        """The daemon's own figures, as Prometheus reads them."""
        return self.download("/metrics").decode()

    def events(self) -> Iterator[Event]:
        """What happens to all jobs from now on, without end; a broken stream is taken up where it broke. Events of kind
        `status` are of the daemon, their `changes` what `status()` gives. Raises Unreachable when the daemon is gone for
        longer than is retried."""
        parser = EventParser()
        fruitless = 0
        while True:
            headers = {"Last-Event-ID": parser.last_event_id} if parser.last_event_id else {}
            parser.reconnect()
            fruitless += 1
            try:
                stream = self.event_stream("/v1/events", headers, SILENCE_SECONDS)
                if stream is None:
                    self.get("/v1/status")  # raises where the daemon refuses this client
                    if fruitless >= STREAM_TRIES:
                        raise ProtocolError("the daemon gives no event stream")
                else:
                    try:
                        while True:
                            data = stream.read(SILENCE_SECONDS)
                            if not data:
                                break
                            for server_event in parser.feed(data):
                                fruitless = 0
                                event = parsed(server_event)
                                if event is not None:
                                    yield event
                    finally:
                        stream.close()
            except ConnectionLost:
                pass
            self.get("/v1/status")  # waits for one that starts anew

    # --- scenes and images ----------------------------------------------------------------------------------------------
    def scenes(self, *, family: Optional[str] = None) -> List[Scene]:
        """Newest first; or the built-in scenes of a family, hard-cases, photon-splatting, details, caustics or progressive."""
        return [Scene(self, item) for item in self.items("/v1/scenes", {"family": family})]

    def scene(self, name: str) -> Scene:
        """By name or id."""
        return Scene.fetch(self, name)

    def upload_scene(self, path: Path, *, name: Optional[str] = None) -> Scene:
        """.glb, .zip, .gltf (with every file it refers to), or a folder that holds one. The same bytes give the same scene.

        >>> client.upload_scene(triangle_gltf, name="triangle").triangles  # a .gltf and its .bin
        1
        """
        return Scene.upload(self, path, name)

    def upload_image(self, path: Path) -> UploadedImage:
        """.exr or .hdr."""
        return UploadedImage.upload(self, path)

    def image(self, id: str) -> UploadedImage:
        return UploadedImage.fetch(self, id)

    def measure(self, image: ImageLike, reference: Union[ImageLike, Tuple[ImageLike, ImageLike]],
                metrics: Optional[Sequence[str]] = None) -> Measurement:
        """Errors of an image against another: a Job, an UploadedImage, a path, "job:J17" or "image:ID". Two references of
        different seeds, as a tuple, take their own noise out of mse, rmse and relative_mse, which then have `intervals`.

        >>> coarse = client.render("cornell-box", width=16, height=16, passes=1)
        >>> fine = client.render("cornell-box", width=16, height=16, passes=64, seed=2)
        >>> 0 < client.measure(coarse, fine, ["relative_mse"])["metrics"]["relative_mse"] < 10
        True
        >>> other = client.render("cornell-box", width=16, height=16, passes=64, seed=3)
        >>> answer = client.measure(coarse, (fine, other), ["relative_mse"])
        >>> least, greatest = answer["intervals"]["relative_mse"]
        >>> least < answer["metrics"]["relative_mse"] < greatest
        True
        """
        body: Json = {"image": image_name(self, image)}
        if isinstance(reference, tuple):
            body["references"] = [image_name(self, one) for one in reference]
        else:
            body["reference"] = image_name(self, reference)
        if metrics is not None:
            body["metrics"] = list(metrics)
        return cast(Measurement, self.send("POST", "/v1/metrics", body))

    def flip_map(self, image: ImageLike, reference: ImageLike, *, layer: str = "beauty", range: str = "hdr",
                 precision: str = "float") -> FlipMap:
        """The FLIP map of an image against another, each as `measure` takes them; `range` is hdr or ldr.

        >>> coarse = client.render("cornell-box", width=16, height=16, passes=1)
        >>> fine = client.render("cornell-box", width=16, height=16, passes=64, seed=2)
        >>> map = client.flip_map(coarse, fine)
        >>> bool(abs(map.pixels.array().mean() - map.mean) < 1e-4), client.flip_map(fine, fine).mean
        (True, 0.0)
        """
        reply = self.reply("/v1/flip", {"image": image_name(self, image), "reference": image_name(self, reference),
                                        "layer": layer, "range": range, "precision": precision})
        return FlipMap(Pixels.from_reply(reply.headers, reply.body, precision), float(reply.headers["x-flip-mean"]))

    # --- jobs -----------------------------------------------------------------------------------------------------------
    @_takes(requests.job_request)
    def submit(self, submission: Submission) -> Job:
        """Queues a render and returns at once; `.wait()` follows it.

        >>> job = client.submit("cornell-box", client.methods["photon_mapping"](gather="direct"), width=16, height=16,
        ...                     passes=2, labels={"study": "first"})
        >>> job.wait().state
        'succeeded'
        """
        return self._submit(submission)

    @_takes(requests.job_request, waits=True)
    def render(self, submission: Submission) -> Job:
        """Queues a render and waits for it. Raises JobFailed or JobCancelled, and TimedOut after `timeout` seconds; the job
        goes on then, and after Ctrl-C.

        >>> client.render("furnace", width=8, height=8, pases=1)
        Traceback (most recent call last):
            ...
        TypeError: Client.render() has no argument 'pases'; did you mean 'passes'?
        """
        return self._submit(submission).wait(submission.timeout, progress=submission.progress)

    @_takes(requests.job_request)
    def estimate(self, submission: Submission) -> Estimate:
        """Memory and time a job would take; nothing is queued, though files it needs are sent.

        >>> client.estimate("cornell-box", width=64, height=64, passes=16).memory_bytes > 2**20
        True
        """
        return _estimate(self.send("POST", "/v1/jobs", submission.body, query={"dry_run": True}))

    @_takes(requests.job_request)
    def job_request(self, submission: Submission) -> Json:
        """The body that `submit` would send, to look at or to keep; files it needs are sent."""
        return cast(Json, submission.body)

    def submit_request(self, body: Mapping[str, Any], *, idempotency_key: Optional[str] = None) -> Job:
        """Queues a job by its JSON, as another job's `request` or a file has it."""
        return self._submit(Submission(cast(Any, dict(body)), idempotency_key or random_key()))

    def _submit(self, submission: Submission) -> Job:
        return Job(self, self.send("POST", "/v1/jobs", submission.body,
                                   headers={"Idempotency-Key": submission.idempotency_key}))

    def job(self, id: str) -> Job:
        return Job.fetch(self, id)

    def jobs(self, *, state: Union[None, str, Sequence[str]] = None, label: Optional[str] = None,
             scene: Optional[str] = None, method: Optional[str] = None, device: Optional[str] = None,
             role: Optional[str] = None, limit: Optional[int] = None) -> Iterator[Job]:
        """Newest first, page by page as they are taken. `label` is "key=value"; `role` is render, reference or merged.

        >>> job = client.render("furnace", width=8, height=8, passes=1, labels={"study": "listed"})
        >>> [found.id for found in client.jobs(label="study=listed", state="succeeded")] == [job.id]
        True
        """
        query = _job_query(state, label, scene, method, device, role)
        return (Job(self, item) for item in self.items("/v1/jobs", query, limit))

    def job_summaries(self, *, state: Union[None, str, Sequence[str]] = None, label: Optional[str] = None,
                      scene: Optional[str] = None, method: Optional[str] = None, device: Optional[str] = None,
                      role: Optional[str] = None, limit: Optional[int] = None) -> Iterator[JobSummary]:
        """As `jobs`, but light rows: quick over a hundred thousand jobs."""
        query: Query = {**_job_query(state, label, scene, method, device, role), "view": "summary"}
        return (cast(JobSummary, item) for item in self.items("/v1/jobs", query, limit))

    def count_jobs(self, *, state: Union[None, str, Sequence[str]] = None, label: Optional[str] = None,
                   scene: Optional[str] = None, method: Optional[str] = None, device: Optional[str] = None,
                   role: Optional[str] = None) -> int:
        query: Query = {**_job_query(state, label, scene, method, device, role), "view": "summary", "limit": 1}
        return int(self.get("/v1/jobs", query)["total"])

    def merge(self, jobs: Iterable[Union[str, Job]], *, idempotency_key: Optional[str] = None) -> Job:
        """One job of all the passes of several that differ in their passes only (`first_pass`): the same bits as one job
        with all.

        >>> parts = [client.render("cornell-box", width=16, height=16, passes=2, first_pass=first) for first in (0, 2)]
        >>> whole = client.render("cornell-box", width=16, height=16, passes=4)
        >>> client.merge(parts).wait().statistics["pixel_hash"] == whole.statistics["pixel_hash"]
        True
        """
        body = {"jobs": [job.id if isinstance(job, Job) else job for job in jobs]}
        return Job(self, self.send("POST", "/v1/jobs/merge", body,
                                   headers={"Idempotency-Key": idempotency_key or random_key()}))

    # --- comparisons ----------------------------------------------------------------------------------------------------
    @_takes(requests.comparison_request)
    def submit_comparison(self, submission: ComparisonSubmission) -> Comparison:
        """Queues a comparison and all its jobs and returns at once; `.wait()` follows it."""
        return self._submit_comparison(submission)

    @_takes(requests.comparison_request, waits=True)
    def compare(self, submission: ComparisonSubmission) -> Comparison:
        """Which method reaches which error first: renders with each, one job at a time on a device, and measures. Raises
        ComparisonFailed, and TimedOut after `timeout` seconds; it goes on then, and after Ctrl-C."""
        return self._submit_comparison(submission).wait(submission.timeout, progress=submission.progress)

    @_takes(requests.comparison_request)
    def estimate_comparison(self, submission: ComparisonSubmission) -> Estimate:
        """What it would take; `data` has it entry by entry. Nothing is queued, though files it needs are sent."""
        return _estimate(self.send("POST", "/v1/comparisons", submission.body, query={"dry_run": True}))

    @_takes(requests.comparison_request)
    def comparison_request(self, submission: ComparisonSubmission) -> Json:
        """The body that `submit_comparison` would send; files it needs are sent."""
        return cast(Json, submission.body)

    def _submit_comparison(self, submission: ComparisonSubmission) -> Comparison:
        return Comparison(self, self.send("POST", "/v1/comparisons", submission.body,
                                          headers={"Idempotency-Key": submission.idempotency_key}))

    def comparison(self, id: str) -> Comparison:
        return Comparison.fetch(self, id)

    def comparisons(self, *, limit: Optional[int] = None) -> Iterator[Comparison]:
        """Newest first."""
        return (Comparison(self, item) for item in self.items("/v1/comparisons", None, limit))


    # --- sequences ------------------------------------------------------------------------------------------------------
    @_takes(requests.sequence_request)
    def submit_sequence(self, submission: SequenceSubmission) -> Frames:
        """Queues a sequence and all its frames and returns at once; `.wait()` follows it."""
        return self._submit_sequence(submission)

    @_takes(requests.sequence_request, waits=True)
    def sequence(self, submission: SequenceSubmission) -> Frames:
        """Renders frames of a moving scene, or along a path of the camera. Raises SequenceFailed, and TimedOut after
        `timeout` seconds; it goes on then, and after Ctrl-C."""
        return self._submit_sequence(submission).wait(submission.timeout, progress=submission.progress)

    def _submit_sequence(self, submission: SequenceSubmission) -> Frames:
        return Frames(self, self.send("POST", "/v1/sequences", submission.body,
                                      headers={"Idempotency-Key": submission.idempotency_key}))

    def sequences(self, *, limit: Optional[int] = None) -> Iterator[Frames]:
        """Newest first."""
        return (Frames(self, item) for item in self.items("/v1/sequences", None, limit))


def _estimate(data: Json) -> Estimate:
    return Estimate(data["memory_bytes"], data.get("device_memory_bytes"), data["seconds"], data)


def _job_query(state: Union[None, str, Sequence[str]], label: Optional[str], scene: Optional[str], method: Optional[str],
               device: Optional[str], role: Optional[str]) -> Dict[str, Optional[str]]:
    states = state if state is None or isinstance(state, str) else ",".join(state)
    return {"state": states, "label": label, "scene": scene, "method": method, "device": device, "role": role}
