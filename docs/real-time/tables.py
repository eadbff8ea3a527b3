#!/usr/bin/python3
"""The tables of README.md from reports of `photonctl compare --json-report FILE`, whose images the daemon at PHOTOND_URL has.

    docs/real-time/tables.py REPORT.json ...

Needs OpenImageIO for Python.
"""

import json
import os
import pathlib
import sys
import tempfile
import urllib.request

import OpenImageIO

METRICS = ("indirect:relative_mse", "indirect:flip_hdr", "flip_ldr")


def mean_indirect(job):
    """Of all pixels and channels of a job's image."""
    url = os.environ.get("PHOTOND_URL", "http://127.0.0.1:8080")
    with tempfile.NamedTemporaryFile(suffix=".exr") as file:
        file.write(urllib.request.urlopen(f"{url}/v1/jobs/{job}/image.exr").read())
        file.flush()
        image = OpenImageIO.ImageInput.open(file.name)
        names = image.spec().channelnames
        pixels = image.read_image(format=OpenImageIO.FLOAT)
        image.close()
    return float(pixels[..., [names.index(f"indirect.{channel}") for channel in "RGB"]].mean())


def table(report):
    request = report["request"]
    size = request["image"]
    print(f"\n### {request['scene']}, {size['width']} x {size['height']}, {request['stop']['passes']} passes\n")
    print("| | bias of the mean | " + " | ".join(f"`{metric}`" for metric in METRICS) + " | MiB |")
    print("|---|--:|" + "--:|" * (len(METRICS) + 1))
    references = report["reference"]["jobs"]
    truth = sum(mean_indirect(job) for job in references) / len(references)
    for row in sorted(report["table"], key=lambda row: row["error"][METRICS[0]]["value"]):
        bias = 100 * (mean_indirect(row["jobs"][0]) / truth - 1)
        errors = " | ".join(f"{row['error'][metric]['value']:.2g}" for metric in METRICS)
        print(f"| {row['label']} | {bias:+.1f} % | {errors} | {row['peak_bytes'] / 2**20:.0f} |")


def main():
    for name in sys.argv[1:]:
        table(json.loads(pathlib.Path(name).read_text()))


main()
