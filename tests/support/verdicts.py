#!/usr/bin/python3
"""Runs entries of ctest one by one and keeps each verdict with the commit, so that a run can be stopped and taken up again.

  verdicts.py BUILD [-j JOBS] [--tree FOLDER] [-- ARGUMENT ...]
        runs the entries that ctest chooses by these arguments (-L, -LE, -R, -E), but for those that have passed at this
        very state of the tree, which is this repository. Prints the table of their verdicts. The exit status is 1 unless
        all passed, and 130 where the run was stopped (SIGINT, SIGTERM).

BUILD/verdicts.tsv gets a line as each entry ends: state, entry, verdict, seconds, processor seconds, cases. The state is the
commit, with a hash of what differs from it where the tree is not clean. The cases are "all", or a hash of the list
PHOTOND_TEST_CASES. BUILD/verdicts/ENTRY.log has what the entry printed last. To run all again, remove BUILD/verdicts.tsv.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

from file_graph import ROOT, repository_files

COLUMNS = ("state", "entry", "verdict", "seconds", "processor_seconds", "cases")
PASSED, FAILED, MISSING = "passed", "failed", "missing"
STOPPED = 130  # exit status, as shells have it
SECONDS_TO_CLEAN_UP = 10  # of an entry that is interrupted


def state_of_tree(root=ROOT):
    """The commit and, where the tree differs from it, a hash of how. Without a repository: a hash of all files."""
    files = hashlib.sha256()
    head = subprocess.run(["git", "-C", root, "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
    if head.returncode != 0 or not (root / ".git").exists():
        for name in repository_files(root):
            files.update(f"{name}\0".encode() + (root / name).read_bytes())
        return f"tree-{files.hexdigest()[:16]}"
    differs = subprocess.run(["git", "-C", root, "diff", "--binary", "--no-ext-diff", "HEAD"], capture_output=True, check=True).stdout
    untracked = subprocess.run(["git", "-C", root, "ls-files", "-z", "--others", "--exclude-standard"], capture_output=True,
                               text=True, check=True).stdout
    names = [name for name in untracked.split("\0") if name]
    if not differs and not names:
        return head.stdout.strip()
    files.update(differs)
    for name in sorted(names):
        files.update(f"{name}\0".encode() + (root / name).read_bytes())
    return f"{head.stdout.strip()}+dirty-{files.hexdigest()[:12]}"


class Ledger:
    """The lines of BUILD/verdicts.tsv. A line that was cut off does not count."""

    def __init__(self, build, state):
        self.path = pathlib.Path(build) / "verdicts.tsv"
        self.state = state
        self._lock = threading.Lock()
        text = self.path.read_text() if self.path.exists() else ""
        self._rows = [dict(zip(COLUMNS, fields)) for line in text.split("\n")[:-1]
                      if len(fields := line.split("\t")) == len(COLUMNS)]

    def add(self, entry, verdict, seconds, processor_seconds, cases="all"):
        row = (self.state, entry, verdict, f"{seconds:.1f}", f"{processor_seconds:.1f}", cases)
        with self._lock:
            self._rows.append(dict(zip(COLUMNS, row)))
            with open(self.path, "ab+") as out:
                out.seek(max(0, out.seek(0, os.SEEK_END) - 1))
                cut_off = out.read(1) not in (b"", b"\n")
                out.write((("\n" if cut_off else "") + "\t".join(row) + "\n").encode())
                out.flush()
                os.fsync(out.fileno())

    def last(self, entry, cases="all"):
        """The last row of an entry at this state, for these cases or for all; None where there is none."""
        return next((row for row in reversed(self._rows) if row["state"] == self.state and row["entry"] == entry and
                     row["cases"] in ("all", cases)), None)

    def has_passed(self, entry, cases="all"):
        row = self.last(entry, cases)
        return row is not None and row["verdict"] == PASSED

    def seconds_once(self, entry):
        """How long an entry last took, at whatever state; 0 where nobody knows."""
        return next((float(row["seconds"]) for row in reversed(self._rows) if row["entry"] == entry), 0.0)


class Entry:
    """One of ctest's: its command and its properties."""

    def __init__(self, described):
        properties = {item["name"]: item["value"] for item in described.get("properties", ())}
        self.name = described["name"]
        self.command = described.get("command")
        self.environment = dict(line.split("=", 1) for line in properties.get("ENVIRONMENT", ()))
        self.folder = properties.get("WORKING_DIRECTORY")
        self.limit_seconds = float(properties.get("TIMEOUT", 1500))
        self.order = float(properties.get("COST", 0))
        self.has_cases = any(word.startswith("--gtest_filter") for word in self.command or ())


def entries_of(build, arguments):
    shown = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", *arguments], check=True, capture_output=True)
    return [Entry(test) for test in json.loads(shown.stdout)["tests"]]


class Children:
    """The commands that several threads run, all of which can be stopped."""

    def __init__(self):
        self.stopped = False
        self._running = set()
        self._lock = threading.Lock()

    def run(self, command, output, limit_seconds=None, **how):
        """(exit status, seconds, processor seconds). What the command prints goes to the file `output`. After
        `limit_seconds` it and its group are killed."""
        began = time.monotonic()
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                                   start_new_session=True, **how)
        with self._lock:
            self._running.add(process)
            if self.stopped:  # in the moment between
                process.kill()
        timer = threading.Timer(limit_seconds or 0, self._signal, (process, signal.SIGKILL))
        if limit_seconds:
            timer.start()
        _, status, used = os.wait4(process.pid, 0)
        timer.cancel()
        with self._lock:
            self._running.remove(process)
            process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, time.monotonic() - began, used.ru_utime + used.ru_stime

    def stop(self):
        """Interrupts what runs, and kills what does not end by that."""
        with self._lock:
            self.stopped = True
        for sign in (signal.SIGINT, signal.SIGKILL):
            for process in list(self._running):
                self._signal(process, sign)
            end = time.monotonic() + SECONDS_TO_CLEAN_UP
            while self._running and time.monotonic() < end:
                time.sleep(0.05)

    @staticmethod
    def _signal(process, sign):
        try:
            os.killpg(process.pid, sign)
        except ProcessLookupError:
            pass


class Run:
    """The entries that have not passed yet, several at a time."""

    def __init__(self, build, entries, ledger, jobs):
        self.build = pathlib.Path(build)
        self.ledger = ledger
        self.entries = entries
        self.jobs = jobs
        self.ran = set()
        self._children = Children()
        self._lock = threading.Lock()
        listed = os.environ.get("PHOTOND_TEST_CASES")
        self._listed = "list-" + hashlib.sha256(pathlib.Path(listed).read_bytes()).hexdigest()[:12] if listed else "all"

    def cases(self, entry):
        return self._listed if entry.has_cases else "all"

    def all(self):
        """False where the run was stopped."""
        left = [entry for entry in self.entries if not self.ledger.has_passed(entry.name, self.cases(entry))]
        left.sort(key=lambda entry: -max(self.ledger.seconds_once(entry.name), entry.order))
        print(f"entries chosen at {self.ledger.state}: {len(self.entries)}; passed before: {len(self.entries) - len(left)}",
              flush=True)
        (self.build / "verdicts").mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory() as times, concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            futures = [pool.submit(self.one, entry, times) for entry in left]
            try:
                for future in concurrent.futures.as_completed(futures):
                    future.result()
            except KeyboardInterrupt:
                pool.shutdown(wait=False, cancel_futures=True)
                self._children.stop()
                return False
        return True

    def one(self, entry, times):
        log = self.build / "verdicts" / f"{entry.name}.log"
        with open(log, "wb") as output:
            try:
                status, seconds, used = self._children.run(
                    entry.command, output, entry.limit_seconds, cwd=entry.folder,
                    env={**os.environ, **entry.environment, "PHOTOND_TEST_TIMES": times})  # where tests/support/metered waits for all
            except (OSError, TypeError) as fault:  # it was not built
                output.write(f"{fault}\n".encode())
                status, seconds, used = -1, 0.0, 0.0
        with self._lock:
            if self._children.stopped:  # which says nothing of the entry
                return
            verdict = PASSED if status == 0 else FAILED
            self.ledger.add(entry.name, verdict, seconds, used, self.cases(entry))
            self.ran.add(entry.name)
            if status != 0:
                sys.stdout.write(log.read_text(errors="replace"))
                late = f" (killed after {entry.limit_seconds:.0f} s)" if seconds >= entry.limit_seconds else ""
                print(f"exit status {status}{late}: {' '.join(entry.command or [entry.name])}")
            print(f"{len(self.ran):4}  {verdict}  {seconds:8.1f} s  {entry.name}", flush=True)

    def verdict(self, entry):
        row = self.ledger.last(entry.name, self.cases(entry))
        return row["verdict"] if row else MISSING

    def print_table(self):
        print(f"\n{'entry':44}{'verdict':>9}{'seconds':>10}{'processor':>11}")
        for entry in sorted(self.entries, key=lambda entry: (self.verdict(entry) == PASSED, entry.name)):
            row = self.ledger.last(entry.name, self.cases(entry)) or {"seconds": "-", "processor_seconds": "-"}
            when = "" if entry.name in self.ran or self.verdict(entry) == MISSING else "  before"
            print(f"{entry.name:44}{self.verdict(entry):>9}{row['seconds']:>10}{row['processor_seconds']:>11}{when}")
        counts = {verdict: sum(self.verdict(entry) == verdict for entry in self.entries) for verdict in (PASSED, FAILED, MISSING)}
        print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()), flush=True)


def heed_signals():
    """Has SIGINT and SIGTERM raise KeyboardInterrupt, also where a shell started this in the background."""
    for sign in (signal.SIGINT, signal.SIGTERM):
        signal.signal(sign, signal.default_int_handler)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("-j", dest="jobs", type=int, default=1)
    parser.add_argument("--tree", type=pathlib.Path, default=ROOT)
    arguments = sys.argv[1:]
    at = arguments.index("--") if "--" in arguments else len(arguments)
    asked = parser.parse_args(arguments[:at])
    heed_signals()
    entries = entries_of(asked.build, arguments[at + 1:])
    if not entries:
        sys.exit(f"no entry of {asked.build} fits {' '.join(arguments[at + 1:])}")
    run = Run(asked.build, entries, Ledger(asked.build, state_of_tree(asked.tree)), asked.jobs)
    whole = run.all()
    run.print_table()
    if not whole:
        print("stopped: the same command goes on from here")
        return STOPPED
    return int(any(run.verdict(entry) != PASSED for entry in entries))


if __name__ == "__main__":
    sys.exit(main())
