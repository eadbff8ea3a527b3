#!/usr/bin/env python3
"""Draws Graphs 1 to 4 of the photon splatting thesis again: the influence of parameters on quality and timing, for photon
mapping, small and large splats and stratified ones; beside each, as a grey line, what photond has in their place.

    python3 thesis_graphs.py --width 640 --height 360 --seconds 2 -o graphs.svg

renders against the daemon that PHOTOND_URL names (default: http://127.0.0.1:8080) and writes graphs.csv always, and
graphs.svg (or .png, .pdf) where matplotlib is installed. The settings are those of `photonctl compare --preset
photon-splatting-thesis`; docs/photon-splatting-thesis says what comes out, and why.
"""

import argparse
import csv
import pathlib
import sys

import photond
from photond import entry

ONE_BOUNCE = {"indirect_bounces": 1}
SPLATS = {"bounces": 1, "weighting": "normalised"}

# Number and title of each graph, and its entry: the method, what all its rows share, and what is swept.
GRAPHS = [
    (1, "photon mapping", "photon_mapping", {"gather": "direct", "boundary": "none", **ONE_BOUNCE},
     {"photons": [5000, 50000], "nearest_photons": [50, 200]}),
    (2, "small splats", "photon_splatting", {**SPLATS, "splat_size_relative": 0.25}, {"photons": [2500, 8000, 25000]}),
    (3, "large splats", "photon_splatting", {**SPLATS, "splat_size_relative": 0.75}, {"photons": [250, 800, 2500]}),
    (4, "stratified", "photon_splatting",
     {**SPLATS, "splat_size_relative": 0.25, "stratify": True, "minimum_photons": 1, "representative": "closest_to_mean"},
     {"photons": [25000, 100000], "grid_cells": [16, 64, 256]}),
]
OURS = "ours"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="cornell-box-spot", help="name, id or path; default: %(default)s")
    parser.add_argument("--width", type=int, default=1600)
    parser.add_argument("--height", type=int, default=900)
    parser.add_argument("--seconds", type=float, help="of each job; default: 30, unless --passes is given")
    parser.add_argument("--passes", type=int, help="of each job")
    parser.add_argument("--seeds", type=lambda text: [int(seed) for seed in text.split(",")], default=[1],
                        help="repeat every job with each, for bands of 95 %%; default: 1")
    parser.add_argument("--reference-passes", type=int, default=256, help="of path tracing; default: %(default)s")
    parser.add_argument("--metric", default="indirect:relative_mse", help="default: %(default)s")
    parser.add_argument("--comparison", help="draw this one, which was rendered before")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("thesis_graphs.svg"))
    options = parser.parse_args()
    if options.seconds is None and options.passes is None:
        options.seconds = 30
    return options


def submit(client, options):
    entries = [entry(method, title, parameters=parameters, sweep=sweep) for _, title, method, parameters, sweep in GRAPHS]
    entries.append(entry("photon_splatting", OURS, parameters={"bounces": 1, "photons": 8000}))
    return client.submit_comparison(
        options.scene, entries, width=options.width, height=options.height, seconds=options.seconds, passes=options.passes,
        seeds=options.seeds, metrics=[options.metric, "rmse_8bit"],
        reference=photond.reference("path_tracing", passes=options.reference_passes, parameters=ONE_BOUNCE))


def show_progress(comparison):
    print(f"\r{comparison.id} {comparison.state}, {100 * comparison.progress:.0f} %", end="", file=sys.stderr, flush=True)


def write_csv(path, curves):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["graph", "entry", "setting", "seconds", "error", "low", "high", "below"])
        for number, title, *_ in GRAPHS:
            for curve in curves:
                if curve.label in (title, OURS):
                    spread = zip(curve.low, curve.high) if curve.low else [("", "")] * len(curve.seconds)
                    for seconds, error, (low, high) in zip(curve.seconds, curve.errors, spread):
                        writer.writerow([number, curve.label, curve.name, seconds, error, low, high, ""])
                    for seconds, below, _ in curve.bounds:  # not told apart from 0
                        writer.writerow([number, curve.label, curve.name, seconds, "", "", "", below])


def draw(path, comparison, curves, metric):
    import matplotlib
    matplotlib.use("agg")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7.5), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True).flat
    ours = [curve for curve in curves if curve.label == OURS]
    for ax, (number, title, *_) in zip(panels, GRAPHS):
        for curve in ours:
            ax.plot(curve.seconds, curve.errors, color="0.6", linewidth=3, label=curve.name, zorder=1)
        photond.plot_curves([curve for curve in curves if curve.label == title], metric, ax=ax)
        ax.set_title(f"Graph {number}: {title}", loc="left", fontsize="medium")
        ax.label_outer()
    image = comparison.request["image"]
    figure.suptitle(f"{comparison.request['scene']}, {image['width']} x {image['height']}: error against time",
                    fontsize="large")
    figure.savefig(path)


def main():
    options = arguments()
    with photond.Client() as client:
        comparison = client.comparison(options.comparison) if options.comparison else submit(client, options)
        comparison.wait(on_change=show_progress)
        print(file=sys.stderr)
        print(comparison.table_text(options.metric))
        curves = comparison.mean_curves(options.metric)
        table = options.output.with_suffix(".csv")
        write_csv(table, curves)
        print(f"saved {table}", file=sys.stderr)
        try:
            draw(options.output, comparison, curves, options.metric)
            print(f"saved {options.output}", file=sys.stderr)
        except ImportError as error:
            print(f"{options.output} is not drawn: {error}", file=sys.stderr)


if __name__ == "__main__":
    main()
