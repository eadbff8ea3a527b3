"""photonctl hard-cases: every method on the hard cases, against a daemon of its own.

The short form takes a handful of cases and sees that nothing happens that must never happen; the long class takes all.
What decides is tested by numbers in tests/unit/cli/hard_cases_verdict_test.cpp.
"""

import html.parser
import json
import os
import unittest

from photonctl_case import FAILED, USAGE, Case, cli, json_lines

# The short form with fewer photons and seeds than its own: what must never happen does not wait for more of them.
QUICK = ["--short", "--photons", "1000", "--seeds", "2"]
FIGURES = ("bias", "standard_error", "half_width")


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


def listed():
    """The daemon's hard cases that are scenes."""
    return cli.daemon.request("GET", "/v1/scenes?family=hard-cases&limit=1000").json


def cells(report):
    return [(case, cell) for case in report["cases"] for cell in case["cells"]]


class Page(html.parser.HTMLParser):
    """Elements left open, cells, and whatever would fetch something."""

    EMPTY = {"meta"}

    def __init__(self, text):
        super().__init__()
        self.open, self.rows, self.fetches = [], 0, []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.rows += tag == "tr"
        self.fetches += [value for name, value in attributes if name in ("src", "href")]
        self.fetches += [tag] * (tag in ("script", "link", "img", "iframe"))
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()


class TableCase(Case):
    def check_report(self, report):
        """What must never happen has not, and every figure that is said is there."""
        labels = [entry["label"] for entry in report["entries"]]
        for case, cell in cells(report):
            where = (case["name"], cell["entry"])
            self.assertEqual(cell["defects"], [], where)
            self.assertEqual([cell["nan_count"], cell["infinity_count"], cell["negative_count"]], [0, 0, 0], where)
            self.assertIn(cell["verdict"], ("holds", "breaks", "not applicable"), where)
            if cell["verdict"] == "not applicable":
                self.assertRegex(cell["text"], "^not applicable: .", where)
                continue
            self.assertEqual(cell["verdict"] == "holds", all(check["holds"] for check in cell["checks"]), where)
            shown = cell["checks"][cell["shown"]]
            self.assertEqual(shown["holds"], cell["verdict"] == "holds", where)
            for check in cell["checks"]:
                with_interval = check["relation"] not in ("zero", "finite")
                self.assertEqual([check[figure] is not None for figure in FIGURES], [with_interval] * 3, where)
                if with_interval and check["holds"] and check["relation"] != "at_most":
                    self.assertLessEqual(abs(check["bias"]), check["half_width"], where)
        for case in report["cases"]:
            self.assertEqual([cell["entry"] for cell in case["cells"]], [] if case["test"] else labels)
        counted = [cell["verdict"] for _, cell in cells(report)]
        self.assertEqual(report["summary"], {"holds": counted.count("holds"), "breaks": counted.count("breaks"),
                                             "not_applicable": counted.count("not applicable"), "defects": 0})

    def table(self, *arguments, **more):
        result = self.run_ok("hard-cases", *arguments, "--json-report", "table.json", "-o", "table.html", **more)
        return result, json.loads((cli.folder / "table.json").read_text())


class Short(TableCase):
    @classmethod
    def setUpClass(cls):
        scenes = listed()["items"]
        # One scene of each of some rows, the cheapest.
        rows = {}
        for scene in scenes:
            answer = scene["known_answer"]
            cost = answer["passes"] * answer["width"] * answer["height"]
            if any(check["relation"] == "same_as" for check in answer["checks"]):
                cost *= 2
            row = rows.setdefault(answer["case"], (cost, scene["name"]))
            rows[answer["case"]] = min(row, (cost, scene["name"]))
        cls.chosen = [name for _, name in sorted(rows.values())[:6]]

    def test_a_handful_of_cases_by_every_method(self):
        result, report = self.table(*QUICK, *self.chosen)
        self.check_report(report)
        self.assertEqual(sorted(case["scene"] for case in report["cases"] if case["scene"]), sorted(self.chosen))
        methods = {method["name"] for method in cli.daemon.request("GET", "/v1/methods").json["items"]
                   if "cpu" in method["devices"]}
        self.assertEqual({entry["method"]["name"] for entry in report["entries"]}, methods)
        self.assertIn("photon_mapping, direct", [entry["label"] for entry in report["entries"]])
        self.assertEqual(report["form"], "short")
        path_tracing = [cell for _, cell in cells(report) if cell["entry"] == "path_tracing"]
        self.assertTrue(path_tracing and all(cell["verdict"] != "breaks" for cell in path_tracing), path_tracing)
        # The three forms say the same.
        for case, cell in cells(report):
            self.assertIn(case["name"], result.stdout)
            self.assertIn(cell["text"], result.stdout)
        page = Page((cli.folder / "table.html").read_text())
        self.assertEqual((page.open, page.fetches), ([], []))
        self.assertGreaterEqual(page.rows, 1 + len(report["cases"]))
        # The jobs of cells that hold are gone, those of others are left to be looked at.
        left = {job["id"] for job in cli.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]}
        for _, cell in cells(report):
            if cell["verdict"] == "breaks":
                self.assertLessEqual(set(cell["jobs"]), left)
        in_broken = {job for _, cell in cells(report) if cell["verdict"] == "breaks" for job in cell["jobs"]}
        self.assertLessEqual(left, in_broken)

    def test_what_breaks_by_its_figure_fails_only_when_asked_to(self):
        # A photon map whose discs are as large as the scene cannot be right about the light in it: the table says by how
        # much, and exits with 0 unless --strict.
        broken = ["hard-cases", "--short", "--entries-only", "--json", "--entry",
                  "blurred=photon_mapping,gather=direct,radius_relative=0.9,search=radius"]
        [report] = json_lines(self.run_ok(*broken, *self.chosen))
        self.check_report(report)
        broken_cells = [cell for _, cell in cells(report) if cell["verdict"] == "breaks"]
        self.assertTrue(broken_cells)
        for cell in broken_cells:
            self.assertTrue(cell["text"].startswith("breaks: "), cell)
        self.assertTrue(any(cell["reason"] for cell in broken_cells), broken_cells)
        broken_scene = next(case["scene"] for case, cell in cells(report) if cell["verdict"] == "breaks")
        self.run_for(FAILED, *broken, broken_scene, "--strict")

    def test_a_refused_job_is_a_defect(self):
        result = self.run_for(FAILED, "hard-cases", *QUICK, "--entries-only", "--entry", "nowhere=path_tracing@gpu:7",
                              self.chosen[0], "--json")
        [report] = json_lines(result)
        [(_, cell)] = cells(report)
        self.assertEqual(cell["verdict"], "breaks")
        self.assertIn("refused", " ".join(cell["defects"]))
        self.assertEqual(report["summary"]["defects"], 1)

    def test_what_cannot_be_asked_is_said_before_anything_is_rendered(self):
        jobs = cli.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]
        for wrong, words in ((["no-such-case"], "no hard case"), (["-o", "table.pdf"], "table.pdf"),
                             (["--method", "path_trcing"], "did you mean path_tracing"), (["--entries-only"], "--entry"),
                             (["--entry", "a=path_tracing,indirect_bounces=2"], "which each case decides"),
                             (["--entry", "path_tracing"], "two entries"), (["--seeds", "1"], "--seeds")):
            with self.subTest(wrong=wrong):
                self.assertIn(words, self.run_for(USAGE, "hard-cases", "--short", *wrong).stderr)
        self.assertEqual(cli.daemon.request("GET", "/v1/jobs?limit=1000").json["items"], jobs)

    def test_the_list_has_scenes_and_tests(self):
        everything = listed()
        lines = json_lines(self.run_ok("hard-cases", "--list", "--json"))
        self.assertEqual(sorted(line["scene"] for line in lines if line["scene"]),
                         sorted(scene["name"] for scene in everything["items"]))
        self.assertEqual(sorted(line["test"] for line in lines if line["test"]),
                         sorted(test["test"] for test in everything["tests"]))
        text = self.run_ok("hard-cases", "--list").stdout
        for line in lines:
            self.assertIn(line["name"], text)


@unittest.skipUnless(os.environ.get("PHOTOND_LONG"), "by the label long")
class LongEverything(TableCase):
    """Every case by every method, with all passes and seeds."""

    def test_every_case_by_every_method(self):
        _, report = self.table()
        self.check_report(report)
        self.assertEqual(len([case for case in report["cases"] if case["scene"]]), len(listed()["items"]))
        for case, cell in cells(report):
            if cell["entry"] == "path_tracing" and cell["verdict"] == "breaks":
                print(f"path_tracing breaks {case['name']}: {cell['text']}")


if __name__ == "__main__":
    unittest.main()
