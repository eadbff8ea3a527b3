#!/usr/bin/python3
"""What a run of the tests cost, beside what it may cost (tests/budget.txt).

  test_costs.py calibrate                   prints how many processor seconds a fixed piece of work takes here and now
  test_costs.py calibrate --until-killed    prints it again and again, while the tests run
  test_costs.py report FOLDER BUDGET --build SECONDS --calibration SECONDS ... [--enforce]
        prints processor seconds by program beside their budget, and the twenty dearest cases; FOLDER is where the tests
        wrote them (PHOTOND_TEST_TIMES). --enforce: exit status 1 where a program took much more than its share.
  test_costs.py budget FOLDER --build SECONDS --calibration SECONDS ...
        prints a budget of what this run took

A budget's figures are of the machine that its line `calibration` was measured on; they are scaled by this run's, which is
the mean of those taken while the tests ran. What other tenants of a shared machine take from one program and not from the
next shows in the spread of all programs' costs about their median. A program is over its share where it took 1.5 times
that median, and more than the spread explains: 3.5 of its standard deviations (by the median deviation) of the logarithm.
"""

import argparse
import collections
import math
import multiprocessing
import os
import pathlib
import re
import statistics
import sys
import time

ALLOWED = 1.5
ALLOWED_DEVIATIONS = 3.5
DEVIATION_OF_MEDIAN_DEVIATION = 1.4826  # the standard deviation of a normal distribution whose median deviation is 1
SECONDS_BETWEEN_CALIBRATIONS = 15
LEAST_PROGRAMS = 10  # of which a median says something
LEAST_SHARE = 6.0  # processor seconds: below that a program is mostly its own start, and asks whether others are done


def fixed_work(_):
    began = time.process_time()
    numbers, state = {}, 1
    for step in range(1_500_000):
        state = state * 1103515245 + 12345 & 0x7FFFFFFF
        numbers[state & 0xFFFF] = step
    return time.process_time() - began


def calibrate():
    with multiprocessing.Pool(os.cpu_count()) as pool:
        return statistics.median(pool.map(fixed_work, range(3 * os.cpu_count())))


def calibrate_until_killed():
    while True:
        print(f"{fixed_work(None):.3f}", flush=True)
        time.sleep(SECONDS_BETWEEN_CALIBRATIONS)


def program_of(entry):
    """Shards are one program."""
    return re.sub(r"\.\d+$", "", entry)


def totals_in(folder):
    totals = collections.Counter()
    for file in folder.glob("*.total"):
        totals[program_of(file.name[:-len(".total")])] += float(file.read_text())
    return totals


def cases_in(folder):
    cases = []
    for file in folder.glob("*.cases"):
        program = file.name.split(".")[0]
        for line in file.read_text().splitlines():
            seconds, name = line.split("\t", 1)
            cases.append((float(seconds), f"{program} {name}"))
    return sorted(cases, reverse=True)


def read_budget(file):
    rows = [line.split() for line in file.read_text().splitlines() if line and not line.startswith("#")]
    budget = {name: float(seconds) for name, seconds in rows}
    budget["tests"] = sum(seconds for name, seconds in budget.items() if name not in ("calibration", "build"))
    return {**budget, "total": budget["tests"] + budget["build"]}


def report(asked):
    spent = totals_in(asked.folder)
    budget = read_budget(asked.budget)
    scale = statistics.mean(asked.calibration) / budget["calibration"]
    ratios = [seconds / (scale * budget[name]) for name, seconds in spent.items() if budget.get(name, 0.0) > LEAST_SHARE]
    slower, spread = 1.0, 0.0
    if len(ratios) >= LEAST_PROGRAMS:
        logarithms = [math.log(ratio) for ratio in ratios]
        median = statistics.median(logarithms)
        slower = max(1.0, math.exp(median))
        spread = DEVIATION_OF_MEDIAN_DEVIATION * statistics.median(abs(value - median) for value in logarithms)
    print(f"Processor seconds; the budget is scaled by {scale:.2f}, this machine's speed; the median program took "
          f"{slower:.2f} times its share or less, with a spread of {100 * spread:.0f} %.\n")
    print(f"{'program':44}{'took':>9}{'budget':>9}")
    over = []

    def row(name, seconds):
        share = max(budget.get(name, 0.0), LEAST_SHARE) * scale
        by_spread = math.exp(ALLOWED_DEVIATIONS * spread)
        allowed = ALLOWED if name in ("tests", "total") else slower * max(ALLOWED, by_spread)
        excess = seconds > allowed * share
        if excess:
            over.append(f"{name} took {seconds:.1f} processor seconds, more than {allowed:.2f} times its {share:.1f}")
        print(f"{name:44}{seconds:9.1f}{share:9.1f}" + ("  <-- over" if excess else ""))

    for name, seconds in spent.most_common():
        row(name, seconds)
    tests = sum(spent.values())
    print()
    if asked.build is not None:
        row("build", asked.build)
    row("tests", tests)
    if asked.build is not None:
        row("total", tests + asked.build)
    print("\nThe twenty dearest cases:")
    for seconds, name in cases_in(asked.folder)[:20]:
        print(f"{seconds:9.1f}  {name}")
    for line in over:
        print(("budget: " if asked.enforce else "warning: ") + line + " (tests/budget.txt)", file=sys.stderr)
    return 1 if over and asked.enforce else 0


def main():
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("calibrate").add_argument("--until-killed", action="store_true")
    for name in ("report", "budget"):
        command = commands.add_parser(name)
        command.add_argument("folder", type=pathlib.Path)
        if name == "report":
            command.add_argument("budget", type=pathlib.Path)
            command.add_argument("--enforce", action="store_true")
        command.add_argument("--build", type=float)
        command.add_argument("--calibration", type=float, nargs="+", required=True)
    asked = parser.parse_args()
    if asked.command == "calibrate" and asked.until_killed:
        calibrate_until_killed()
    elif asked.command == "calibrate":
        print(f"{calibrate():.3f}")
    elif asked.command == "report":
        sys.exit(report(asked))
    else:
        spent = totals_in(asked.folder)
        rows = {"calibration": statistics.mean(asked.calibration), "build": asked.build, **dict(spent.most_common())}
        print("\n".join(f"{name} {seconds:.3f}" if name == "calibration" else f"{name} {seconds:.1f}"
                        for name, seconds in rows.items()))


main()
