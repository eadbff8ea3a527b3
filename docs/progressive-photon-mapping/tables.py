#!/usr/bin/python3
"""The tables of README.md from reports of `photonctl compare --preset progressive --json-report FILE`.

    docs/progressive-photon-mapping/tables.py REPORT.json ...
"""

import json
import pathlib
import sys

PASSES = (1, 16, 64, 256, 1024)  # of Figure 5


def figure(value):
    return "-" if value is None else f"{value:.2g}"


def after_passes(curve, passes):
    """The error at the first point with that many passes; nothing where the job did not come so far."""
    found = [point["metrics"].get("relative_mse") for point in curve["points"] if point["passes"] == passes]
    return found[0] if found else None


def with_interval(error):
    if error["value"] is None or not error["interval"]:
        return figure(error["value"])
    low, high = error["interval"]
    return f"{error['value']:.2g} ({low:.2g} to {high:.2g})"


def table(report):
    scene = report["request"]["scene"]
    seconds = report["request"]["stop"]["seconds"]
    print(f"\n### {scene}\n")
    curves = {curve["job"]: curve for curve in report["curves"]}
    lengths = [passes for passes in PASSES if any(after_passes(curve, passes) is not None for curve in curves.values())]
    print("| | " + " | ".join(f"{passes:,}" for passes in lengths) + f" | {seconds:g} s | passes |")
    print("|---" * (len(lengths) + 3) + "|")
    for row in report["table"]:
        curve = curves[row["jobs"][0]]
        cells = [figure(after_passes(curve, passes)) for passes in lengths]
        label = ", ".join([row["label"], *(f"{name} {value}" for name, value in row["parameters"].items())])
        print(f"| {label} | " + " | ".join(cells) + f" | {with_interval(row['error']['relative_mse'])} | "
              f"{row['passes']['max']:,} |")


def main():
    for name in sys.argv[1:]:
        table(json.loads(pathlib.Path(name).read_text()))


main()
