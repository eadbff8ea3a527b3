"""A long history for a daemon's store: jobs that are over, as if they had been rendered.

    with Daemon(start=False) as daemon:
        fill_history(daemon.data_dir, 100_000)
        daemon.start()

The daemon must not be running meanwhile: its store has one owner. What is written is what the daemon would have: requests
with every default filled in, attempts, statistics, curves, failures, log lines; films alone are missing, as after a job
that left none. The same count gives the same history.

Or by hand: PHOTOND_BIN=... python3 many_jobs.py DATA_DIR COUNT
"""

import datetime
import json
import pathlib
import random
import sqlite3
import sys

QUEUED, RUNNING, SUCCEEDED, FAILED, CANCELLED = range(5)
FIRST_MS = 1_750_000_000_000
METHODS = {
    "path_tracing": {"indirect_bounces": 16},
    "photon_mapping": {"photons": 200_000, "gather": "final", "gather_rays": 64},
    "photon_splatting": {"photons": 25_000, "splat_size": 0.1},
}
SCENES = ("cornell-box", "cornell-box-glass", "cornell-box-glossy", "caustic-ring", "keyhole", "interior")
SIZES = ((256, 256), (512, 512), (1280, 720), (1920, 1080))
STUDIES = ("splat-size", "gather", "caustics", "seeds", "reference check")
FAILURES = (
    ("worker_crashed", 500, "the worker crashed", "attempt 2 crashed: killed by signal 11 (Segmentation fault)"),
    ("out_of_memory", 422, "the job needs more memory than it may use",
     "attempt 1 out_of_memory: the worker passed its limit of 6442450944 bytes"),
    ("timed_out", 504, "the job took longer than it may", "attempt 1 timed_out: passed the limit of 3600.000000 s"),
)


def daemon_json(value):
    """As the daemon writes it."""
    return json.dumps(value, separators=(",", ":"), sort_keys=True)


def rfc3339(ms):
    moment = datetime.datetime.fromtimestamp(ms / 1000, datetime.timezone.utc)
    return moment.strftime("%Y-%m-%dT%H:%M:%S.") + f"{ms % 1000:03d}Z"


def request_of(source, number):
    """A request as the daemon echoes it, with every default filled in."""
    method = source.choice(tuple(METHODS))
    width, height = source.choice(SIZES)
    passes = source.choice((16, 64, 256))
    return {
        "scene": source.choice(SCENES),
        "camera": {"name": "camera", "look_at": None, "aperture": 0.0, "focus_distance": None},
        "image": {"width": width, "height": height, "filter": "box"},
        "method": {"name": method, "device": "cpu", "parameters": METHODS[method]},
        "stop": {"seconds": None, "passes": passes, "target": None},
        "first_pass": 0,
        "seed": 1 + number % 5,
        "layers": [],
        "reference": None,
        "metrics": [],
        "priority": source.choice((0, 0, 0, 0, -10, 10)),
        "labels": {"study": source.choice(STUDIES), "run": str(number)},
        "environment": None,
        "glass": "as_stored",
        "time": 0,
    }


def curve_of(source, passes, seconds, photons):
    """Points at passes 1, 2, 3, .. and then ever further apart, as the daemon measures."""
    at, points, error = 1, [], source.uniform(0.2, 5)
    while at <= passes:
        points.append({"seconds": seconds * at / passes, "passes": at, "photons": photons * at if photons else None,
                       "metrics": {"estimated_relative_mse": error / at * source.uniform(0.9, 1.1) if at > 1 else None}})
        at = max(at + 1, at * 5 // 4)
    return points


def statistics_of(source, request, passes, seconds, curve):
    pixels = request["image"]["width"] * request["image"]["height"]
    camera = pixels * passes
    photons = METHODS[request["method"]["name"]].get("photons", 0) * passes
    rays = {"camera": camera, "bounce": camera * 4, "shadow": camera * 5, "photon": photons * 6}
    digest = f"{source.getrandbits(256):064x}"
    per_second = (lambda count: count / seconds if seconds > 0 else None)
    return {
        "stages": [{"name": name, "wall_seconds": seconds * share, "cpu_seconds": seconds * share * 2, "gpu_seconds": None}
                   for name, share in (("load", 0.01), ("acceleration_build", 0.02), ("photon_tracing", 0.2),
                                       ("light_transport", 0.7), ("film", 0.05))],
        "counts": {"rays": rays, "photons_emitted": photons, "photons_stored": photons * 3, "splats": 0,
                   "splat_contributions": 0, "vpls": 0, "voxels": 0, "passes": passes},
        "rates": {"rays_per_second": per_second(sum(rays.values())), "samples_per_second": per_second(camera),
                  "passes_per_second": per_second(passes), "photons_per_second": per_second(photons) if photons else None,
                  "photon_rays_per_second": per_second(rays["photon"]) if photons else None},
        "memory": {"structures": {"film": pixels * 96, "scene": 2_000_000, "acceleration": 4_000_000},
                   "accounted_bytes": pixels * 96 + 6_000_000, "baseline_resident_bytes": 60_000_000,
                   "peak_resident_bytes": pixels * 96 + 70_000_000, "device_structures": None,
                   "peak_device_bytes": None},
        "needs": {name: False for name in ("alpha", "emissive_textures", "environment", "glass", "textures")},
        "skipped": [],
        "device": {"id": "cpu", "name": "a processor", "driver": None, "software": True},
        "version": "1.0.0", "host_cores": 8, "threads": 8, "seed": request["seed"], "seconds": seconds, "passes": passes,
        "pass_ranges": [[0, passes]] if passes else [], "resumed_passes": 0, "settings_hash": digest, "job_hash": digest,
        "pixel_hash": digest if passes else None, "nan_count": 0, "infinity_count": 0, "device_shared": False,
        "host_shared": False, "cores": None, "shared": None, "error": None, "reference_error": None, "reference": None,
        "estimate": {"estimated_relative_mse": curve[-1]["metrics"]["estimated_relative_mse"] if curve else None,
                     "standard_error_scale": 1.0, "confidence": 0.95, "within_confidence": 0.94},
    }


def job_of(source, number, created_ms):
    """Columns of one job, and its log."""
    request = request_of(source, number)
    state = source.choices((SUCCEEDED, FAILED, CANCELLED), (88, 7, 5))[0]
    asked = request["stop"]["passes"]
    passes = asked if state == SUCCEEDED else source.randrange(asked)
    pixels = request["image"]["width"] * request["image"]["height"]
    seconds = round(passes * pixels * source.uniform(2e-7, 2e-6), 6)
    started_ms = created_ms + source.randrange(2000)
    finished_ms = started_ms + int(seconds * 1000) + source.randrange(20, 200)
    photons = METHODS[request["method"]["name"]].get("photons")
    curve = curve_of(source, passes, seconds, photons)
    failure, outcome = "", ("succeeded", "failed", "cancelled")[state - SUCCEEDED]
    if state == FAILED:
        code, status, title, detail = source.choice(FAILURES)
        failure = daemon_json({"type": "urn:photond:problem:" + code, "title": title, "status": status, "code": code,
                              "detail": detail, "instance": f"/v1/jobs/J{number}", "errors": []})
    attempt = {"attempt": 1, "device": "cpu", "started": rfc3339(started_ms), "finished": rfc3339(finished_ms),
               "outcome": outcome, "reason": None, "passes_done": passes, "device_shared": False, "host_shared": False}
    measured = curve[-1]["metrics"]["estimated_relative_mse"] if curve else None
    error_now = {"metric": "estimated_relative_mse", "value": measured}
    statistics = statistics_of(source, request, passes, seconds, curve)
    row = {
        "seq": number, "state": state, "priority": request["priority"], "device": "cpu",
        "method": request["method"]["name"], "scene": request["scene"], "request": daemon_json(request),
        "created_ms": created_ms, "started_ms": started_ms, "finished_ms": finished_ms, "attempt": 1, "crashes": 0,
        "losses": 0, "cancel_requested": int(state == CANCELLED), "purge_requested": 0, "passes_done": passes,
        "progress": passes / asked, "seconds": seconds, "film": "", "pixel_hash": statistics["pixel_hash"] or "",
        "statistics": daemon_json(statistics) if state != FAILED else "", "failure": failure,
        "attempts": daemon_json([attempt]), "curve": daemon_json(curve) if curve else "",
        "error_now": daemon_json(error_now) if measured is not None else "",
    }
    log = [(created_ms, "queued for cpu"), (started_ms, "attempt 1 begins on cpu"),
           (finished_ms, f"attempt 1 {outcome} after {passes} passes")]
    return row, log


def fill_history(data_dir, count):
    """Adds `count` jobs that are over to the store of a data folder. A folder without a store is given one, by a daemon
    that is started and stopped there; PHOTOND_BIN says where its programs are.
    """
    store = pathlib.Path(data_dir) / "store.sqlite"
    if not store.exists():
        from photond_daemon import Daemon
        with Daemon(data_dir=data_dir) as daemon:
            daemon.wait_ready()
    database = sqlite3.connect(store, isolation_level=None)
    try:
        database.execute("PRAGMA foreign_keys = ON")
        database.execute("PRAGMA synchronous = OFF")  # what a crash would lose here is made again
        database.execute("BEGIN EXCLUSIVE")  # fails where a daemon has it
        (last,) = database.execute("SELECT coalesce(max(seq), 0) FROM sqlite_sequence WHERE name = 'jobs'").fetchone()
        source = random.Random(count)
        created_ms = FIRST_MS
        for number in range(last + 1, last + count + 1):
            created_ms += source.randrange(60_000)
            row, log = job_of(source, number, created_ms)
            database.execute(f"INSERT INTO jobs ({', '.join(row)}) VALUES ({', '.join('?' * len(row))})",
                             tuple(row.values()))
            database.executemany("INSERT INTO job_log (job, at_ms, line) VALUES (?, ?, ?)",
                                 [(number, at_ms, line) for at_ms, line in log])
        database.execute("COMMIT")
    finally:
        database.close()


if __name__ == "__main__":
    fill_history(sys.argv[1], int(sys.argv[2]))
