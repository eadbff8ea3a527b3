"""Errors, references, targets, extended and merged films, and comparisons, all by photonctl."""

import json
import re
import signal
import unittest

from photonctl_case import CANCELLED, INTERRUPTED, OK, REFUSED, TIMED_OUT, USAGE, Case, cli, json_lines

SIZE = ["--width", "24", "--height", "16"]
REFERENCE = ["--reference", "path_tracing:64"]


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


def get(path):
    return cli.daemon.request("GET", path)


class Errors(Case):
    """Of one job."""

    @classmethod
    def setUpClass(cls):
        result = cli.run("render", "cornell-box", *SIZE, "--passes", 8, *REFERENCE, "--metrics",
                         "flip_ldr,indirect:relative_mse", "--curve", "curve.csv", "--difference", "difference.exr", "--flip",
                         "flip.png", "--error-map", "error.png", "--film", "film")
        cls.output, cls.messages, cls.code = result.stdout, result.stderr, result.returncode
        items = get("/v1/jobs?state=succeeded&limit=1000").json["items"]
        cls.job = get(f"/v1/jobs/{next(job['id'] for job in items if job['request']['stop']['passes'] == 8)}").json

    def setUp(self):
        self.assertEqual(self.code, OK, self.messages)

    def test_the_report_has_the_errors_and_the_references_own_noise(self):
        error = self.job["statistics"]["error"]
        noise = self.job["statistics"]["reference_error"]
        interval = self.job["statistics"]["error_interval"]
        for metric in ("relative_mse", "flip_ldr", "indirect:relative_mse"):
            [row] = re.findall(rf"^ +{metric} +(\S+) +(\S+) +(-|\S+ to \S+)$", self.output, re.MULTILINE)
            self.assertAlmostEqual(float(row[0]) / error[metric], 1, delta=0.006)  # three digits
            if row[1] != "-":
                self.assertAlmostEqual(float(row[1]) / noise[metric], 1, delta=0.006)
            self.assertEqual(row[2] == "-", metric not in interval)
            if metric in interval:
                self.assertAlmostEqual(float(row[2].split(" to ")[1]) / interval[metric][1], 1, delta=0.006)
        self.assertIn("reference's own noise", self.output)
        self.assertIn("90 % interval", self.output)

    def test_what_is_within_the_noise_is_warned_of(self):
        # A reference of the same number of passes is no better than the image: its noise is as large as the error. Of
        # squared errors it drops out.
        result = self.run_ok("render", "cornell-box", *SIZE, "--passes", 64, *REFERENCE)
        self.assertRegex(result.stdout, "warning: mae is .* own noise")
        self.assertNotIn("warning: mse", result.stdout)
        [named] = json_lines(self.run_ok("render", "cornell-box", *SIZE, "--passes", 64, "--seed", 2, "--json"))
        result = self.run_ok("render", "cornell-box", *SIZE, "--passes", 64, "--reference", named["id"])
        self.assertRegex(result.stdout, "warning: mse is .* own noise")
        self.assertNotIn("warning: relative_mse", self.output)  # 8 passes against 64

    def test_every_picture_of_the_error_is_the_daemons(self):
        job = f"/v1/jobs/{self.job['id']}"
        for file, resource in (("curve.csv", "curve.csv"), ("difference.exr", "difference.exr"), ("flip.png", "flip.png"),
                               ("error.png", "error.png"), ("film", "film")):
            self.assertEqual((cli.folder / file).read_bytes(), get(f"{job}/{resource}").body, file)
        self.run_ok("jobs", "fetch", self.job["id"], "--curve", "fetched.csv", "--flip", "fetched.png")
        self.assertEqual((cli.folder / "fetched.csv").read_bytes(), (cli.folder / "curve.csv").read_bytes())
        self.assertEqual((cli.folder / "fetched.png").read_bytes(), (cli.folder / "flip.png").read_bytes())

    def test_without_a_reference_there_is_no_picture_of_the_error(self):
        result = self.run_for(USAGE, "render", "cornell-box", *SIZE, "--flip", "none.png")
        self.assertIn("--reference", result.stderr)

    def test_the_tone_curves_old_spelling(self):
        self.run_ok("jobs", "fetch", self.job["id"], "--preview", "old.png", "--curve", "filmic")
        self.run_ok("jobs", "fetch", self.job["id"], "--preview", "new.png", "--tone-curve", "filmic")
        self.assertEqual((cli.folder / "old.png").read_bytes(), (cli.folder / "new.png").read_bytes())
        self.assertNotEqual((cli.folder / "new.png").read_bytes(), get(f"/v1/jobs/{self.job['id']}/preview.png").body)

    def test_references_are_jobs_images_and_methods(self):
        self.run_ok("jobs", "fetch", self.job["id"], "-o", "reference.exr")
        for given, understood in ((self.job["id"], "job:" + self.job["id"]), ("job:" + self.job["id"], "job:" + self.job["id"]),
                                  ("reference.exr", "image:"), ("path_tracing,indirect_bounces=2:64", "rendered")):
            with self.subTest(reference=given):
                [job] = json_lines(self.run_ok("render", "cornell-box", *SIZE, "--passes", 1, "--reference", given, "--json"))
                reference = job["request"]["reference"]
                if understood == "rendered":
                    self.assertEqual(reference["stop"]["passes"], 64)
                    self.assertEqual(reference["method"]["parameters"]["indirect_bounces"], 2)
                else:
                    self.assertTrue(reference.startswith(understood), reference)
                self.assertGreater(job["statistics"]["error"]["relative_mse"], 0)
        for wrong in ("path_tracing:many", "path_trcing:64", "path_tracing,indirect_bounces=two:64", "not there.exr"):
            self.run_for(USAGE, "render", "cornell-box", *SIZE, "--reference", wrong)

    def test_metrics_of_jobs_and_files(self):
        self.run_ok("jobs", "fetch", self.job["id"], "-o", "measured.exr")
        [same] = json_lines(self.run_ok("metrics", self.job["id"], "measured.exr", "--metrics", "rmse,flip_hdr", "--json"))
        self.assertEqual(same["metrics"]["rmse"], 0)
        reference, second = self.job["reference_jobs"]
        result = self.run_ok("metrics", "measured.exr", reference, second, "--metrics", "relative_mse")
        [value] = re.findall(r"relative_mse +(\S+)", result.stdout)
        self.assertAlmostEqual(float(value) / self.job["statistics"]["error"]["relative_mse"], 1, delta=0.006)
        self.assertIn("did you mean", self.run_for(REFUSED, "metrics", reference, reference, "--metrics", "rmsee").stderr)

    def test_what_measures_completes(self):
        self.assertIn("relative_mse", self.completed("photonctl render --metrics relative_m"))
        self.assertEqual(self.completed("photonctl render --metrics rmse,flip_h"), ["rmse,flip_hdr"])
        self.assertEqual(self.completed("photonctl render --target relative_m"), ["relative_mse="])
        self.assertIn(self.job["id"], self.completed("photonctl metrics "))
        self.assertEqual(self.completed("photonctl render --reference path"), ["path_tracing:"])


class Targets(Case):
    def test_a_target_alone_is_a_stop(self):
        [job] = json_lines(self.run_ok("render", "cornell-box", *SIZE, "--target", "estimated_relative_mse=0.05", "--json"))
        self.assertEqual(job["request"]["stop"],
                         {"passes": None, "seconds": None, "target": {"metric": "estimated_relative_mse", "value": 0.05}})
        self.assertLessEqual(job["statistics"]["estimate"]["estimated_relative_mse"], 0.05)

    def test_the_error_is_shown_with_the_target(self):
        result = self.run_ok("render", "cornell-box", *SIZE, *REFERENCE, "--target", "relative_mse=0.03")
        self.assertRegex(result.stderr, r"succeeded: 100 %, \d+ passes, .*relative_mse [\d.e-]+ \(target 0.03\)")

    def test_a_target_that_is_none(self):
        for wrong, words in (("relative_mse=small", "not a number"), ("0.001", "KEY=VALUE")):
            self.assertIn(words, self.run_for(USAGE, "render", "cornell-box", "--target", wrong).stderr)
        result = self.run_for(REFUSED, "render", "cornell-box", *SIZE, "--target", "relative_mse=0.001")
        self.assertIn("needs a reference", result.stderr)

    def test_the_point_looked_at_has_an_old_spelling(self):
        [job] = json_lines(self.run_ok("render", "cornell-box", *SIZE, "--passes", 1, "--eye", "0,0.2,2", "--target",
                                       "0,0.25,0", "--json"))
        self.assertEqual(job["request"]["camera"]["look_at"]["target"], [0, 0.25, 0])


class Films(Case):
    def render(self, passes, *more):
        [job] = json_lines(self.run_ok("render", "furnace", *SIZE, "--passes", passes, *more, "--json"))
        return job

    def test_an_extended_job_and_a_merged_one_are_the_long_one(self):
        whole = self.render(6)["statistics"]["pixel_hash"]
        first, second = self.render(2), self.render(4, "--first-pass", 2)
        merged = self.run_ok("merge", first["id"], second["id"], "-o", "merged.exr", "--json")
        [job] = json_lines(merged)
        self.assertEqual((job["role"], job["statistics"]["pixel_hash"]), ("merged", whole))
        self.assertEqual((cli.folder / "merged.exr").read_bytes(), get(f"/v1/jobs/{job['id']}/image.exr").body)
        self.run_ok("jobs", "extend", first["id"], "--passes", 6)
        [extended] = json_lines(self.run_ok("jobs", "watch", first["id"], "--json"))[-1:]
        self.assertEqual((extended["passes_done"], extended["statistics"]["pixel_hash"]), (6, whole))

    def test_what_does_not_fit_is_refused(self):
        one, other = self.render(1), self.render(1, "--seed", 2)
        self.run_for(REFUSED, "merge", one["id"], other["id"])
        self.run_for(USAGE, "jobs", "extend", one["id"])
        self.assertIn("--passes", self.run_for(USAGE, "jobs", "extend", one["id"]).stderr)


class Comparing(Case):
    """Two methods with two seeds, one of them swept: six jobs of a fraction of a second."""

    ENTRIES = ["--entry", "paths=path_tracing", "--entry", "photons=photon_mapping,gather=direct,nearest_photons=20",
               "--sweep", "photons:photons=1000,4000"]
    COMMON = ["compare", "cornell-box", *SIZE, *REFERENCE, "--passes", 4]

    @classmethod
    def setUpClass(cls):
        result = cli.run(*cls.COMMON, *cls.ENTRIES, "--seeds", "1,2", "--metrics", "relative_mse,indirect:relative_mse", "-o",
                         "report.html", "--csv", "report.csv", "--json-report", "report.json")
        cls.output, cls.messages, cls.code = result.stdout, result.stderr, result.returncode
        path = f"/v1/comparisons/{get('/v1/comparisons').json['items'][-1]['id']}"

        def measured():  # bias is, after the last job: it may or may not be in what photonctl has said and saved by then
            found = get(path).json
            return all(row["bias"] and len(row["bias"]) == 2 for row in found["table"]) and found
        cls.comparison = cli.daemon.wait_until(measured, "bias is measured") if cls.code == OK else get(path).json

    def setUp(self):
        self.assertEqual(self.code, OK, self.messages)

    def test_what_was_asked_for_is_compared(self):
        request = self.comparison["request"]
        self.assertEqual([entry["label"] for entry in request["entries"]], ["paths", "photons"])
        self.assertEqual(request["entries"][1]["sweep"], {"photons": [1000, 4000]})
        self.assertEqual(request["entries"][1]["method"]["parameters"]["nearest_photons"], 20)
        self.assertEqual((request["seeds"], request["metrics"]), ([1, 2], ["relative_mse", "indirect:relative_mse"]))
        self.assertEqual(len(self.comparison["jobs"]), 6)
        self.assertIn("6/6 jobs", self.messages)

    def test_tables_and_verdicts_say_what_the_daemon_says(self):
        comparison = get(f"/v1/comparisons/{self.comparison['id']}").json
        rows = comparison["table"]
        self.assertEqual(len(rows), 3)
        for name in ("paths", "photons, photons 1000", "photons, photons 4000"):
            self.assertIn(name, self.output)
        for metric in ("relative_mse", "indirect:relative_mse"):
            self.assertIn("time to " + metric, self.output)
            hardest = min(point["error"] for row in rows for point in row["time_to_error"][metric]
                          if point["seconds"] is not None)
            goal = f"{metric} {hardest:.3g}"
            sentences = [line for line in self.output.splitlines()
                         if f" reaches {goal} first, after " in line or line.startswith(f"  too close to call at {goal}:")]
            self.assertEqual(len(sentences), 1, self.output)
        for headline in comparison["headlines"]:
            metric = headline["metric"]
            said = [f"By {metric}: {headline['text']}."] + ["  " + verdict["text"] for verdict in comparison["verdicts"]
                                                            if verdict["metric"] == metric]
            self.assertIn("\n" + "\n".join(said) + "\n\n", self.output)
        self.assertEqual([one["metric"] for one in comparison["headlines"]], ["relative_mse", "indirect:relative_mse"])
        self.assertIn(f"By relative_mse: {comparison['headlines'][0]['text']}.</p>", get(comparison["links"]["report_html"]).text)
        self.assertIn("peak memory", self.output)

    def test_reports_are_saved(self):
        path = f"/v1/comparisons/{self.comparison['id']}"
        kinds = ("html", "csv", "json")
        wanted = [get(f"{path}/report.{kind}").body for kind in kinds]

        def saved():
            return [(cli.folder / f"report.{kind}").read_bytes() for kind in kinds]
        if saved() != wanted:  # some were saved before bias was measured: the rest of them is the same
            table = json.loads(saved()[2])["table"]
            self.assertEqual([{**row, "bias": 0} for row in table], [{**row, "bias": 0} for row in self.comparison["table"]])
            self.run_ok("comparisons", "fetch", self.comparison["id"], "-o", "report.html", "--csv", "report.csv",
                        "--json-report", "report.json")
        self.assertEqual(saved(), wanted)
        self.run_ok("comparisons", "fetch", self.comparison["id"], "-o", "again.html")
        self.assertEqual((cli.folder / "again.html").read_bytes(), (cli.folder / "report.html").read_bytes())

    def test_comparisons_are_listed_and_shown_again(self):
        identity = self.comparison["id"]
        self.assertIn(identity, self.run_ok("comparisons", "list").stdout)
        shown = self.run_ok("comparisons", "show", identity).stdout
        biases = tuple(f": {parts['text']}" for row in self.comparison["table"] for parts in row["bias"].values())
        self.assertEqual([line for line in shown.splitlines() if not line.endswith(biases)],
                         [line for line in self.output.splitlines() if not line.endswith(biases)])
        self.assertEqual([bias for bias in biases if bias not in shown], [])
        self.assertEqual(json_lines(self.run_ok("comparisons", "watch", identity, "--json"))[-1],
                         get(f"/v1/comparisons/{identity}").json)
        self.assertIn(identity, self.completed("photonctl comparisons show "))
        self.assertEqual(self.completed("photonctl compare --entry photons=photon_m"), ["photon_mapping"])

    def test_a_file_is_the_start_and_options_change_it(self):
        body = {"scene": "furnace", "image": {"width": 8, "height": 8}, "entries": [{"method": {"name": "path_tracing"}}],
                "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 8}}, "stop": {"passes": 1}, "seeds": [5]}
        [comparison] = json_lines(self.run_ok("compare", "--request", "-", "--width", 12, "--json", input=json.dumps(body)))
        self.assertEqual(comparison["request"]["image"]["width"], 12)
        self.assertEqual((comparison["state"], comparison["request"]["seeds"]), ("succeeded", [5]))

    def test_slips_are_named_before_anything_is_sent(self):
        for arguments, words in (
                ([], "--entry"),
                (["--entry", "a=path_trcing"], "did you mean path_tracing"),
                (["--entry", "a=photon_mapping,photns=5"], "did you mean photons"),
                (["--entry", "a=photon_mapping,photons=0"], "outside"),
                (["--entry", "=path_tracing"], "label"),
                (["--entry", "a=path_tracing", "--sweep", "b:seed=1"], "no --entry has the label b"),
                (["--entry", "a=photon_mapping", "--sweep", "photons=1"], "LABEL:PARAMETER"),
                (["--entry", "a=path_tracing", "-o", "report.pdf"], ".html")):
            with self.subTest(arguments=arguments):
                self.assertIn(words, self.run_for(USAGE, *self.COMMON, *arguments).stderr)
        result = self.run_for(USAGE, "compare", "cornell-box", *REFERENCE, "--entry", "path_tracing")
        self.assertIn("--seconds", result.stderr)


class Stopping(Case):
    """Comparisons that would take minutes: stopping to watch is not stopping to compare."""

    LONG = ["compare", "cornell-box", *SIZE, "--reference", "path_tracing:1", "--seconds", "600", "--entry", "path_tracing",
            "--seeds", "1,2,3"]

    def start_long(self, *more):
        process = cli.popen(*self.LONG, *more)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        line = process.stderr.readline()
        self.assertTrue(line, "ended before it began")
        identity = line.split()[0]
        self.addCleanup(cli.daemon.request, "DELETE", f"/v1/comparisons/{identity}")
        return process, identity

    def state(self, identity):
        return get(f"/v1/comparisons/{identity}").json["state"]

    def test_an_interrupt_leaves_it_running(self):
        process, identity = self.start_long()
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(), INTERRUPTED)
        self.assertIn(f"photonctl comparisons watch {identity}", process.stderr.read())
        self.assertIn(self.state(identity), ("queued", "running"))
        self.run_ok("comparisons", "cancel", identity)
        self.run_for(CANCELLED, "comparisons", "watch", identity)
        self.assertIn("was over before: it had been cancelled", self.run_ok("comparisons", "cancel", identity).stderr)
        self.assertIn(f"{identity} removed", self.run_ok("comparisons", "remove", identity).stderr)
        self.assertEqual(get(f"/v1/comparisons/{identity}").status, 404)

    def test_an_interrupt_cancels_where_asked_to(self):
        process, identity = self.start_long("--cancel-on-interrupt")
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(), CANCELLED)
        self.assertEqual(self.state(identity), "cancelled")

    def test_a_timeout_leaves_it_running(self):
        result = self.run_for(TIMED_OUT, *self.LONG, "--timeout", "0.5")
        [identity] = re.findall(r"comparisons watch (\S+);", result.stderr)
        self.addCleanup(cli.daemon.request, "DELETE", f"/v1/comparisons/{identity}")
        self.assertIn(self.state(identity), ("queued", "running"))


if __name__ == "__main__":
    unittest.main()
