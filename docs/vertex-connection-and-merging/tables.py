#!/usr/bin/python3
"""The table of README.md from reports of `photonctl compare --preset vcm --json-report FILE`: relative_mse by scene and
method, and the passes that it is of.

    docs/vertex-connection-and-merging/tables.py REPORT.json ...
"""

import json
import pathlib
import sys


def cell(row, best):
    error = row["error"]["relative_mse"]
    if error["value"] is None:
        return "-"
    low, high = error["interval"]
    figure = f"{error['value']:.2g}"
    figure = f"**{figure}**" if row is best else figure
    return f"{figure} ({low:.2g} to {high:.2g}; {row['passes']['max']})"


def main():
    labels = []
    lines = []
    for name in sys.argv[1:]:
        report = json.loads(pathlib.Path(name).read_text())
        rows = [row for row in report["table"] if row["error"]["relative_mse"]["value"] is not None]
        best = min(rows, key=lambda row: row["error"]["relative_mse"]["value"])
        labels = labels or [row["label"] for row in report["table"]]
        lines.append(f"| {report['request']['scene']} | " + " | ".join(cell(row, best) for row in report["table"]) + " |")
    print("| | " + " | ".join(labels) + " |")
    print("|---" * (len(labels) + 1) + "|")
    print("\n".join(lines))


main()
