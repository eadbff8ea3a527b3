#!/usr/bin/python3
"""What a run of the tests cost, beside what it may cost (tests/budget.txt).

  test_costs.py calibrate                   prints how many processor seconds a fixed piece of work takes here and now
  test_costs.py calibrate --until-killed    prints it again and again, while the tests run
  test_costs.py report FOLDER BUDGET --build SECONDS --calibration SECONDS ... [--enforce]
        prints processor seconds by program beside their budget, and the twenty dearest cases; FOLDER is where the tests
        wrote them (PHOTOND_TEST_TIMES). --enforce: exit status 1 where a program took much more than its share.
  test_costs.py budget FOLDER BUDGET --build SECONDS --calibration SECONDS ...
        prints a new ledger: what this run took, and the reserves of the old one

The ledger (tests/budget.txt) has a line for each program, one for the build, and `reserved ISSUE SECONDS` for each change
that is still to come. The build, the programs and the reserves together are at most MOST_SECONDS
(tests/unit/budget_test.py).

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
MOST_SECONDS = 45 * 60  # processor seconds of the ledger as a whole


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


def read_ledger(file):
    """(calibration, {"build" or program: seconds}, {issue: seconds}); ValueError where a line is none, or is there twice."""
    calibration, programs, reserves = None, {}, {}
    for number, line in enumerate(file.read_text().splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        words = line.split()
        rows = reserves if words[0] == "reserved" else programs
        name = " ".join(words[:-1]).removeprefix("reserved ")
        if name in rows or len(words) != (3 if rows is reserves else 2):
            raise ValueError(f"{file}:{number}: '{line}' is no line of a ledger, or its name is there already")
        rows[name] = float(words[-1])
    calibration = programs.pop("calibration")
    return calibration, programs, reserves


def whole_of(programs, reserves):
    """Seconds of the ledger as a whole."""
    return sum(programs.values()) + sum(reserves.values())


def read_budget(file):
    calibration, programs, reserves = read_ledger(file)
    tests = sum(programs.values()) - programs["build"]
    return {**programs, "calibration": calibration, "tests": tests, "total": tests + programs["build"],
            "whole": whole_of(programs, reserves)}


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
    print(f"\nThe ledger with its reserves is {budget['whole'] / 60:.1f} of at most {MOST_SECONDS / 60:.0f} processor minutes.")
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
        command.add_argument("budget", type=pathlib.Path)
        if name == "report":
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
        print_ledger(asked)


def print_ledger(asked):
    comments = [line for line in asked.budget.read_text().splitlines() if line.startswith("#")]
    reserves = read_ledger(asked.budget)[2]
    print("\n".join(comments))
    print(f"calibration {statistics.mean(asked.calibration):.3f}")
    for issue, seconds in reserves.items():
        print(f"reserved {issue} {seconds:.0f}")
    print(f"build {asked.build:.0f}")
    for name, seconds in totals_in(asked.folder).most_common():
        print(f"{name} {seconds:.1f}")


if __name__ == "__main__":
    main()

