"""What is asked of the daemon, built from Python's arguments."""

from __future__ import annotations

import os
import uuid
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union, cast

from ._daemon import Daemon
from ._files import IMAGE_SUFFIXES, looks_like_scene_path
from .job import Job
from .methods import Method
from .progress import Progress
from .scene import Scene, UploadedImage
from .shapes import (Camera, CameraKey, ComparisonRequest, Entry, Environment, JobMethod, JobRequest, LookAt, MadeReference,
                     SequenceRequest, Stop)
from .work import TargetLike, stop_of

SceneLike = Union[str, "os.PathLike[str]", Scene]
ImageLike = Union[str, "os.PathLike[str]", Job, UploadedImage]
MethodLike = Union[str, Method, JobMethod]
ReferenceLike = Union[ImageLike, MadeReference]
EntryLike = Union[str, Method, Entry]

DEFAULT_PASSES = 64


class Submission(NamedTuple):
    """A job's body and the key by which a repeat of it is known."""

    body: JobRequest
    idempotency_key: str
    timeout: Optional[float] = None
    progress: Progress[Any] = None


class ComparisonSubmission(NamedTuple):
    body: ComparisonRequest
    idempotency_key: str
    timeout: Optional[float] = None
    progress: Progress[Any] = None


class SequenceSubmission(NamedTuple):
    body: SequenceRequest
    idempotency_key: str
    timeout: Optional[float] = None
    progress: Progress[Any] = None


def random_key() -> str:
    """128 random bits: a repeat of this submission, and nothing else, will carry them."""
    return f"photond-python-{uuid.uuid4().hex}"


# --- pieces -------------------------------------------------------------------------------------------------------------


def look_at(eye: Sequence[float], target: Sequence[float], *, up: Optional[Sequence[float]] = None,
            yfov: Optional[float] = None, aperture: Optional[float] = None,
            focus_distance: Optional[float] = None) -> Camera:
    """A camera of one's own, in metres and radians.

    >>> look_at([0, 1, 5], [0, 1, 0], yfov=0.7)
    {'look_at': {'eye': [0, 1, 5], 'target': [0, 1, 0], 'yfov': 0.7}}
    """
    view: LookAt = {"eye": list(eye), "target": list(target)}
    if up is not None:
        view["up"] = list(up)
    if yfov is not None:
        view["yfov"] = yfov
    camera: Camera = {"look_at": view}
    if aperture is not None:
        camera["aperture"] = aperture
    if focus_distance is not None:
        camera["focus_distance"] = focus_distance
    return camera


def reference(method: MethodLike, *, passes: Optional[int] = None, seconds: Optional[float] = None,
              target: Optional[TargetLike] = None, device: Optional[str] = None,
              parameters: Optional[Mapping[str, Any]] = None) -> MadeReference:
    """A reference that the daemon renders once, from the job's own scene and view, and keeps.

    >>> reference("path_tracing", passes=256)
    {'method': {'name': 'path_tracing'}, 'stop': {'passes': 256}}
    """
    stop = stop_of(passes, seconds, target)
    if not stop:
        raise ValueError("a reference needs passes, seconds or target")
    return {"method": method_of(method, device, parameters), "stop": stop}


def entry(method: MethodLike, label: Optional[str] = None, *, device: Optional[str] = None,
          parameters: Optional[Mapping[str, Any]] = None, sweep: Optional[Mapping[str, Sequence[Any]]] = None) -> Entry:
    """One row of a comparison; with `sweep` a row for every combination of its values.

    >>> entry("photon_mapping", "few and many", sweep={"photons": [5000, 50000]})
    {'method': {'name': 'photon_mapping'}, 'label': 'few and many', 'sweep': {'photons': [5000, 50000]}}
    """
    row: Entry = {"method": method_of(method, device, parameters)}
    if label is not None:
        row["label"] = label
    if sweep is not None:
        row["sweep"] = {name: list(values) for name, values in sweep.items()}
    return row


def method_of(method: MethodLike, device: Optional[str], parameters: Optional[Mapping[str, Any]]) -> JobMethod:
    if isinstance(method, str):
        body: JobMethod = {"name": method}
    elif isinstance(method, Method):
        body = method()
    else:
        body = cast(JobMethod, dict(method))
    if device is not None:
        body["device"] = device
    if parameters:
        body["parameters"] = {**body.get("parameters", {}), **parameters}
    return body


def image_name(client: Daemon, image: ImageLike) -> str:
    """As the daemon names it: "job:J17" or "image:ID"; a path is uploaded, a bare name is a job's."""
    if isinstance(image, Job):
        return f"job:{image.id}"
    if isinstance(image, UploadedImage):
        return f"image:{image.id}"
    if not isinstance(image, str) or image.lower().endswith(tuple(IMAGE_SUFFIXES)):
        return f"image:{UploadedImage.upload(client, image).id}"
    return image if image.startswith(("job:", "image:")) else f"job:{image}"


def _reference_of(client: Daemon, value: ReferenceLike) -> Union[str, MadeReference]:
    if isinstance(value, Mapping):
        return cast(MadeReference, value)
    if isinstance(value, str) and not value.startswith(("job:", "image:")):
        name, colon, passes = value.rpartition(":")
        if colon and passes.isdigit():
            return reference(name, passes=int(passes))
    return image_name(client, value)


def _scene_of(client: Daemon, scene: SceneLike) -> str:
    if isinstance(scene, Scene):
        return scene.id
    if isinstance(scene, str) and not looks_like_scene_path(scene):
        return scene
    return Scene.upload(client, scene).id


def _environment_of(client: Daemon, value: Union[ImageLike, Mapping[str, Any]]) -> Environment:
    if isinstance(value, Mapping):
        named = {"image": image_name(client, value["image"])} if "image" in value else {}
        return cast(Environment, {**value, **named})
    return {"image": image_name(client, value)}


def _rendered(client: Daemon, scene: SceneLike, width: int, height: int, filter: Optional[str], stop: Stop,
              layers: Optional[Sequence[str]], camera: Union[None, str, Camera],
              environment: Union[None, ImageLike, Mapping[str, Any]], glass: Optional[str],
              animation: Union[None, str, int], time: Optional[float],
              shutter: Optional[float],
              reference: Optional[ReferenceLike], metrics: Optional[Sequence[str]], priority: Optional[int],
              labels: Optional[Mapping[str, str]], quiet_machine: Optional[float]) -> Dict[str, Any]:
    """What jobs and comparisons both say. What is not said is not sent: the daemon's default is then meant."""
    body: Dict[str, Any] = {"scene": _scene_of(client, scene), "image": {"width": width, "height": height}, "stop": stop}
    if filter is not None:
        body["image"]["filter"] = filter
    if camera is not None:
        body["camera"] = {"name": camera} if isinstance(camera, str) else camera
    if environment is not None:
        body["environment"] = _environment_of(client, environment)
    if reference is not None:
        body["reference"] = _reference_of(client, reference)
    for key, value in (("glass", glass), ("animation", animation), ("time", time), ("shutter", shutter),
                       ("priority", priority), ("quiet_machine", quiet_machine)):
        if value is not None:
            body[key] = value
    for key, names in (("layers", layers), ("metrics", metrics)):
        if names is not None:
            body[key] = _names(key, names)
    if labels is not None:
        body["labels"] = dict(labels)
    return body


def _names(key: str, names: Sequence[str]) -> List[str]:
    if isinstance(names, str):
        raise TypeError(f"{key} is a list of names, as [{names!r}]")
    return list(names)


# --- whole bodies -------------------------------------------------------------------------------------------------------


def job_request(client: Daemon, scene: SceneLike, method: MethodLike = "path_tracing", *,
                device: Optional[str] = None, parameters: Optional[Mapping[str, Any]] = None, width: int = 512,
                height: int = 512, filter: Optional[str] = None, passes: Optional[int] = None,
                seconds: Optional[float] = None, target: Optional[TargetLike] = None, first_pass: Optional[int] = None,
                seed: Optional[int] = None, layers: Optional[Sequence[str]] = None,
                camera: Union[None, str, Camera] = None,
                environment: Union[None, ImageLike, Mapping[str, Any]] = None, glass: Optional[str] = None,
                animation: Union[None, str, int] = None, time: Optional[float] = None,
                shutter: Optional[float] = None, reference: Optional[ReferenceLike] = None,
                metrics: Optional[Sequence[str]] = None, priority: Optional[int] = None,
                labels: Optional[Mapping[str, str]] = None, quiet_machine: Optional[float] = None,
                idempotency_key: Optional[str] = None, timeout: Optional[float] = None,
                progress: Progress[Any] = None) -> Submission:
    """
    scene        a Scene, its name or id, or a path (.glb, .zip, .gltf with its files, a folder), which is uploaded
    method       name, `client.methods[name]`, or that called with parameters; `device` and `parameters` add to it
    passes, seconds, target    the first one met ends the job; default: 64 passes. target: ("relative_mse", 0.001)
    layers       more layers, as ["albedo", "depth"]
    camera       name of one of the scene's, or `look_at(...)`; default: its first
    environment  light all around: a path, an UploadedImage, or {"image": ..., "scale": 1, "rotation": 0}
    animation    name or index of one of the scene's (`scene.motion`), at its moment `time`, seconds; default: at rest, or,
                 with a time, the first; `shutter`: seconds that it stays open from then on
    reference    what the error is measured against: a Job, an UploadedImage, a path, "path_tracing:4096" or
                 `reference(...)`; `metrics` are measured besides those that cost little
    first_pass   for one part of a larger job, see `Client.merge`
    quiet_machine    seconds to wait at most until nothing else runs on the daemon's machine
    idempotency_key    the same key and request is the same submission; default: random
    timeout, progress    of what waits (`render`): seconds, and True or a function that is called with the job at each change;
                 progress not said is shown in a notebook
    """
    body = _rendered(client, scene, width, height, filter, stop_of(passes, seconds, target) or {"passes": DEFAULT_PASSES},
                     layers, camera, environment, glass, animation, time, shutter, reference, metrics, priority, labels, quiet_machine)
    body["method"] = method_of(method, device, parameters)
    if first_pass is not None:
        body["first_pass"] = first_pass
    if seed is not None:
        body["seed"] = seed
    return Submission(cast(JobRequest, body), idempotency_key or random_key(), timeout, progress)


def sequence_request(client: Daemon, /, scene: SceneLike, method: MethodLike = "path_tracing", *,
                     frames: Optional[int] = None, to: Optional[float] = None, start: Optional[float] = None,
                     fps: Optional[float] = None, turns: Optional[float] = None,
                     keys: Optional[Sequence[CameraKey]] = None, noise: Optional[str] = None, **job: Any
                     ) -> SequenceSubmission:
    """
    frames, to   how many frames, or the moment after which none comes, seconds; the first is at `start` (0), and `fps`
                 (24) of them make a second
    turns        so often the eye goes round `camera`'s target; keys: or views at times that it passes by,
                 {"time": 0, "eye": ..., "target": ...}
    noise        "fresh" (a seed of its own for each frame) or "still"
    The rest is as for a job, see `Client.submit`; but its frames have times of their own, and all their passes.
    """
    for name in ("time", "first_pass"):
        if job.get(name) is not None:
            raise TypeError(f"{name}={job[name]!r} is of one image: the frames of a sequence have times of their own (start, "
                            "fps, and frames or to), and all their passes")
    single = job_request(client, scene, method, **job)
    body: Dict[str, Any] = dict(single.body)
    for key, value in (("frames", frames), ("to", to), ("from", start), ("fps", fps), ("noise", noise)):
        if value is not None:
            body[key] = value
    if turns is not None:
        body["camera_path"] = {"turns": turns}
    elif keys is not None:
        body["camera_path"] = {"keys": list(keys)}
    return SequenceSubmission(cast(SequenceRequest, body), *single[1:])


def comparison_request(client: Daemon, scene: SceneLike, entries: Sequence[EntryLike], *, width: int = 512,
                       height: int = 512, filter: Optional[str] = None, passes: Optional[int] = None,
                       seconds: Optional[float] = None, target: Optional[TargetLike] = None,
                       seeds: Optional[Sequence[int]] = None, layers: Optional[Sequence[str]] = None,
                       camera: Union[None, str, Camera] = None,
                       environment: Union[None, ImageLike, Mapping[str, Any]] = None, glass: Optional[str] = None,
                       animation: Union[None, str, int] = None, time: Optional[float] = None,
                shutter: Optional[float] = None, reference: Optional[ReferenceLike] = None,
                       metrics: Optional[Sequence[str]] = None, priority: Optional[int] = None,
                       labels: Optional[Mapping[str, str]] = None, quiet_machine: Optional[float] = None,
                       idempotency_key: Optional[str] = None, timeout: Optional[float] = None,
                       progress: Progress[Any] = None) -> ComparisonSubmission:
    """
    entries      rows of the tables: method names, `client.methods[...]`, or `entry(...)` with label and sweep
    seeds        repeat every job with each of these, for 95 % intervals
    passes, seconds, target    the first one met ends each job
    The rest is as for a job, see `Client.submit`.
    """
    if isinstance(entries, str):
        raise TypeError(f"entries is a list, as [{entries!r}]")
    rows = [entry(row) if isinstance(row, (str, Method)) else row for row in entries]
    body = _rendered(client, scene, width, height, filter, stop_of(passes, seconds, target), layers, camera, environment,
                     glass, animation, time, shutter, reference, metrics, priority, labels, quiet_machine)
    body["entries"] = rows
    if seeds is not None:
        body["seeds"] = list(seeds)
    return ComparisonSubmission(cast(ComparisonRequest, body), idempotency_key or random_key(), timeout, progress)


__all__ = ["entry", "look_at", "reference"]
