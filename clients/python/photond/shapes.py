"""The JSON objects of the wire, as types. They say what the daemon of this version sends; a newer one may send more
fields, which stay in the dictionaries untouched. `GET /v1/openapi.json` is the whole truth."""

from __future__ import annotations

from typing import Any, Dict, List, Mapping, Optional, Sequence, TypedDict, Union

Json = Dict[str, Any]


class FaultShape(TypedDict):
    pointer: str
    detail: str


class Problem(TypedDict, total=False):
    """RFC 9457, application/problem+json."""

    type: str
    title: str
    status: int
    code: str
    detail: str
    instance: Optional[str]
    errors: List[FaultShape]


# --- what is asked for --------------------------------------------------------------------------------------------------


class Target(TypedDict):
    metric: str
    value: float


class Stop(TypedDict, total=False):
    """The first one met ends the job."""

    seconds: float
    passes: int
    target: Target


class JobMethod(TypedDict, total=False):
    name: str
    device: str
    parameters: Mapping[str, Any]


class MadeReference(TypedDict):
    """A reference rendered once, from the job's own scene and view, and kept by the daemon."""

    method: JobMethod
    stop: Stop


class LookAt(TypedDict, total=False):
    eye: Sequence[float]
    target: Sequence[float]
    up: Sequence[float]
    yfov: float


class Camera(TypedDict, total=False):
    """One of the scene's by `name`, or `look_at`."""

    name: str
    look_at: LookAt
    aperture: float
    focus_distance: float


class ImageRequest(TypedDict, total=False):
    width: int
    height: int
    filter: str


class Environment(TypedDict, total=False):
    image: str
    scale: float
    rotation: float


class _Rendered(TypedDict, total=False):
    scene: str
    camera: Camera
    image: ImageRequest
    stop: Stop
    layers: List[str]
    reference: Union[str, MadeReference]
    metrics: List[str]
    priority: int
    quiet_machine: Optional[float]
    labels: Dict[str, str]
    environment: Environment
    glass: str
    animation: Union[None, str, int]
    time: float
    shutter: float


class JobRequest(_Rendered, total=False):
    method: JobMethod
    first_pass: int
    seed: int


class Entry(TypedDict, total=False):
    """One row of a comparison, or as many as its sweep has combinations."""

    label: str
    method: JobMethod
    sweep: Mapping[str, Sequence[Any]]


class ComparisonRequest(_Rendered, total=False):
    entries: List[Entry]
    seeds: List[int]


class CameraKey(LookAt, total=False):
    time: float


class CameraPath(TypedDict, total=False):
    turns: float
    keys: List[CameraKey]


class SequenceRequest(JobRequest, total=False):
    frames: int
    to: float
    fps: float
    noise: str
    camera_path: CameraPath


# --- what is answered ---------------------------------------------------------------------------------------------------


# [least, greatest]: what the noise of two reference films leaves open of an error, at 90 %. What was measured by an older
# daemon, or against one film or image, has none.
Ends = List[float]


class Frame(TypedDict):
    """Of a sequence."""

    frame: int
    time: float
    id: str
    seed: int
    state: str
    progress: float
    seconds: float


class SequenceFigure(TypedDict):
    value: float
    interval: Ends


class SequenceFigures(TypedDict):
    """None of the first frame but its error."""

    relative_mse: Optional[SequenceFigure]
    flicker: Optional[SequenceFigure]
    lag: Optional[SequenceFigure]
    change: Optional[SequenceFigure]


class FrameErrors(SequenceFigures):
    frame: int
    time: float


class SequenceErrors(TypedDict):
    """Of the frames that have succeeded in all three sequences."""

    sequence: str
    references: List[str]
    layer: str
    frames: List[FrameErrors]
    mean: SequenceFigures
    frames_late: Optional[float]


class _CurvePoint(TypedDict):
    seconds: float
    passes: int
    photons: Optional[int]
    metrics: Optional[Dict[str, Optional[float]]]


class CurvePoint(_CurvePoint, total=False):
    intervals: Dict[str, Ends]


class _ErrorNow(TypedDict):
    metric: str
    value: Optional[float]


class ErrorNow(_ErrorNow, total=False):
    interval: Optional[Ends]


class Stage(TypedDict):
    name: str
    wall_seconds: Optional[float]
    cpu_seconds: Optional[float]
    gpu_seconds: Optional[float]


class LeftOut(TypedDict):
    """A kind of path that an image leaves out, and the same as a phrase; `most_bounces` of further_bounces alone."""

    kind: str
    text: str
    most_bounces: Optional[int]


class Statistics(TypedDict, total=False):
    stages: List[Stage]
    counts: Json
    rates: Dict[str, Optional[float]]
    memory: Json
    needs: Optional[Json]
    skipped: List[Json]
    left_out: Optional[List[LeftOut]]
    mergeable: Optional[bool]
    least_glossy_alpha: Optional[float]
    device: Json
    version: str
    host_cores: Optional[int]
    threads: Optional[int]
    seed: int
    clock: Optional[Json]
    job_hash: Optional[str]
    pixel_hash: Optional[str]
    nan_count: int
    infinity_count: int
    device_shared: Optional[bool]
    host_shared: Optional[bool]
    cores: Optional[Json]
    shared: Optional[Json]
    pass_ranges: List[List[int]]
    resumed_passes: int
    settings_hash: Optional[str]
    error: Optional[Json]
    error_interval: Optional[Dict[str, Optional[Ends]]]
    reference_error: Optional[Json]
    reference: Optional[Json]
    estimate: Optional[Json]


class JobSummary(TypedDict, total=False):
    """A light row of `GET /v1/jobs?view=summary`."""

    id: str
    role: str
    comparison: Optional[str]
    state: str
    progress: float
    passes_done: int
    seconds: float
    error_now: Optional[ErrorNow]
    created: str
    started: Optional[str]
    finished: Optional[str]
    scene: str
    method: str
    device: str
    width: int
    height: int
    priority: int
    labels: Dict[str, str]
    failure: Optional[str]


class _TimeToError(TypedDict):
    error: float
    seconds: Optional[float]
    low: Optional[float]
    high: Optional[float]
    reached: int
    at_most: bool


class TimeToError(_TimeToError, total=False):
    """`earliest`, `latest`: when the lower and when the upper end of the error's interval is there."""

    earliest: Optional[float]
    latest: Optional[float]


class _ErrorAtTime(TypedDict):
    seconds: float
    error: Optional[float]
    low: Optional[float]
    high: Optional[float]
    reached: int


class ErrorAtTime(_ErrorAtTime, total=False):
    interval: Optional[Ends]


class _FinalError(TypedDict):
    value: Optional[float]
    low: Optional[float]
    high: Optional[float]
    reference: Optional[float]
    near_reference: bool


class FinalError(_FinalError, total=False):
    interval: Optional[Ends]


class BiasAndVariance(TypedDict):
    """What the seeds of a row have in common (`squared_bias`), and what each has of its own (`variance`, of one film), by
    a metric that is a mean of squares. `low`, `high`: 90 %, by the seeds and the references' noise; of the variance by the seeds, null for two.
    `floor`: more passes do not go below the squared bias; else it is the one at these passes."""

    squared_bias: float
    low: float
    high: float
    variance: float
    variance_low: Optional[float]
    variance_high: Optional[float]
    floor: bool
    text: str


class WelchBlock(TypedDict):
    """Of a bias map: the mean of the seeds less the reference, relative to the reference."""

    difference: Optional[float]
    standard_error: Optional[float]
    degrees: Optional[float]
    p: Optional[float]
    found: bool


class WelchMap(TypedDict):
    """`bias.json` of a row. `block` is in pixels, `width` and `height` in blocks; blocks row by row from the top."""

    row: int
    label: str
    layer: str
    block: int
    width: int
    height: int
    seeds: int
    level: float
    blocks: List[WelchBlock]
    found: int
    heavy_tailed: bool
    text: str


class _TableRow(TypedDict):

    label: str
    parameters: Json
    jobs: List[str]
    seeds: int
    succeeded: int
    disturbed: int
    passes: Optional[Dict[str, int]]
    photons: Optional[Dict[str, int]]
    seconds: Optional[Dict[str, float]]
    error: Dict[str, FinalError]
    time_to_error: Dict[str, List[TimeToError]]
    error_at_time: Dict[str, List[ErrorAtTime]]
    peak_bytes: Optional[int]
    efficiency: Optional[float]
    pareto: bool


class TableRow(_TableRow, total=False):
    """A label and one combination of its sweep, over all seeds: `low` and `high` are of 95 % over the seeds, intervals of
    90 % by the reference's noise. `bias` is by metric; None of one seed, while it runs, and where the reference is not two
    films. `mark`: of a row that has light which the reference lacks."""

    bias: Optional[Dict[str, BiasAndVariance]]
    left_out: Optional[List[LeftOut]]
    mark: Optional[str]


class Measurement(TypedDict):
    metrics: Json
    intervals: Optional[Json]
    reference_error: Optional[Json]
    notes: List[str]


class Device(TypedDict, total=False):
    id: str
    kind: str
    name: Optional[str]
    driver: Optional[str]
    memory_bytes: Optional[int]
    software: Optional[bool]
    state: str
    served: bool
    lacks: List[str]
    limits: Optional[Json]


class Status(TypedDict, total=False):
    version: str
    uptime_seconds: float
    ready: bool
    queue: Dict[str, int]
    workers: List[Json]
    disk_free_bytes: Optional[int]
    totals: Json
