"""The patches of tests/defects apply to this tree, say all of themselves, and leave no library and no method out; and what
judges them, tests/defects/run, in small."""

import importlib.machinery
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(SOURCE / "tests" / "support"))

import defect_patches  # noqa: E402
from defect_patches import Check, faults_of, kind_of, kinds_of, read_patch, read_patches  # noqa: E402

LEAST_PATCHES = 40


def applies(patch, root):
    """What keeps the patch from being applied below a folder, or nothing."""
    if (root / ".git").exists() and shutil.which("git"):
        command = ["git", "-c", "safe.directory=*", "apply", "--check", str(patch.path)]
    else:
        command = ["patch", "-p1", "--dry-run", "--batch", "--forward", "--fuzz=0", "-i", str(patch.path)]
    done = subprocess.run(command, cwd=root, check=False, capture_output=True, text=True)
    return "" if done.returncode == 0 else done.stderr + done.stdout


def runner():
    """tests/defects/run as a module."""
    loader = importlib.machinery.SourceFileLoader("defects_run", str(SOURCE / "tests" / "defects" / "run"))
    spec = importlib.util.spec_from_loader(loader.name, loader)
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


class Patches(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.patches = read_patches(SOURCE / "tests" / "defects")

    def test_each_applies_to_this_tree(self):
        for patch in self.patches:
            with self.subTest(patch=patch.name):
                self.assertEqual(applies(patch, SOURCE), "")

    def test_each_says_all_of_itself(self):
        for patch in self.patches:
            with self.subTest(patch=patch.name):
                self.assertEqual(faults_of(patch), [])

    def test_each_is_to_be_caught_by_entries_that_there_are(self):
        entries = defect_patches.known_entries(SOURCE)
        for patch in self.patches:
            for check in patch.checks:
                self.assertIn(check.entry, entries, patch.name)

    def test_there_are_forty_and_every_library_and_method_has_one(self):
        self.assertGreaterEqual(len(self.patches), LEAST_PATCHES)
        of_libraries = {patch.fields.get("Library") for patch in self.patches} - {None}
        of_methods = {patch.fields.get("Method") for patch in self.patches} - {None}
        self.assertEqual(of_libraries, defect_patches.libraries(SOURCE))
        self.assertEqual(of_methods, defect_patches.methods(SOURCE))

    def test_each_kind_of_test_has_some(self):
        self.assertEqual({patch.kind for patch in self.patches}, set(defect_patches.KINDS))


HEAD = ("Defect: One is left out.\nLibrary: renderer/core\nBuild: unit_core\nCaught by: unit.core Sums.*\nKind: exact\n"
        "\n")
DIFF = ("diff --git a/renderer/core/sum.cpp b/renderer/core/sum.cpp\n--- a/renderer/core/sum.cpp\n+++ b/renderer/core/sum.cpp\n"
        "@@ -1,3 +1,3 @@\n int sum(int n) {\n-    return n + 1;\n+    return n;\n }\n")
BEFORE = "int sum(int n) {\n    return n + 1;\n}\n"


class Heads(unittest.TestCase):
    """The test of the test."""

    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "a.patch")
            path.write_text(text)
            return read_patch(path)

    def test_a_good_one_has_no_fault(self):
        patch = self.read(HEAD + DIFF)
        self.assertEqual(faults_of(patch), [])
        self.assertEqual((patch.name, patch.place, patch.kind, patch.targets), ("a", "renderer/core", "exact", ["unit_core"]))
        self.assertEqual((patch.checks, patch.files), ([Check("unit.core", "Sums.*")], ["renderer/core/sum.cpp"]))

    def test_each_line_that_lacks_or_is_wrong_is_named(self):
        for line in HEAD.strip().splitlines():
            self.assertNotEqual(faults_of(self.read(HEAD.replace(line + "\n", "") + DIFF)), [], line)
        for good, wrong in (("Kind: exact", "Kind: browser"), ("Kind: exact", "Kind: good"), ("Defect:", "Defekt:"),
                            ("Library: renderer/core", "Library: renderer/film"),
                            ("Library: renderer/core", "Library: renderer/core\nMethod: path_tracing")):
            self.assertNotEqual(faults_of(self.read(HEAD.replace(good, wrong) + DIFF)), [], wrong)
        self.assertNotEqual(faults_of(self.read(HEAD)), [], "no diff")

    def test_the_kind_follows_from_the_entry_but_where_unit_tests_are_statistical(self):
        patch = self.read(HEAD.replace("exact", "statistical") + DIFF)
        self.assertEqual(faults_of(patch), [])
        self.assertEqual([kind_of(entry, patch) for entry in ("unit.core", "statistical.photons", "service.api_test", "dashboard.now")],
                         ["statistical", "statistical", "service", "browser"])
        self.assertEqual(kinds_of("dashboard.logic"), ("exact",))


class Runner(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_module = runner()

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_cases_are_said_as_each_runner_takes_them(self):
        of = self.run_module.with_cases
        self.assertEqual(of(["bin/unit_core", "--gtest_filter=-*Long*"], "Sums.*"), ["bin/unit_core", "--gtest_filter=Sums.*:-*Long*"])
        self.assertEqual(of(["/usr/bin/python3", "a_test.py"], "test_b"), ["/usr/bin/python3", "a_test.py", "-k", "test_b"])
        self.assertEqual(of(["node", "--test", "a.test.mjs"], "a b"), ["node", "--test", "--test-name-pattern=a b", "a.test.mjs"])
        self.assertEqual(of(["node", "vitest.mjs", "run"], "a.test.ts"), ["node", "vitest.mjs", "run", "a.test.ts"])
        self.assertEqual(of(["bin/a"], ""), ["bin/a"])

    def test_verdicts_are_found_again_and_a_line_that_was_cut_off_is_none(self):
        path = self.folder / "verdicts.tsv"
        verdicts = self.run_module.Verdicts(path)
        verdicts.add(commit="c", patch="p", name="a", verdict="missed")
        path.write_text(path.read_text() + "c\tp\tb\tcau")
        again = self.run_module.Verdicts(path)
        again.add(commit="c", patch="p", name="a", verdict="caught")
        third = self.run_module.Verdicts(path)
        self.assertEqual([line["verdict"] for line in third.lines], ["missed", "caught"])
        self.assertEqual(third.find(commit="c", patch="p", name="a")["verdict"], "caught")
        self.assertIsNone(third.find(commit="c", patch="p", name="b"))

    def test_a_patch_is_taken_away_also_where_the_run_was_killed(self):
        root = self.folder / "tree"
        source = root / "renderer/core/sum.cpp"
        source.parent.mkdir(parents=True)
        source.write_text(BEFORE)
        path = self.folder / "a.patch"
        path.write_text(HEAD + DIFF)
        patch = read_patch(path)
        tree = self.run_module.Tree(root, self.folder, None)
        self.assertTrue(tree.apply(patch))
        self.assertIn("return n;", source.read_text())
        self.run_module.Tree(root, self.folder, None)  # the next run
        self.assertEqual(source.read_text(), BEFORE)
        source.write_text(BEFORE.replace("n + 1", "n + 2"))
        self.assertFalse(tree.apply(patch))
        self.assertEqual(source.read_text(), BEFORE.replace("n + 1", "n + 2"))

    def test_the_case_that_failed_is_read_from_each_runner(self):
        for said, wanted in (("[  FAILED  ] Sums.AreRight (3 ms)\n", "Sums.AreRight"),
                             ("FAIL: test_sums (a_test.Sums.test_sums)\n", "test_sums"),
                             ("    not ok 2 - sums are right\nnot ok 1 - /a.test.mjs\n", "sums are right"),
                             ("✖ sums are right (12.3ms)\n", "sums are right"),
                             (" FAIL  src/a.test.ts > sums > are right\n", "src/a.test.ts > sums > are right")):
            self.assertEqual(next(match[1] for expression in self.run_module.FAILED_CASE if (match := expression.search(said))), wanted)
        for said in ("[==========] Running 0 tests from 0 test suites.", "Ran 0 tests in 0.000s", "# pass 0", "ℹ pass 0"):
            self.assertTrue(self.run_module.NOTHING_RAN.search(said), said)
        for said in ("[==========] Running 10 tests", "Ran 10 tests", "# pass 10"):
            self.assertFalse(self.run_module.NOTHING_RAN.search(said), said)


if __name__ == "__main__":
    unittest.main()
