"""photonctl sequence and sequences: frames asked for, followed, saved, listed and removed."""

import json
import signal
import unittest

from photonctl_case import OK, REFUSED, USAGE, Case, cli
from photond_daemon import wait_until


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


SMALL = ["--width", "16", "--height", "12", "--passes", "1"]


class Sequences(Case):
    def test_frames_are_rendered_and_saved(self):
        done = self.run_ok("--json", "sequence", "moving/teleport", *SMALL, "--to", "1", "--fps", "2", "-o", "shots")
        sequence = json.loads(done.stdout)
        self.assertEqual((sequence["state"], [frame["time"] for frame in sequence["frames"]]), ("succeeded", [0, 0.5, 1]))
        self.assertEqual(sorted(path.name for path in (cli.folder / "shots").iterdir()), ["0000.exr", "0001.exr", "0002.exr"])
        self.assertIn("saved 3 frames in shots", done.stderr)
        self.run_ok("sequences", "fetch", sequence["id"], "--png", "-o", "pngs")
        self.assertEqual((cli.folder / "pngs" / "0002.png").read_bytes()[:4], b"\x89PNG")
        listed = self.run_ok("sequences", "list").stdout
        self.assertRegex(listed, rf"{sequence['id']} +succeeded +moving/teleport +path_tracing +3/3")
        self.assertIn("3 of 3 frames", self.run_ok("sequences", "show", sequence["id"]).stdout)
        self.assertEqual(cli.run("sequences", "cancel", "--purge", sequence["id"]).returncode, OK)
        self.assertEqual(cli.run("sequences", "show", sequence["id"]).returncode, REFUSED)

    def test_frames_are_saved_as_they_come(self):
        frames = cli.folder / "coming"
        process = cli.popen("sequence", "moving/teleport", "--width", "64", "--height", "64", "--passes", "4", "--to", "9", "--fps", "12",
                            "-o", "coming")
        try:
            wait_until(lambda: list(frames.glob("*.exr")), "a frame is saved", process, cli.daemon)
            self.assertIsNone(process.poll(), "the sequence is not over")
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate()
        newest = json.loads(self.run_ok("--json", "sequences", "list", "--limit", "1").stdout)
        self.run_ok("sequences", "remove", newest["id"])

    def test_what_is_large_is_said_before(self):
        done = cli.run("sequence", "moving/teleport", "--width", "1920", "--height", "1080", "--passes", "1", "--frames", "40",
                       "--fps", "20", "--no-wait")
        self.assertRegex(done.stderr, r"40 frames, \d.* GB of the disk")
        self.run_ok("sequences", "remove", done.stdout.strip())

    def test_a_turntable_and_parameters_of_the_method(self):
        done = self.run_ok("--json", "sequence", "cornell-box", *SMALL, "--frames", "2", "--turns", "0.1", "--eye", "0,2.7,3",
                           "--look-at", "0,2.7,-3", "--indirect-bounces", "1", "--noise", "still")
        request = json.loads(done.stdout)["request"]
        self.assertEqual(request["camera_path"], {"turns": 0.1})
        self.assertEqual((request["noise"], request["method"]["parameters"]["indirect_bounces"]), ("still", 1))

    def test_errors_by_frame(self):
        ids = [self.run_ok("--json", "sequence", "moving/teleport", *SMALL[:4], "--passes", passes, "--to", "1", "--fps", "2",
                           "--seed", seed).stdout for passes, seed in (("1", "1"), ("16", "100"), ("16", "200"))]
        shown, first, second = (json.loads(text)["id"] for text in ids)
        table = self.run_ok("sequences", "errors", shown, "--references", first, second).stdout.splitlines()
        self.assertRegex(table[0], r"FRAME +RELATIVE_MSE +FLICKER +LAG +MOTION")
        self.assertRegex(table[1], r"^ +0 +\S+ \(\S+ to \S+\) +- +- +-$")
        self.assertRegex(table[4], r"^ +mean( +\S+ \(\S+ to \S+\)){4}$")
        errors = json.loads(self.run_ok("--json", "sequences", "errors", shown, "--references", first, second).stdout)
        self.assertEqual(errors["references"], [first, second])
        self.assertEqual(cli.run("sequences", "errors", shown, "--references", first).returncode, USAGE)
        self.assertEqual(cli.run("sequences", "errors", shown, "--references", first, first).returncode, REFUSED)

    def test_a_preset_sets_methods_with_and_without_reuse_beside_each_other(self):
        options = ["compare", "--preset", "moving", "--part", "cornell-box", "--width", "16", "--height", "16"]
        self.run_ok(*options, "--frames", "4", "--passes", "1", "--reference-passes", "1", "-o", "moving.html",
                    "--json-report", "moving.json")
        report = json.loads((cli.folder / "moving-cornell-box.json").read_text())
        self.assertEqual((report["request"]["scene"], len(report["references"])), ("moving/cornell-box", 2))
        rows = {row["label"]: row for row in report["rows"]}
        self.assertEqual(len(rows), 12)
        for label, row in rows.items():
            self.assertEqual((row["passes"], len(row["errors"]["frames"])), (1, 4), label)
            self.assertIsNotNone(row["errors"]["mean"]["flicker"], label)
        page = (cli.folder / "moving-cornell-box.html").read_text()
        for label in rows:
            self.assertIn(label, page)
        missing = cli.run("compare", "--preset", "moving", "--part", "sponza")
        self.assertEqual(missing.returncode, USAGE)
        self.assertIn("sponza_moving.glb", missing.stderr)
        self.assertEqual(cli.run(*options, "--no-wait").returncode, USAGE)
        self.assertEqual(cli.run("compare", "cornell-box", "--entry", "path_tracing", "--passes", "1", "--frames", "2").returncode, USAGE)

    def test_an_estimate_and_what_is_refused(self):
        estimate = self.run_ok("sequence", "moving/cornell-box", *SMALL, "--frames", "100", "--dry-run").stdout
        self.assertRegex(estimate, r"^100 frames\nmemory .+\ndisk .+\ntime ")
        self.assertEqual(cli.run("sequence", "moving/cornell-box", *SMALL, "--time", "1").returncode, USAGE)
        refused = cli.run("sequence", "moving/cornell-box", *SMALL)
        self.assertEqual(refused.returncode, REFUSED)
        self.assertIn("/frames", refused.stderr)


if __name__ == "__main__":
    unittest.main()
