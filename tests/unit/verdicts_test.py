"""The keeper of verdicts runs what has not passed at this state of the tree, and nothing else, however a run ended."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SUPPORT = pathlib.Path(__file__).resolve().parents[1] / "support"
sys.path.insert(0, str(SUPPORT))

from file_graph import ROOT  # noqa: E402
from verdicts import COLUMNS, Ledger, state_of_tree  # noqa: E402

# Each writes a line when it runs. The second fails and the third sleeps on, until a file says that they are mended.
PLANTED = {"unit.passes": "echo >>passes.runs", "unit.fails": "echo >>fails.runs; echo why it failed; test -e mended",
           "unit.sleeps": "echo >>sleeps.runs; test -e mended || exec sleep 100000",
           "service.other": "echo >>other.runs"}


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def git(self, *arguments):
        return subprocess.run(["git", "-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false", *arguments],
                              cwd=self.tree, check=True, capture_output=True, text=True).stdout.strip()

    def make_tree(self):
        self.tree = self.folder / "tree"
        self.tree.mkdir()
        self.git("init", "-q", "-b", "main")
        (self.tree / "a").write_text("a")
        self.git("add", "a")
        self.git("commit", "-q", "-m", "m")


@unittest.skipUnless(shutil.which("git"), "there is no git")
class Resuming(Case):
    def setUp(self):
        super().setUp()
        self.make_tree()
        self.build = self.folder / "build"
        self.build.mkdir()
        lines = (f'add_test([=[{name}]=] "sh" "-c" "{command}")\n'
                 f'set_tests_properties([=[{name}]=] PROPERTIES LABELS "{name.split(".")[0]}" WORKING_DIRECTORY "{self.build}")\n'
                 for name, command in PLANTED.items())
        (self.build / "CTestTestfile.cmake").write_text("".join(lines))

    def start(self, *arguments):
        command = [sys.executable, SUPPORT / "verdicts.py", self.build, "--tree", self.tree, "-j", "3", "--", "-L", "unit", *arguments]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def run_all(self, *arguments):
        """(exit status, what it said)"""
        process = self.start(*arguments)
        said, _ = process.communicate()
        return process.returncode, said

    def runs(self):
        return {name.split(".")[1]: len(file.read_text().splitlines()) if file.exists() else 0
                for name in PLANTED for file in [self.build / f"{name.split('.')[1]}.runs"]}

    def stop_in_the_middle(self, sign):
        """When all three have begun, and two of them have their verdicts."""
        process = self.start()
        ledger = self.build / "verdicts.tsv"
        while not (self.runs()["sleeps"] and ledger.exists() and ledger.read_text().count("\n") == 2):
            self.assertIsNone(process.poll(), "it ended before it was stopped")
            time.sleep(0.02)
        process.send_signal(sign)
        said, _ = process.communicate()
        return process.returncode, said

    def test_a_run_that_is_stopped_goes_on_where_it_was(self):
        status, said = self.stop_in_the_middle(signal.SIGINT)
        self.assertEqual(status, 130, said)
        self.assertIn("why it failed", said)
        self.assertRegex(said, r"unit\.sleeps +missing")
        self.assertIn("1 passed, 1 failed, 1 missing", said)
        self.assertEqual(self.runs(), {"passes": 1, "fails": 1, "sleeps": 1, "other": 0})
        (self.build / "mended").touch()
        status, said = self.run_all()
        self.assertEqual(status, 0, said)
        self.assertRegex(said, r"unit\.passes +passed.*before")
        self.assertEqual(self.runs(), {"passes": 1, "fails": 2, "sleeps": 2, "other": 0})
        self.assertEqual(self.run_all()[0], 0)
        self.assertEqual(self.runs(), {"passes": 1, "fails": 2, "sleeps": 2, "other": 0})

    def test_what_it_was_running_is_gone_when_it_was_stopped(self):
        status, said = self.stop_in_the_middle(signal.SIGTERM)
        self.assertEqual(status, 130, said)
        left = [entry for entry in pathlib.Path("/proc").glob("[0-9]*/cwd")
                if os.path.lexists(entry) and self.folder_of(entry) == str(self.build)]
        self.assertEqual(left, [])

    @staticmethod
    def folder_of(link):
        try:
            return os.readlink(link)
        except OSError:
            return ""

    def test_another_state_of_the_tree_runs_all_again(self):
        (self.build / "mended").touch()
        self.assertEqual(self.run_all()[0], 0)
        (self.tree / "a").write_text("b")
        self.assertEqual(self.run_all()[0], 0)
        self.assertEqual(self.runs(), {"passes": 2, "fails": 2, "sleeps": 2, "other": 0})
        states = [line.split("\t")[0] for line in (self.build / "verdicts.tsv").read_text().splitlines()]
        self.assertEqual(states[0], self.git("rev-parse", "HEAD"))
        self.assertTrue(states[-1].startswith(states[0] + "+dirty-"), states[-1])
        (self.tree / "a").write_text("a")  # as it was
        self.assertEqual(self.run_all()[0], 0)
        self.assertEqual(self.runs()["passes"], 2)

    def test_what_is_chosen(self):
        self.assertEqual(self.run_all("-R", "passes")[0], 0)
        self.assertEqual(self.run_all("-R", "passes|fails", "-E", "passes")[0], 1)
        self.assertEqual(self.run_all("-R", "no such name")[0], 1)
        self.assertEqual(self.runs(), {"passes": 1, "fails": 1, "sleeps": 0, "other": 0})


class Lines(Case):
    def ledger(self, state="S"):
        return Ledger(self.folder, state)

    def test_the_last_verdict_counts(self):
        self.ledger().add("unit.a", "failed", 1.0, 2.0)
        self.ledger().add("unit.a", "passed", 3.0, 4.0)
        self.assertTrue(self.ledger().has_passed("unit.a"))
        self.ledger().add("unit.a", "failed", 1.0, 2.0)
        self.assertFalse(self.ledger().has_passed("unit.a"))
        self.assertFalse(self.ledger("other").last("unit.a"))
        self.assertEqual(self.ledger("other").seconds_once("unit.a"), 1.0)

    def test_some_cases_are_not_all(self):
        self.ledger().add("unit.a", "passed", 1.0, 1.0, "list-1")
        self.assertTrue(self.ledger().has_passed("unit.a", "list-1"))
        self.assertFalse(self.ledger().has_passed("unit.a", "list-2"))
        self.assertFalse(self.ledger().has_passed("unit.a"))
        self.ledger().add("unit.a", "passed", 1.0, 1.0)
        self.assertTrue(self.ledger().has_passed("unit.a", "list-2"))

    def test_a_line_that_was_cut_off_does_not_count(self):
        whole = "\t".join(("S", "unit.a", "passed", "1.0", "1.0", "all"))
        self.assertEqual(len(whole.split("\t")), len(COLUMNS))
        (self.folder / "verdicts.tsv").write_text(whole + "\n" + whole.replace("unit.a", "unit.b"))
        self.assertFalse(self.ledger().has_passed("unit.b"))
        self.ledger().add("unit.c", "passed", 1.0, 1.0)
        self.assertTrue(self.ledger().has_passed("unit.a") and self.ledger().has_passed("unit.c"))


class State(Case):
    @unittest.skipUnless(shutil.which("git"), "there is no git")
    def test_of_a_repository(self):
        self.make_tree()
        states = [state_of_tree(self.tree)]
        (self.tree / "a").write_text("b")
        states.append(state_of_tree(self.tree))
        self.git("add", "a")
        self.assertEqual(state_of_tree(self.tree), states[-1], "staged or not")
        (self.tree / "new").write_text("c")
        states.append(state_of_tree(self.tree))
        (self.tree / "new").write_text("d")
        states.append(state_of_tree(self.tree))
        self.assertEqual(len(set(states)), 4)
        self.assertEqual(states[0], self.git("rev-parse", "HEAD"))

    def test_of_a_copy(self):
        (self.folder / "a").write_text("a")
        before = state_of_tree(self.folder)
        self.assertEqual(state_of_tree(self.folder), before)
        (self.folder / "a").write_text("b")
        self.assertNotEqual(state_of_tree(self.folder), before)


class Tidy(Case):
    """`tests/run --tidy` with a compiler and a clang-tidy of our own."""

    SOURCES = ("protocol/problem.cpp", "protocol/job.cpp", "protocol/camera_path.cpp")

    def setUp(self):
        super().setUp()
        for name, text in (("cc", 'cat "$1"'), ("clang-tidy", f"""[ "$1" != --version ] || exit 0
                            for source; do :; done; name=$(basename $source); echo >>{self.folder}/$name.runs
                            [ $name != job.cpp ] || test -e {self.folder}/mended || {{ echo a fault; exit 1; }}
                            [ $name != camera_path.cpp ] || test -e {self.folder}/mended || exec sleep 100000""")):
            (self.folder / name).write_text(f"#!/bin/sh\n{text}\n")
            (self.folder / name).chmod(0o755)
        commands = [{"directory": str(self.folder), "file": str(ROOT / source), "command": f"{self.folder}/cc {ROOT / source}"}
                    for source in self.SOURCES]
        (self.folder / "compile_commands.json").write_text(json.dumps(commands))

    def start(self):
        return subprocess.Popen([sys.executable, SUPPORT / "tidy.py", self.folder, self.folder / "passed.tsv", *(ROOT / source for source in self.SOURCES)],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"})

    def runs(self):
        return [len(file.read_text().splitlines()) if file.exists() else 0
                for source in self.SOURCES for file in [self.folder / f"{pathlib.Path(source).name}.runs"]]

    def verdicts(self):
        ledger = self.folder / "verdicts.tsv"
        return [tuple(line.split("\t")[1:3]) for line in ledger.read_text().splitlines()] if ledger.exists() else []

    def test_what_has_passed_is_remembered(self):
        process = self.start()
        while len(self.verdicts()) < 2 or self.runs()[2] == 0:
            self.assertIsNone(process.poll(), "it ended before it was stopped")
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate()
        self.assertEqual(process.returncode, 130, said)
        self.assertIn("a fault", said)
        self.assertEqual(sorted(self.verdicts()), [("protocol/job.cpp", "failed"), ("protocol/problem.cpp", "passed")])
        (self.folder / "mended").touch()
        process = self.start()
        said, _ = process.communicate()
        self.assertEqual(process.returncode, 0, said)
        self.assertEqual(self.runs(), [1, 2, 2])
        rows = [line.split("\t") for line in (self.folder / "passed.tsv").read_text().splitlines()]
        self.assertEqual([(name, commit) for name, _, commit in rows], [(name, state_of_tree()) for name in sorted(self.SOURCES)])
        self.assertEqual(sorted(self.verdicts()[2:]), [("protocol/camera_path.cpp", "passed"), ("protocol/job.cpp", "passed")])


if __name__ == "__main__":
    unittest.main()
