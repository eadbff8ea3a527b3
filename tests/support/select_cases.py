#!/usr/bin/python3
"""The test cases of a build by name: LABEL.SUITE.CASE of GoogleTest's programs, LABEL.FILE of Python's and the browser's.

  select_cases.py BUILD [-L LABEL | -LE LABEL] [-R REGEX] [-E REGEX] --list
        prints every name that fits
  select_cases.py BUILD [-L LABEL | -LE LABEL] [-R REGEX] [-E REGEX] --cases FILE
        writes GoogleTest's cases and the browser's files to FILE, for PHOTOND_TEST_CASES, and prints the expression of
        the entries of ctest that hold what fits; the exit status is 3 where nothing does

Where -R stands several times, a name has to fit all of them; -E likewise leaves out what fits one of them.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

NOTHING_FITS = 3  # exit status


def entries(build, labels):
    """Of ctest: [(name, command)], the command without what meters it."""
    shown = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", *labels], check=True, capture_output=True)
    found = []
    for test in json.loads(shown.stdout)["tests"]:
        command = test["command"]
        found.append((test["name"], command[2:] if pathlib.Path(command[0]).name == "metered" else command))
    return found


def cases_of(command, known={}):
    """["SUITE.CASE", ...] of a GoogleTest program, ["FILE", ...] of the browser's, None of any other."""
    if command[-1].endswith("/run_tests.mjs"):
        return subprocess.run([*command, "--list"], check=True, capture_output=True, text=True).stdout.split()
    if not any(argument.startswith("--gtest_filter") for argument in command):
        return None
    key = tuple(command)
    if key not in known:
        listed = subprocess.run([*command, "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout
        known[key], suite = [], ""
        for line in listed.splitlines():
            name = line.split("#")[0].strip()
            if not line.startswith(" "):
                suite = name
            else:
                known[key].append(suite + name)
    return known[key]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("-L")
    parser.add_argument("-LE")
    parser.add_argument("-R", action="append", default=[])
    parser.add_argument("-E", action="append", default=[])
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--cases", type=pathlib.Path)
    asked = parser.parse_args()
    labels = [part for option, value in (("-L", asked.L), ("-LE", asked.LE)) if value for part in (option, value)]

    def fits(name):
        return all(re.search(wanted, name) for wanted in asked.R) and not any(re.search(other, name) for other in asked.E)

    names, cases, chosen = set(), set(), []
    for name, command in entries(asked.build, labels):
        of_program = cases_of(command)
        if of_program is None:
            if fits(name):
                names.add(name)
                chosen.append(name)
            continue
        label = name.split(".")[0]
        fitting = {case for case in of_program if fits(f"{label}.{case}")}
        names |= {f"{label}.{case}" for case in fitting}
        cases |= fitting
        if fitting:
            chosen.append(name)
    if asked.list:
        print("\n".join(sorted(names)))
    elif not chosen:
        words = [f"-R '{wanted}'" for wanted in asked.R] + [f"-E '{other}'" for other in asked.E]
        print(f"no test fits {' '.join(words)}", file=sys.stderr)
        sys.exit(NOTHING_FITS)
    else:
        asked.cases.write_text("".join(case + "\n" for case in sorted(cases)))
        print("^(" + "|".join(re.escape(name) for name in chosen) + ")$")


main()
