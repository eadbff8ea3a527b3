#!/usr/bin/env python3
"""Prints the service's own figures: a small job's latency, lists of a long history, a large scene's way in, memory accounted
against measured.

    PHOTOND_BIN=build/bin /usr/bin/python3 tests/benchmarks/service_figures.py [SCENE.glb]

Times are medians on this machine; nothing passes or fails here.
"""

import http.client
import os
import pathlib
import statistics
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from many_jobs import fill_history  # noqa: E402
from photond_daemon import Daemon  # noqa: E402


def image_job(scene, size, passes=1, **more):
    return {"scene": scene, "image": {"width": size[0], "height": size[1]}, "method": {"name": "path_tracing"},
            "stop": {"passes": passes}, **more}


def cpu_seconds(pid):
    """User and system seconds of one process so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def latency(daemon, runs=41):
    """From the request to the last byte of the half-float EXR, 256x256, one pass, default layers, warm worker."""
    parts = {"request to 202": [], "202 to succeeded": [], "EXR asked for to read": [], "whole": [], "worker's stages": []}
    before = cpu_seconds(daemon.process.pid)
    for seed in range(runs):
        moments = [time.monotonic()]
        job = daemon.submit(image_job("cornell-box", (256, 256), seed=seed + 1))
        moments.append(time.monotonic())
        while daemon.job(job["id"])["state"] != "succeeded":
            time.sleep(0.001)
        moments.append(time.monotonic())
        reply = daemon.request("GET", f"/v1/jobs/{job['id']}/image.exr?precision=half")
        assert reply.status == 200, reply
        moments.append(time.monotonic())
        for name, begun, ended in zip(parts, moments, moments[1:]):
            parts[name].append(ended - begun)
        parts["whole"].append(moments[3] - moments[0])
        stages = daemon.job(job["id"])["statistics"]["stages"]
        parts["worker's stages"].append(sum(stage["wall_seconds"] for stage in stages))
    daemon_cpu = (cpu_seconds(daemon.process.pid) - before) / runs
    print(f"small job, {runs} runs, milliseconds (median, worst):")
    for name, seconds in parts.items():
        print(f"  {name:24} {statistics.median(seconds) * 1e3:6.1f} {max(seconds) * 1e3:6.1f}")
    print(f"  CPU of the daemon itself for each job, its answers to the polling included: {daemon_cpu * 1e3:.1f} ms")


def lists(daemon, clients=2, runs=200):
    """The list as it is without a parameter, and as summaries, while so many clients ask one request after the other."""
    for path in ("/v1/jobs", "/v1/jobs?view=summary", "/v1/jobs?limit=1000"):
        milliseconds, sizes = [], set()

        def ask():
            connection = http.client.HTTPConnection(daemon.address, daemon.port, timeout=60)
            for _ in range(runs):
                begun = time.perf_counter()
                connection.request("GET", path)
                sizes.add(len(connection.getresponse().read()))
                milliseconds.append(1000 * (time.perf_counter() - begun))
            connection.close()
        threads = [threading.Thread(target=ask) for _ in range(clients)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        milliseconds.sort()
        p50, p99 = (milliseconds[len(milliseconds) * part // 100] for part in (50, 99))
        print(f"  GET {path:24} {max(sizes) / 1e3:8.0f} kB: p50 {p50:6.1f} ms, p99 {p99:6.1f} ms")


def big_scene(daemon, path):
    """From the first byte of the upload to the first pixel of a job on it, and its memory."""
    begun = time.monotonic()
    scene = daemon.add_scene(path)
    uploaded = time.monotonic() - begun
    submitted = time.monotonic()
    job = daemon.wait_for_job(daemon.submit(image_job(scene["id"], (1280, 720)))["id"])
    rendered = time.monotonic() - submitted
    stages = {stage["name"]: stage["wall_seconds"] for stage in job["statistics"]["stages"]}
    memory = job["statistics"]["memory"]
    grown = memory["peak_resident_bytes"] - memory["baseline_resident_bytes"]
    print(f"{path.name}: upload judged in {uploaded:.2f} s; job of one 1280x720 pass {rendered:.2f} s after its request")
    print("  stages:", ", ".join(f"{name} {seconds:.3f} s" for name, seconds in stages.items()))
    ready = uploaded + stages.get("load", 0) + stages.get("needs", 0) + stages.get("acceleration_build", 0)
    print(f"  upload to ready to render (upload + load + needs + acceleration build): {ready:.2f} s")
    print(f"  memory accounted {memory['accounted_bytes'] / 1e6:.1f} MB, peak less baseline {grown / 1e6:.1f} MB, "
          f"ratio {memory['accounted_bytes'] / grown:.3f}")
    for name, size in sorted(memory["structures"].items(), key=lambda item: -item[1]):
        print(f"    {name:24} {size / 1e6:9.2f} MB")


def main():
    shared = pathlib.Path(__file__).resolve().parents[2].parent / "shared" / "scenes" / "sponza_crytek.glb"
    path = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else shared
    with Daemon() as daemon:
        daemon.wait_ready()
        daemon.wait_for_job(daemon.submit(image_job("cornell-box", (64, 64)))["id"])
        latency(daemon)
    with Daemon(start=False) as daemon:
        fill_history(daemon.data_dir, 100_000)
        daemon.start()
        daemon.wait_ready()
        print("lists of 100,000 jobs, two clients:")
        lists(daemon)
    if not path.exists():
        print(f"{path}: not there, its figures are left out")
        return
    with Daemon() as daemon:
        daemon.wait_ready()
        big_scene(daemon, path)


if __name__ == "__main__":
    main()
