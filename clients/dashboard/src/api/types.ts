// The shapes of the HTTP API that the dashboard reads and writes: protocol.md, "Shapes". The daemon's /v1/openapi.json has them all.
// A field that does not apply is null.

export type JobState = "queued" | "running" | "succeeded" | "failed" | "cancelled";
export type JobRole = "render" | "reference" | "merged" | "frame";
export const kJobStates: readonly JobState[] = ["queued", "running", "succeeded", "failed", "cancelled"];
export const isOver = (state: JobState): boolean => state !== "queued" && state !== "running";

export type Json = null | boolean | number | string | Json[] | { [key: string]: Json };
export type Parameters = Record<string, Json>;
/** Error by metric's name ("relative_mse", "indirect:flip_hdr"); null where it cannot be told. */
export type Metrics = Record<string, number | null>;
export type Vec3 = [number, number, number];
/** Of an error measured by two films: what their noise leaves open, at 90 %. Results of before have none. */
export type NoiseInterval = [least: number, greatest: number];
/** What a reference is: its noise has no part in errors against two films. */
export type ReferenceForm = "two_films" | "film" | "image";

export interface Page<T> {
  items: T[];
  next_cursor: string | null;
}

export interface LookAt {
  eye: Vec3;
  target: Vec3;
  up?: Vec3;
  /** Vertical field of view, radians. */
  yfov?: number;
}

export interface StopConditions {
  seconds?: number | null;
  passes?: number | null;
  target?: { metric: string; value: number } | null;
}

export interface MethodChoice {
  name: string;
  device?: string;
  parameters?: Parameters;
}

/** What names pixels to compare with: a job, an uploaded image, or a method to render it by. */
export type Reference = string | { method: MethodChoice; stop: StopConditions };

export interface JobRequest {
  scene: string;
  camera?: { name?: string; look_at?: LookAt; aperture?: number; focus_distance?: number } | null;
  image: { width: number; height: number; filter?: string };
  method: MethodChoice;
  stop: StopConditions;
  seed?: number;
  layers?: string[];
  metrics?: string[];
  reference?: Reference | null;
  priority?: number;
  labels?: Record<string, string>;
  environment?: { image: string; scale?: number; rotation?: number } | null;
  /** By name or index; none: the scene as it rests, or, where a time or a shutter is given, its first. */
  animation?: string | number | null;
  /** Of the animation, seconds. */
  time?: number;
  /** How long it stays open from then on, seconds. */
  shutter?: number;
  [more: string]: unknown;
}

export interface CurvePoint {
  seconds: number;
  passes: number;
  photons: number | null;
  metrics: Metrics;
  /** By metric, where it is known. */
  intervals?: Record<string, NoiseInterval>;
}

export interface ErrorNow {
  metric: string;
  value: number | null;
  interval?: NoiseInterval | null;
}

export interface Attempt {
  attempt: number;
  device: string;
  started: string;
  finished: string | null;
  outcome: string;
  reason: string | null;
  passes_done: number | null;
  device_shared?: boolean;
  host_shared?: boolean;
}

export interface Fault {
  pointer: string;
  detail: string;
}

export interface ProblemBody {
  type: string;
  title: string;
  status: number;
  detail: string;
  instance?: string;
  errors?: Fault[];
}

export interface Stage {
  name: string;
  wall_seconds: number;
  cpu_seconds: number | null;
  gpu_seconds: number | null;
}

/** Where other processes took a part of the processor time that a job wanted. */
export interface Shared {
  /** Which it had, 0..1. */
  share: number;
  lost_seconds: number;
  /** By which its clock is too long, at most. */
  clock_seconds: number;
  /** The greatest first. */
  to: { who: string; seconds: number }[];
  /** The same as a sentence. */
  warning: string;
}

/** A kind of path that an image leaves out. */
export interface LeftOut {
  kind: string;
  /** The same as a phrase. */
  text: string;
  /** Of further bounces: paths of more are left out. */
  most_bounces: number | null;
}

export interface Statistics {
  stages: Stage[];
  counts: { rays: Record<string, number>; [name: string]: number | null | Record<string, number> };
  rates: Record<string, number | null>;
  memory: {
    structures: Record<string, number>;
    accounted_bytes: number;
    baseline_resident_bytes: number | null;
    peak_resident_bytes: number | null;
    peak_device_bytes: number | null;
  };
  needs: Record<string, Json>;
  skipped: string[];
  /** Results of before do not say. */
  left_out?: LeftOut[] | null;
  device: string;
  version: string;
  host_cores: number;
  threads: number;
  seed: number;
  job_hash: string;
  pixel_hash: string;
  nan_count: number;
  infinity_count: number;
  device_shared: boolean | null;
  /** Null where it was not disturbed; jobs of before do not say. */
  shared?: Shared | null;
  error: Metrics | null;
  error_interval?: Record<string, NoiseInterval | null> | null;
  reference_error: Metrics | null;
  reference?: ReferenceFacts | null;
  [more: string]: unknown;
}

/** What a job was measured against, and how. */
export interface ReferenceFacts {
  /** Of what was measured before there were two films: none. */
  form?: ReferenceForm;
  /** Of the intervals: 0.9. */
  confidence?: number | null;
  /** What a relative metric divides by: the reference's pixel, or its neighbours where the pixel itself is too noisy. */
  denominators?: Record<string, "pixel" | "neighbours">;
  /** Of the reference. */
  passes: number | null;
  warnings: string[];
  notes: string[];
}

/** What a job and its row in a list have in common. */
export interface JobProgress {
  id: string;
  role: JobRole;
  comparison: string | null;
  state: JobState;
  /** 0..1 */
  progress: number;
  passes_done: number;
  /** Of rendering. */
  seconds: number;
  error_now: ErrorNow | null;
  created: string;
  started: string | null;
  finished: string | null;
}

export interface Job extends JobProgress {
  reference_job: string | null;
  /** That job, and the other film where it is one of two. */
  reference_jobs?: string[] | null;
  /** What keeps it back when its turn has come, while it is queued. */
  waiting_for?: string | null;
  attempts: Attempt[];
  request: JobRequest & { method: Required<MethodChoice>; seed: number; priority: number; labels: Record<string, string>; layers: string[] };
  links: Record<string, string | null>;
  statistics: Statistics | null;
  failure: ProblemBody | null;
  curve: CurvePoint[] | null;
}

/** A row of `GET /v1/jobs?view=summary`. */
export interface JobSummary extends JobProgress {
  scene: string;
  method: string;
  device: string;
  width: number;
  height: number;
  priority: number;
  labels: Record<string, string>;
  /** The job, its reference, that must be over before this one begins. */
  waits_for: string | null;
  /** What keeps it back when its turn has come. */
  waiting_for?: string | null;
  failure: string | null;
}

export interface JobSummaryPage extends Page<JobSummary> {
  /** Of all jobs that match the filter. */
  total: number;
}

/** The data of an event of `/v1/events`: fields of the job that changed, and its id. */
export type JobChange = Partial<Omit<Job, "id">> & { id: string; priority?: number };

/** What bounds the files that a process may open. */
export type FileAccess = { by: "landlock" | "mount_namespace" | "none"; version: number | null } | null;

export interface WorkerStatus {
  device: string;
  device_name: string | null;
  state: string;
  pid: number | null;
  job: string | null;
  restarts: number;
  resident_bytes: number | null;
  memory_limit_bytes: number | null;
  file_access: FileAccess;
}

export interface DaemonStatus {
  version: string;
  uptime_seconds: number;
  ready: boolean;
  queue: { queued: number; running: number };
  workers: WorkerStatus[];
  helpers: {
    name: "answers" | "bulk";
    state: "ready" | "busy" | "failed";
    busy_seconds: number | null;
    pid: number | null;
    restarts: number;
    resident_bytes: number;
    file_access: FileAccess;
  }[];
  pictures: { waiting: number; pid: number | null; restarts: number; resident_bytes: number; file_access: FileAccess };
  store: {
    id: string;
    bytes: number;
    recovered: boolean;
    check: { state: "waiting" | "running" | "ok" | "damaged" | "failed"; detail: string | null };
    quarantine: { files: number; bytes: number };
  };
  disk_free_bytes: number;
  resident_bytes: number | null;
  event_clients: number;
  /** Since the daemon started. */
  totals: {
    jobs: Record<"succeeded" | "failed" | "cancelled", number>;
    passes: number;
    rays: Record<string, number>;
    photons: number;
    render_seconds: number;
    pixels: number;
  };
}

export interface Device {
  id: string;
  kind: string;
  name: string;
  driver: string | null;
  memory_bytes: number | null;
  software: boolean;
  state: "ready" | "busy" | "failed";
  served?: boolean;
}

export type ParameterType = "number" | "integer" | "boolean" | "string";

/** JSON Schema of one parameter of a method (protocol/param_json.h writes it). */
export interface ParameterSchema {
  /** With "null" beside it where it may be left open. */
  type: ParameterType | (ParameterType | "null")[];
  default?: Json;
  minimum?: number;
  maximum?: number;
  enum?: string[];
  description?: string;
  "x-unit"?: string;
  /** The title of the group that a form shows it in. */
  "x-group"?: string;
}

export interface Method {
  name: string;
  title: string;
  /** What it does, where it is good and where it is not. */
  line?: string;
  family: string;
  devices: string[];
  sources: string[];
  mergeable: boolean;
  deterministic: Record<string, boolean>;
  parameters: { type: "object"; properties: Record<string, ParameterSchema>; "x-order"?: string[]; "x-groups"?: string[] };
  layers?: string[];
  [more: string]: unknown;
}

/** A row of `GET /v1/layers`. */
export interface Layer {
  name: string;
  /** "RGB", "XYZ", "Y", "Z" */
  channels: string;
  always: boolean;
  measured: boolean;
  /** How /preview.png shows it; null: it is numbers to look at closely. */
  preview: "light" | "heat_map" | "directions" | "dots" | "scale" | "signed" | null;
  /** Exposure and tone curve change its preview. */
  exposure: boolean;
  /** Empty for plain numbers. */
  unit: string;
  description: string;
}

/** A row of `GET /v1/metrics`. */
export interface Metric {
  name: string;
  /** For tables. */
  title: string;
  /** 1: a number; 3: one a channel; 4: percentiles. */
  values: number;
  needs_reference: boolean;
  /** Measured only where a job names it. */
  on_request: boolean;
  /** Where the error is nothing but independent noise it falls with the passes to this power; null: no law says how. */
  slope: number | null;
  description: string;
  /** What the usual ones are, in plain words; null of the others. */
  line: string | null;
}

/** One of a scene's animations. */
export interface SceneAnimation {
  index: number;
  name: string;
  duration_seconds: number;
  moves: { meshes: number; triangles: number; cameras: number; lights: number; materials: number };
}

export interface SceneCamera {
  name: string;
  /** Radians; null for an orthographic one. */
  yfov: number | null;
  /** Width over height of the image that its file asks for. */
  aspect: number | null;
  look_at: Required<LookAt> | null;
}

/** What a hard case's image must be. */
export interface KnownAnswer {
  case: string;
  strains: string;
  text: string;
  [more: string]: unknown;
}

/** Figures are null where a scene could not be judged. */
export interface Scene {
  id: string;
  name: string;
  bytes: number | null;
  /** About what it takes in a worker. */
  memory_bytes: number | null;
  triangles: number | null;
  vertices: number | null;
  materials: number | null;
  textures: number | null;
  lights: { area: number; punctual: number; environment: boolean } | null;
  cameras: SceneCamera[];
  default_view: Required<LookAt>;
  animations: number | null;
  /** Null of scenes of an earlier version. */
  motion?: SceneAnimation[] | null;
  bounds: { min: Vec3; max: Vec3 } | null;
  needs: Record<string, boolean> | null;
  warnings: string[];
  builtin: boolean;
  known_answer: KnownAnswer | null;
  [more: string]: unknown;
}

export interface ImageInfo {
  id: string;
  media_type: string;
  width: number;
  height: number;
  channels: number | string[];
  bytes: number;
  layers: { name: string; channels: number }[];
}

export interface ComparisonEntry {
  label?: string;
  method: MethodChoice;
  sweep?: Record<string, Json[]> | null;
}

export interface ComparisonRequest {
  scene: string;
  camera?: JobRequest["camera"];
  image: { width: number; height: number; filter?: string };
  reference?: Reference | null;
  entries: ComparisonEntry[];
  stop: StopConditions;
  metrics?: string[] | null;
  seeds?: number[] | null;
  layers?: string[] | null;
  environment?: JobRequest["environment"];
  title?: string | null;
  notes?: string | null;
  [more: string]: unknown;
}

/** 95 % of the mean over the seeds; null with one seed. */
export interface Interval {
  low: number | null;
  high: number | null;
}

export interface TimeToError extends Interval {
  error: number;
  /** null where not every seed reaches it. */
  seconds: number | null;
  reached: number;
  /** Some seed was there at its first measurement: the time is an upper bound. */
  at_most: boolean;
  /** When the lower end of the error's interval is there, and when the upper one: what the references' noise leaves open. */
  earliest?: number | null;
  latest?: number | null;
}

export interface ErrorAtTime extends Interval {
  seconds: number;
  error: number | null;
  reached: number;
  interval?: NoiseInterval | null;
}

export interface FinalError extends Interval {
  value: number | null;
  /** The reference's own noise. */
  reference: number | null;
  /** Of what has an interval: that is wider than two thirds of the value. Of what has none: noise of the reference is a part of it. */
  near_reference: boolean;
  /** Of the mean over the seeds. */
  interval?: NoiseInterval | null;
}

/** What seeds have in common, and what is each one's own: by a metric that is a mean of squares. Intervals of 90 %. */
export interface BiasAndVariance {
  squared_bias: number;
  low: number;
  high: number;
  variance: number;
  variance_low: number | null;
  variance_high: number | null;
  /** More passes do not go below the squared bias; else it is the one at these passes. */
  floor: boolean;
  text: string;
}

/** `GET /v1/comparisons/ID/rows/I/bias.json?layer=`: where the mean of a row's seeds is not the reference. Its blocks are not read here. */
export interface WelchMap {
  layer: string;
  seeds: number;
  level: number;
  /** Of its blocks. */
  found: number;
  heavy_tailed: boolean;
  text: string;
}

export interface MeanPoint extends Interval {
  seconds: number;
  /** 0 or below where it is not told apart from 0. */
  error: number;
  min: number;
  max: number;
  interval?: NoiseInterval | null;
}

export interface Spread {
  min: number;
  max: number;
}

/** The jobs of one entry and one set of swept parameters; they differ by their seed. */
export interface ComparisonRow {
  label: string;
  parameters: Parameters;
  jobs: string[];
  seeds: number;
  succeeded: number;
  /** Of these, that lost processor time to other processes. */
  disturbed: number;
  passes: Spread | null;
  photons: Spread | null;
  seconds: Spread | null;
  error: Record<string, FinalError>;
  time_to_error: Record<string, TimeToError[]>;
  error_at_time: Record<string, ErrorAtTime[]>;
  peak_bytes: number | null;
  efficiency: number | null;
  /** At some time no other row has a lower error. */
  pareto: boolean;
  /** By metric; null for one seed, while it runs, and where the reference is not two films. */
  bias?: Record<string, BiasAndVariance> | null;
  left_out?: LeftOut[] | null;
  /** Of a row that has light which the reference lacks, and which counts as its error: what that is. */
  mark?: string | null;
}

/** Who is first to an error, as the daemon judges it. */
export interface Verdict {
  metric: string;
  error: number;
  easiest: number;
  close: boolean;
  factor: number | null;
  arrived: { row: number; seconds: number }[];
  missing: number[];
  /** Rows with jobs that lost processor time to other processes. */
  disturbed: number[];
  text: string;
}

/** What the verdicts of a metric come to: the sentence that is shown, and with what. */
export interface Headline {
  metric: string;
  text: string;
  /** Whose look goes with it; null where nobody is ahead. */
  row: number | null;
  best: boolean;
  /** The one of the comparison's verdicts to show with it. */
  verdict: number;
  /** By falling error; no row: too close to call. */
  stretches: { row: number | null; easiest: number; error: number }[];
}

export interface ComparisonJob {
  id: string;
  label: string;
  parameters: Parameters;
  seed: number;
  state: JobState;
  passes_done: number;
  seconds: number;
  /** What it lost of its processor time, in a sentence; null where it was not disturbed. */
  warning: string | null;
  /** The job that was planned and its repeats; this is the one of them that counts. */
  runs: { id: string; state: JobState; warning: string | null }[];
}

/** As the list has them. */
export interface SequenceSummary {
  id: string;
  state: JobState;
  progress: number;
  /** Null before the first frame is done. */
  seconds_left: number | null;
  created: string;
  started: string | null;
  finished: string | null;
  job_states: Record<JobState, number>;
  request: {
    scene: string;
    image: { width: number; height: number };
    method: MethodChoice;
    stop: StopConditions;
    from: number;
    fps: number;
    frames: number;
    seed: number;
    [more: string]: unknown;
  };
  links: Record<string, string>;
}

export interface SequenceFrame {
  frame: number;
  /** Its moment, in seconds. */
  time: number;
  /** Of its job. */
  id: string;
  seed: number;
  state: JobState;
  progress: number;
  seconds: number;
}

export interface Sequence extends SequenceSummary {
  frames: SequenceFrame[];
}

export interface SequenceFigure {
  value: number;
  interval: [number, number];
}

type SequenceFigures = Record<"relative_mse" | "flicker" | "lag" | "change", SequenceFigure | null>;

export interface SequenceErrors {
  sequence: string;
  references: [string, string];
  layer: string;
  frames: (SequenceFigures & { frame: number; time: number })[];
  mean: SequenceFigures;
  frames_late: number | null;
}

export interface ComparisonSummary {
  id: string;
  state: JobState;
  progress: number;
  created: string;
  started: string | null;
  finished: string | null;
  job_states: Record<JobState, number>;
  /** Jobs made again because they were disturbed. */
  repeats: number;
  overhead_seconds: number | null;
  request: ComparisonRequest & { reference: Reference | null; metrics: string[]; seeds: number[] };
  links: Record<string, string>;
}

export interface Comparison extends ComparisonSummary {
  jobs: ComparisonJob[];
  /** Which jobs were disturbed, and what became of that. */
  warnings: string[];
  table: ComparisonRow[];
  verdicts: Verdict[];
  /** For each metric that has a verdict. */
  headlines: Headline[];
  reference: {
    job: string | null;
    /** The films of two that it is; the one job else. */
    jobs?: string[] | null;
    form?: ReferenceForm;
    image: string | null;
    state: JobState | null;
    error: Record<string, number> | null;
    warnings: string[];
  } | null;
}

/** `GET /v1/comparisons/{id}/report.json` */
export interface ComparisonReport extends Comparison {
  table: (ComparisonRow & { mean_curve: Record<string, MeanPoint[]> })[];
  curves: { job: string; points: CurvePoint[] }[];
}

/** `POST /v1/comparisons?dry_run=true` */
export interface ComparisonEstimate {
  jobs: number;
  memory_bytes: number;
  seconds: number | null;
  reference_seconds: number | null;
  warnings: string[];
  entries: { label: string; parameters: Parameters; memory_bytes: number; seconds: number | null }[];
}
