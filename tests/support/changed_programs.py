#!/usr/bin/python3
"""Chooses the entries of ctest that a change can reach.

  changed_programs.py [BASE]                 prints the changed files and the chosen entries, each with its reason
  changed_programs.py [BASE] --plan FOLDER   also writes for tests/run: FOLDER/expression (of the entries, for ctest -R),
                                             FOLDER/targets (what must be built), FOLDER/sources (changed C++ files) and
                                             FOLDER/cases (for PHOTOND_TEST_CASES; empty where whole entries are run)
  changed_programs.py --of FILE ...          prints the entries that a change of these files would choose

The change is what differs between the working tree and the merge base of HEAD and BASE, untracked files included. Without
BASE the main branch is taken (changed_files.py).

Where one program runs all browser tests (BROWSER_RUNNER), each file of them is chosen like an entry of its own.

An entry is chosen where the graph of files (file_graph.py) leads from its sources to a changed file, or where a row of
tests/reach.txt says so. A changed file of which neither knows anything chooses everything.
"""

import argparse
import collections
import pathlib
import re
import sys

from changed_files import NoBase, Repository
from file_graph import CODE, PROGRAMS, ROOT, FileGraph, read_texts, repository_files
from reach_table import EVERYTHING, NOTHING, expand, table_of

CPP_TEST = re.compile(r"tests/(unit|statistical)/(\w+)/(gpu_)?\w+_test\.cpp")
PYTHON_TEST = re.compile(r"tests/(unit|service|hard_cases)/(\w+_test)\.py")
BROWSER_TEST = re.compile(r"tests/(dashboard)/(\w+)\.test\.mjs")
BROWSER_RUNNER, BROWSER_ENTRY = "tests/dashboard/run_tests.mjs", "dashboard.browser"
ALL_CASES_BUT_LONG = "*-*Long*"  # of a GoogleTest program, whose own choice PHOTOND_TEST_CASES replaces
OTHER_ENTRIES = {"tests/dashboard/package-lock.json": "dashboard.packages", "clients/dashboard/vitest.config.ts": "dashboard.logic",
                 "clients/dashboard/tsconfig.json": "dashboard.types"}
DECLARATION = re.compile(r"renderer/methods/(\w+)/(row\.cpp|params\.\w+)")
FAULT_LAYER = "tests/support/vulkan_fault_layer.cpp"


def entries_of(files):
    """Entry of ctest -> its sources, as tests/CMakeLists.txt makes them; those of the labelled long runs are not among them."""
    entries = collections.defaultdict(set)
    for name in files:
        if match := CPP_TEST.fullmatch(name):
            entries[f"{match[1]}.{match[3] or ''}{match[2]}"].add(name)
        elif match := PYTHON_TEST.fullmatch(name) or BROWSER_TEST.fullmatch(name):
            entries[f"{match[1]}.{match[2]}"].add(name)
        elif name in OTHER_ENTRIES:
            entries[OTHER_ENTRIES[name]].add(name)
    return dict(entries)


class Reach:
    """Which entries the files of a tree reach."""

    def __init__(self, files, texts, table, gone=()):
        """`gone`: files of the base that are there no more; their texts may be among `texts`."""
        self.files = sorted({*files, *gone})
        self.entries = entries_of(files)
        self.graph = FileGraph(self.files, texts)
        self.rows = [row for row in table if row.chooses]
        for row in table:
            if not row.chooses:
                right = expand(row.right, self.files)
                for name in expand(row.left, self.files):
                    self.graph.add(name, right)
        for name in filter(BROWSER_TEST.fullmatch, self.files):
            self.graph.add(name, {BROWSER_RUNNER})
        self.takers = collections.defaultdict(set)
        for name, others in self.graph.takes.items():
            for other in others:
                self.takers[other].add(name)
        self.sources = {source: entry for entry, sources in self.entries.items() for source in sources}
        self.named_in_scripts = self.rooms_in_scripts(texts)

    def rooms_in_scripts(self, texts):
        """Room of a method -> the scripts of a daemon's tests that name it. Browser tests that look at what a method declares
        are rows of the table."""
        named = collections.defaultdict(set)
        word = re.compile(r"\b(" + "|".join(map(re.escape, self.graph.rooms)) + r")\b")
        for name, text in texts.items():
            if name.startswith(("tests/service/", "tests/hard_cases/", "tests/support/")) and name.endswith(".py"):
                for room in set(word.findall(text)) if self.graph.rooms else ():
                    named[room].add(name)
        return named

    def entries_taking(self, starts):
        """Entry -> what one of its sources takes on the way to a file of `starts`; None where that source is the file."""
        towards = dict.fromkeys(starts)
        left = collections.deque(sorted(starts))
        found = {}
        while left:
            name = left.popleft()
            if name in self.sources:
                found.setdefault(self.sources[name], towards[name])
            for taker in sorted(self.takers[name]):
                if taker not in towards:
                    towards[taker] = name
                    left.append(taker)
        return found

    def by_graph(self, name):
        found = {entry: name + (f", through {through}" if through not in (None, name) else "")
                 for entry, through in self.entries_taking([name]).items()}
        if match := DECLARATION.fullmatch(name):
            for entry in self.entries_taking(self.named_in_scripts[match[1]]):
                found.setdefault(entry, f"{name}, whose method it names")
        return found

    def by_table(self, name):
        """({entry: reason}, whether a row beside the one for every change knows the file)."""
        found, known = {}, False
        for row in self.rows:
            if not expand(row.left, [name]):
                continue
            known |= not row.for_every_change
            right = ["*"] if EVERYTHING in row.right else [word for word in row.right if word != NOTHING]
            for entry in expand(right, self.entries):
                found.setdefault(entry, "any change" if row.for_every_change else f"{name}, reach.txt:{row.line}")
        return found, known

    def of(self, name):
        """{entry: reason} for a change of one file."""
        by_graph = self.by_graph(name) if name in self.graph.files else {}
        by_table, known = self.by_table(name)
        for entry in entries_of([name]):  # the rest of a program of which a source went
            known |= name not in self.sources
            if entry in self.entries:
                by_graph.setdefault(entry, name)
        if not by_graph and not known:
            return dict.fromkeys(self.entries, f"{name}, of which nothing is known")
        return {**by_table, **by_graph}

    def of_all(self, names):
        chosen = {}
        for name in names:
            for entry, reason in self.of(name).items():
                if entry not in chosen or chosen[entry] == "any change":
                    chosen[entry] = reason
        return chosen

    def is_part(self, entry):
        """Whether it is a file of browser tests that the entry of all of them runs."""
        return BROWSER_RUNNER in self.graph.files and any(map(BROWSER_TEST.fullmatch, self.entries[entry]))

    def of_ctest(self, entries):
        return {BROWSER_ENTRY if self.is_part(entry) else entry for entry in entries}

    def cases(self, chosen):
        """What PHOTOND_TEST_CASES has to list; nothing where whole entries are run."""
        parts = {entry.split(".")[1] for entry in chosen if self.is_part(entry)}
        whole = {entry.split(".")[1] for entry in self.entries if self.is_part(entry)}
        return [] if parts in (set(), whole) else [*sorted(parts), ALL_CASES_BUT_LONG]

    def targets(self, entry):
        """What must be built for an entry."""
        if CPP_TEST.fullmatch(min(self.entries[entry])):
            return {entry.replace(".", "_", 1)}
        if entry in ("dashboard.logic", "dashboard.types"):  # the daemon's build installs their packages
            return {"photond"}
        taken = self.graph.reached_from(self.entries[entry])
        return ({program for program, source in PROGRAMS.items() if source in taken} |
                ({"photond_vulkan_fault_layer"} if FAULT_LAYER in taken else set()))


def reach_of_tree(gone=None):
    """`gone`: the texts of files that are there no more and whose change counts."""
    files, gone = repository_files(), gone or {}
    texts = read_texts(files) | {name: text for name, text in gone.items() if name.endswith(CODE)}
    return Reach(files, texts, table_of(), gone)


def budget_seconds(reach):
    """Entry -> processor seconds that it may take (tests/budget.txt). Files of browser tests share theirs alike."""
    seconds = {}
    for line in (ROOT / "tests/budget.txt").read_text().splitlines():
        match = re.match(r"(\w+\.\w+)\s+([\d.]+)", line)
        if match:
            seconds[match[1]] = float(match[2])
    parts = [entry for entry in reach.entries if reach.is_part(entry)]
    return seconds | {entry: seconds.get(BROWSER_ENTRY, 0.0) / len(parts) for entry in parts}


def print_chosen(chosen, reach):
    seconds = budget_seconds(reach)
    print(f"{len(chosen)} of {len(reach.entries)} entries, {sum(seconds.get(entry, 0.0) for entry in chosen):.0f} processor "
          "seconds by tests/budget.txt beside the build:")
    for entry in sorted(chosen, key=lambda entry: (-seconds.get(entry, 0.0), entry)):
        print(f"{seconds.get(entry, 0.0):8.1f}  {entry:44} {chosen[entry]}")


def write_plan(folder, chosen, reach, changed):
    expression = "^(" + "|".join(re.escape(entry) for entry in sorted(reach.of_ctest(chosen))) + ")$" if chosen else ""
    targets = sorted(set().union(*(reach.targets(entry) for entry in chosen)))
    sources = [name for name in changed if name.endswith((".cpp", ".h")) and (ROOT / name).exists() and
               name.startswith(("protocol/", "renderer/", "server/", "clients/", "tests/"))]
    for name, lines in (("expression", [expression] if expression else []), ("targets", targets), ("sources", sources),
                        ("cases", reach.cases(chosen))):
        (folder / name).write_text("".join(line + "\n" for line in lines))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("base", nargs="?")
    parser.add_argument("--plan", type=pathlib.Path)
    parser.add_argument("--of", nargs="+", metavar="FILE")
    asked = parser.parse_args()
    if asked.of:
        reach = reach_of_tree()
        print_chosen(reach.of_all(asked.of), reach)
        return 0
    try:
        repository = Repository(ROOT)
        base, reason = repository.base(asked.base)
        changed = repository.files_since(base)
        gone = repository.texts_gone_since(base, changed)
    except NoBase as fault:
        print(f"--changed: {fault}", file=sys.stderr)
        return 1
    reach = reach_of_tree(gone)
    print(f"Compared with {base[:10]}, {reason}, {len(changed)} files changed:")
    for name in changed:
        print(f"  {name}" + (" (gone)" if name in gone else ""))
    chosen = reach.of_all(changed)
    print_chosen(chosen, reach)
    if asked.plan:
        write_plan(asked.plan, chosen, reach, changed)
    return 0


if __name__ == "__main__":
    sys.exit(main())
