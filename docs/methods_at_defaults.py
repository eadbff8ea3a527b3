"""Every method at its defaults: how far its images are from the truth, how soon, and what they leave out, as a page.

    python3 docs/methods_at_defaults.py measure RESULTS.jsonl --scenes cornell-box details/bar --devices cpu gpu
    python3 docs/methods_at_defaults.py table RESULTS.jsonl ... --heading HEADING.md -o docs/methods-at-defaults.md

`measure` asks the daemon at PHOTOND_URL for one job a scene, method and device, and adds a line for each to RESULTS.jsonl; what is
there already is not measured again. The truth is path tracing, two films of different seeds. `--methods` may name settings that are
not the defaults, as photon_mapping,gather=direct. Later files of `table` replace lines of earlier ones.
Needs numpy, and clients/python on PYTHONPATH.
"""

import argparse
import json
import math
import pathlib
import sys

import numpy

LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])
TIMES = (1, 5, 20)  # seconds at which the error is read


# --- measured ---------------------------------------------------------------------------------------------------------
def student_95(degrees):
    """Two-sided, by the expansion in 1 / degrees [Abramowitz and Stegun 26.7.5]; within 2 % from 3 degrees on."""
    z = 1.959964
    terms = [(z**3 + z) / 4, (5 * z**5 + 16 * z**3 + 3 * z) / 96, (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384]
    return z + sum(term / degrees ** (i + 1) for i, term in enumerate(terms))


def mean_and_error(images):
    """Luminance of two reference films whose pixels are independent: the mean, and its standard error."""
    first, second = (image.astype(float) @ LUMINANCE for image in images)
    return float((first.mean() + second.mean()) / 2), float((first - second).std() / 2 / math.sqrt(first.size))


def bias_of(job, references):
    """Relative to the references' mean, with the half-width of 95 % [Welch 1947]: passes of the job and pixels of the references
    are the samples. The half-width is None where a job has too few passes to tell."""
    truth, truth_error = mean_and_error(references)
    image = job.image().astype(float) @ LUMINANCE
    spread = job.errors.get("bias_standard_error")
    passes = job.passes_done
    bias = float(image.mean()) / truth - 1
    if spread is None or passes < 4:
        return bias, None
    own = float(numpy.dot(LUMINANCE, spread))  # channels share their noise
    variance = own**2 + truth_error**2
    if variance == 0:
        return bias, 0.0
    degrees = variance**2 / (own**4 / (passes - 1) + truth_error**4 / (image.size - 1))
    return bias, student_95(degrees) * math.sqrt(variance) / truth


def error_at(curve, seconds):
    """[value, least, greatest] of the last point by then; None before the first one."""
    points = [point for point in curve if point["seconds"] <= seconds and (point["metrics"] or {}).get("relative_mse") is not None]
    if not points:
        return None
    interval = (points[-1].get("intervals") or {}).get("relative_mse") or [None, None]
    return [points[-1]["metrics"]["relative_mse"], *interval]


def settings_of(words):
    """Parameters of the words NAME=VALUE, of which numbers and true and false are JSON."""
    parameters = {}
    for word in words:
        name, value = word.split("=", 1)
        try:
            parameters[name] = json.loads(value)
        except ValueError:
            parameters[name] = value
    return parameters


def row_of(job, references):
    bias, half_width = bias_of(job, references)
    curve = job.curve
    return {"passes": job.passes_done, "seconds": job.statistics["seconds"], "bias": bias, "half_width": half_width,
            "first_picture": curve[0]["seconds"] if curve else None,
            "relative_mse": {str(time): error_at(curve, time * 1.001) for time in TIMES},
            "left_out": job.left_out, "hardware": job.statistics["device"]["name"], "threads": job.statistics["threads"]}


def measure(options):
    import photond

    client = photond.Client()
    path = pathlib.Path(options.results)
    known = {key_of(row) for row in read([path])} if path.exists() else set()
    methods = client.methods
    for scene in options.scenes:
        reference = photond.reference("path_tracing", seconds=options.reference_seconds)
        for device in options.devices:
            for entry in options.methods or methods:
                name, *words = entry.split(",")
                if (scene, entry, device) in known or device not in methods[name].devices:
                    continue
                row = {"scene": scene, "method": entry, "device": device, "size": options.size}
                try:
                    job = client.render(scene, name, device=device, parameters=settings_of(words), width=options.size,
                                        height=options.size, seconds=options.seconds, reference=reference,
                                        metrics=["relative_mse"], seed=1)
                    films = [client.job(id) for id in job.reference_jobs]
                    row.update(row_of(job, [film.image() for film in films]))
                except (photond.Refused, photond.JobFailed) as failure:
                    row["failure"] = str(failure)
                with path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
                print(json.dumps(row), flush=True)


# --- shown ------------------------------------------------------------------------------------------------------------
def key_of(row):
    return row["scene"], row["method"], row["device"]


def read(paths):
    """Rows of the files; of two with one scene, method and device the later one."""
    rows = {}
    for path in paths:
        for line in path.read_text(encoding="utf-8").splitlines():
            row = json.loads(line)
            rows[key_of(row)] = row
    return list(rows.values())


def bias_text(row):
    text = f"{100 * row['bias']:+.2f}"
    return f"{text} ± {100 * row['half_width']:.2f}" if row["half_width"] is not None else f"{text} (too few passes)"


def error_text(error):
    """A figure that the references tell apart from 0 or the interval's upper end; nothing before the first picture."""
    if error is None:
        return "-"
    value, least, greatest = error
    if greatest is not None and least <= 0:
        return f"< {greatest:.2g}"
    return f"{value:.2g}"


def seconds_text(seconds):
    return "-" if seconds is None else f"{seconds:.2g}"


def table(rows):
    lines = ["| method | bias, % | relative_mse after " + " | ".join(f"{time} s" for time in TIMES) +
             " | first picture, s | passes | left out |", "|---|" + "---|" * (len(TIMES) + 4)]
    for row in rows:
        name = f"{row['method']}, {row['device']}"
        if "failure" in row:
            lines.append(f"| {name} | {row['failure']}" + " |" * (len(TIMES) + 4))
            continue
        errors = (error_text(row["relative_mse"][str(time)]) for time in TIMES)
        lines.append(f"| {name} | {bias_text(row)} | " + " | ".join(errors) +
                     f" | {seconds_text(row['first_picture'])} | {row['passes']} | {'; '.join(row['left_out']) or '-'} |")
    return lines


def page(options):
    rows = read([pathlib.Path(path) for path in options.results])
    lines = [pathlib.Path(options.heading).read_text(encoding="utf-8").rstrip()] if options.heading else []
    for scene in dict.fromkeys(row["scene"] for row in rows):
        lines += ["", f"## {scene}", ""] + table([row for row in rows if row["scene"] == scene])
    pathlib.Path(options.output).write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    measuring = commands.add_parser("measure")
    measuring.add_argument("results")
    measuring.add_argument("--scenes", nargs="+", required=True)
    measuring.add_argument("--methods", nargs="+", help="all of them where none is named")
    measuring.add_argument("--devices", nargs="+", default=["cpu", "gpu"])
    measuring.add_argument("--size", type=int, default=128, help="pixels a side")
    measuring.add_argument("--seconds", type=float, default=TIMES[-1] + 0.5, help="of each job; more makes bias surer")
    measuring.add_argument("--reference-seconds", type=float, default=40)
    measuring.set_defaults(do=measure)
    showing = commands.add_parser("table")
    showing.add_argument("results", nargs="+")
    showing.add_argument("--heading")
    showing.add_argument("-o", "--output", required=True)
    showing.set_defaults(do=page)
    options = parser.parse_args()
    options.do(options)


if __name__ == "__main__":
    sys.exit(main())
