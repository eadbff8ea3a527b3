#!/usr/bin/env python3
"""Prints how well jobs keep the seconds they were given: every named built-in scene, method and device.

    PHOTOND_BIN=build/bin /usr/bin/python3 tests/benchmarks/kept_seconds.py [--seconds 5] [--size 640x360] [--devices cpu,gpu]
                                                                            [--scenes A,B] [--methods A,B]

The table is Markdown: passes done, seconds before the first pass, seconds of a pass, overshoot, passes cut off, and the
share of its cores that the job had. Nothing passes or fails here.
"""

import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from photond_daemon import Daemon  # noqa: E402


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = lambda text: text.split(",")  # noqa: E731
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--size", type=lambda text: tuple(int(side) for side in text.split("x")), default=(640, 360))
    parser.add_argument("--devices", type=names, default=["cpu", "gpu"])
    parser.add_argument("--scenes", type=names, default=None)
    parser.add_argument("--methods", type=names, default=None)
    return parser.parse_args()


def show(value, digits=2):
    return "" if value is None else f"{value:.{digits}f}"


def main():
    arguments = parse()
    width, height = arguments.size
    print("| scene | method | device | passes | before the first [s] | a pass [s] | over [s] | kept | cut off | cores |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with Daemon("--devices", ",".join(arguments.devices)) as daemon:
        daemon.wait_ready()
        scenes = [scene["id"] for scene in daemon.request("GET", "/v1/scenes").json["items"]]
        devices = {device["kind"]: device["id"] for device in daemon.request("GET", "/v1/devices").json["items"]
                   if device["served"]}
        methods = daemon.request("GET", "/v1/methods").json["items"]
        for scene in arguments.scenes or scenes:
            for method in methods:
                if arguments.methods and method["name"] not in arguments.methods:
                    continue
                for device in arguments.devices:
                    if device not in method["devices"]:
                        continue
                    job = daemon.submit({"scene": scene, "image": {"width": width, "height": height},
                                         "method": {"name": method["name"], "device": devices[device]},
                                         "stop": {"seconds": arguments.seconds}})
                    job = daemon.wait_for_job(job["id"])
                    if job["state"] != "succeeded":
                        print(f"| {scene} | {method['name']} | {device} | {job['state']}: {job['error']['message']} |||||||",
                              flush=True)
                        continue
                    clock, cores = job["statistics"]["clock"], job["statistics"]["cores"]
                    cells = [scene, method["name"], device, job["passes_done"], show(clock["begin_seconds"], 3),
                             show(clock["seconds_per_pass"]), show(clock["overshoot_seconds"]),
                             {True: "yes", False: "no"}.get(clock["kept"], ""), clock["passes_cut_off"],
                             show(cores and cores["share"])]
                    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


if __name__ == "__main__":
    main()
