"""The table of hard cases as a page: python3 docs/hard_cases.py REPORT.json ... -o docs/hard-cases.md, of the files that
`photonctl hard-cases --json-report` writes; tables of different methods stand side by side."""

import argparse
import json


def percent(x):
    return "0" if x == 0 else f"{100 * x:+.2g} %"


def figure(check):
    """What was measured: bias and its standard error, or the greatest radiance where there should be none."""
    if check["relation"] == "finite":
        return "finite"
    if check["bias"] is None:
        return "0" if check["holds"] else f"{check['worst_pixel']['deviation']:.2g}"
    if not check["relative"]:
        return f"{check['bias']:+.2g}"
    return f"{percent(check['bias'])} ({100 * check['standard_error']:.1g})"


def worst(checks):
    """The check that says most: one that breaks, else the one farthest from its answer in standard errors."""
    def far(check):
        return (not check["holds"], abs(check["bias"] or 0) / (check["half_width"] or 1))
    return max(checks, key=far)


def cell(entry):
    if entry["verdict"] == "not applicable" or not entry["checks"]:
        return "-"
    text = figure(worst(entry["checks"]))
    return f"**{text}**" if entry["verdict"] != "holds" else text


def by_case(reports):
    """Scenes in the first report's order: case, and its cells by entry over all reports."""
    cases = {}
    for report in reports:
        for case in report["cases"]:
            found = cases.setdefault(case["name"], dict(case, cells=[]))
            found["cells"] += case["cells"]
    return list(cases.values())


def table(cases, labels):
    lines = ["| scene | " + " | ".join(labels) + " |", "|---|" + "---|" * len(labels)]
    for case in cases:
        if case["scene"] is None:
            lines.append(f"| {case['name']} | " + f"the test {case['test']}" + " |" * len(labels))
            continue
        cells = {entry["entry"]: entry for entry in case["cells"]}
        lines.append(f"| {case['name']} | " + " | ".join(cell(cells[label]) if label in cells else "" for label in labels) +
                     " |")
    return lines


def breaks(cases):
    lines = []
    for case in cases:
        for entry in case["cells"]:
            if entry["verdict"] not in ("holds", "not applicable"):
                reason = f" ({entry['reason']})" if entry["reason"] else ""
                notes = "".join(f"; {note}" for note in entry["notes"])
                lines.append(f"* `{case['name']}`, {entry['entry']}: {entry['text']}{reason}{notes}")
    return lines


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("reports", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--heading", default="", help="file of what stands above the table")
    options = parser.parse_args()
    reports = [json.load(open(name, encoding="utf-8")) for name in options.reports]
    labels = [entry["label"] for report in reports for entry in report["entries"]]
    cases = by_case(reports)
    total = {key: sum(report["summary"][key] for report in reports) for key in reports[0]["summary"]}
    lines = []
    if options.heading:
        lines += [open(options.heading, encoding="utf-8").read().rstrip("\n"), ""]
    lines += [f"{total['holds']} cells hold, {total['breaks']} break, {total['not_applicable']} are not applicable; "
              f"{total['defects']} have NaN, infinity, negative radiance, a failed or a hanging job.", ""]
    lines += ["## The table", ""] + table(cases, labels)
    if broken := breaks(cases):
        lines += ["", "## What breaks", ""] + broken
    with open(options.output, "w", encoding="utf-8") as page:
        page.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
