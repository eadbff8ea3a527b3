"""Comparisons as clients see them: asked for once, run to a complete table whatever dies meanwhile, and reported in a page
that needs nothing beside itself.
"""

import base64
import csv
import hashlib
import html.parser
import io
import json
import pathlib
import re
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from photond_daemon import OVER, UNDER_SANITIZER, Daemon, small_job  # noqa: E402

PHOTONS = {"name": "photon_mapping", "parameters": {"gather_rays": 1}}
LACKING = "No image of "  # begins what the page says of a picture that is not there
LABEL = "<script>alert('x')</script> & \"paths\""


def comparison(passes=8, size=16, seeds=(1, 2), **more):
    """Two entries, one swept, two seeds: six small jobs."""
    return {"scene": "cornell-box", "image": {"width": size, "height": size},
            "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 64}},
            "entries": [{"label": LABEL, "method": {"name": "path_tracing"}},
                        {"method": PHOTONS, "sweep": {"photons": [500, 1000]}}],
            "stop": {"passes": passes}, "seeds": list(seeds), "metrics": ["relative_mse", "flip_hdr"], **more}


def submit(daemon, body, key=None):
    reply = daemon.request("POST", "/v1/comparisons", json_body=body, headers={"Idempotency-Key": key} if key else {})
    if reply.status != 202:
        raise AssertionError(f"not accepted: {reply!r}")
    return reply


def wait_for(daemon, comparison_id, states=OVER):
    return daemon.wait_for_state(f"/v1/comparisons/{comparison_id}", states)


def errors_at_passes(daemon, found):
    """{(label, parameters, seed): {passes: metrics}} of every curve. How often FLIP is measured depends on how long it takes
    beside the passes; the others are there at every power of two."""
    report = daemon.request("GET", f"/v1/comparisons/{found['id']}/report.json").json
    curves = {entry["job"]: entry["points"] for entry in report["curves"]}
    return {(job["label"], json.dumps(job["parameters"]), job["seed"]):
            {point["passes"]: point["metrics"] for point in curves[job["id"]]
             if point["passes"] & (point["passes"] - 1) == 0}
            for job in report["jobs"]}


class SameErrors:
    def assert_same_errors(self, first, second, passes):
        self.assertEqual(first.keys(), second.keys())
        for row, curve in first.items():
            self.assertEqual((set(curve), set(second[row])), (passes, passes), row)
            following = None  # estimates that both have had at all powers of two up to here
            for at in sorted(passes):
                mine, theirs = curve[at], second[row][at]
                self.assertLessEqual({"relative_mse", "rmse", "mae", "smape", "rmse_8bit"}, mine.keys() & theirs.keys())
                shared = mine.keys() & theirs.keys()
                # An estimate compares halves of the passes, and so depends on one before it that a slow machine had no
                # time for.
                estimates = {metric for metric in shared if metric.startswith("estimated_")}
                following = estimates if following is None else following & estimates
                for metric in shared - (estimates - following):
                    self.assertEqual(mine[metric], theirs[metric], (row, at, metric))


class Page(html.parser.HTMLParser):
    """What a page would run or fetch."""

    def __init__(self, text):
        super().__init__()
        self.scripts, self.fetched, self.handlers, self.images = 0, [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.scripts += tag == "script"
        for name, value in attrs:
            if name.startswith("on"):
                self.handlers.append((tag, name))
            if name in ("src", "href", "action", "data") and not (value or "").startswith("data:image/png;base64,"):
                self.fetched.append((tag, name, value))
            elif name == "src":
                self.images += 1
                assert base64.b64decode(value.split(",", 1)[1], validate=True).startswith(b"\x89PNG")


class ComparisonsTest(SameErrors, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.close)
        cls.daemon.wait_ready()
        cls.reply = submit(cls.daemon, comparison())
        cls.accepted = cls.reply.json
        cls.found = wait_for(cls.daemon, cls.accepted["id"])

    def get(self, path):
        reply = self.daemon.request("GET", path)
        self.assertEqual(reply.status, 200, reply)
        return reply

    def test_it_is_accepted_with_all_its_jobs(self):
        self.assertEqual(self.reply.headers["location"], f"/v1/comparisons/{self.accepted['id']}")
        self.assertIn(self.accepted["state"], ("queued", "running"))
        plan = [(job["label"], job["parameters"], job["seed"]) for job in self.accepted["jobs"]]
        self.assertEqual(plan, [(LABEL, {}, 1), (LABEL, {}, 2),
                                ("photon_mapping", {"photons": 500}, 1), ("photon_mapping", {"photons": 500}, 2),
                                ("photon_mapping", {"photons": 1000}, 1), ("photon_mapping", {"photons": 1000}, 2)])

    def test_it_ends_with_a_complete_table(self):
        found = self.found
        self.assertEqual(found["state"], "succeeded", found)
        self.assertEqual(found["job_states"]["succeeded"], 6)
        self.assertEqual(found["progress"], 1)
        self.assertLessEqual(found["created"], found["started"])
        self.assertLessEqual(found["started"], found["finished"])
        self.assertGreater(found["overhead_seconds"], 0)
        self.assertEqual([(row["label"], row["parameters"]) for row in found["table"]],
                         [(LABEL, {}), ("photon_mapping", {"photons": 500}), ("photon_mapping", {"photons": 1000})])
        for row in found["table"]:
            self.assertEqual((row["seeds"], row["succeeded"]), (2, 2))
            self.assertEqual(row["passes"], {"min": 8, "max": 8})
            self.assertGreater(row["seconds"]["min"], 0)
            for metric in ("relative_mse", "flip_hdr"):
                error = row["error"][metric]
                self.assertTrue(error["low"] <= error["value"] <= error["high"], error)
                self.assertGreater(error["reference"], 0)
                if metric == "relative_mse" or not UNDER_SANITIZER:  # FLIP is measured as often as it takes little time
                    self.assertTrue(row["time_to_error"][metric])
            self.assertGreater(row["peak_bytes"], 0)
            self.assertGreater(row["efficiency"], 0)
        self.assertEqual(found["table"][1]["photons"], {"min": 8 * 500, "max": 8 * 500})
        self.assertTrue(any(row["pareto"] for row in found["table"]))
        # Some row reaches every level that is shown.
        for level in range(len(found["table"][0]["time_to_error"]["relative_mse"])):
            self.assertTrue(any(row["time_to_error"]["relative_mse"][level]["seconds"] for row in found["table"]))

    def test_its_reference_is_one_job_that_all_are_measured_against(self):
        reference = self.daemon.job(self.found["reference"]["job"])
        self.assertEqual(reference["role"], "reference")
        self.assertGreater(self.found["reference"]["error"]["relative_mse"], 0)
        for job in self.found["jobs"]:
            job = self.daemon.job(job["id"])
            self.assertEqual(job["comparison"], self.found["id"])
            self.assertEqual(job["reference_job"], reference["id"])

    def test_jobs_ran_one_after_the_other_in_their_order(self):
        jobs = [self.daemon.job(job["id"]) for job in self.found["jobs"]]
        for before, after in zip(jobs, jobs[1:]):
            self.assertLessEqual(before["finished"], after["started"])

    def test_the_same_comparison_gives_the_same_errors_at_the_same_passes(self):
        again = submit(self.daemon, comparison()).json
        self.assertNotEqual(again["id"], self.found["id"])
        again = wait_for(self.daemon, again["id"])
        self.assertEqual(again["reference"]["job"], self.found["reference"]["job"])  # kept by content
        self.assert_same_errors(errors_at_passes(self.daemon, self.found), errors_at_passes(self.daemon, again),
                                {1, 2, 4, 8})

    def test_its_title_and_notes_are_changed_and_stay(self):
        with Daemon() as daemon:
            body = comparison(passes=1, seeds=(1,), title="Which is sooner", notes="one\n\ttwo")
            asked = submit(daemon, body, "k").json
            path = f"/v1/comparisons/{asked['id']}"

            def remarks():
                request = daemon.request("GET", path).json["request"]
                return request["title"], request["notes"]

            def change(body):
                return daemon.request("PATCH", path, json_body=body)

            self.assertEqual(remarks(), ("Which is sooner", "one\n\ttwo"))
            self.assertEqual(change({"title": "Another"}).json["request"]["title"], "Another")
            self.assertEqual(remarks(), ("Another", "one\n\ttwo"), "what is not named stays")
            wait_for(daemon, asked["id"])
            page = daemon.request("GET", f"{path}/report.html").text
            self.assertIn("<h1>Another</h1>", page)
            self.assertIn('<p class="notes">one</p>', page)
            self.assertEqual(change({"title": "<b> & so on"}).status, 200)
            self.assertIn("<h1>&lt;b&gt; &amp; so on</h1>", daemon.request("GET", f"{path}/report.html").text)
            self.assertEqual(change({"title": "Another"}).status, 200)
            for fault in ({"title": "two\nlines"}, {"title": ""}, {"title": "x" * 201}, {"notes": "\u0007"}, {"notes": 1},
                          {"titel": "x"}):
                reply = change(fault)
                self.assertEqual((reply.status, reply.json["errors"][0]["pointer"]), (422, "/" + next(iter(fault))))
            self.assertEqual(daemon.request("PATCH", "/v1/comparisons/C999", json_body={}).status, 404)
            self.assertEqual(submit(daemon, body, "k").json["id"], asked["id"], "the key is of what was submitted")
            daemon.kill()
            daemon.start()
            daemon.wait_ready()
            self.assertEqual(change({"notes": None}).status, 200)
            self.assertEqual(remarks(), ("Another", None))

    def wait_until_removed(self, removed):
        """After a comparison was purged: until no job of it runs any more, and nothing is left of it."""
        def is_gone():
            return self.daemon.request("GET", f"/v1/comparisons/{removed['id']}").status == 404 and all(
                self.daemon.request("GET", f"/v1/jobs/{job['id']}").status == 404 for job in removed["jobs"])
        self.daemon.wait_until(is_gone, f"{removed['id']} and its jobs are removed", look_every_s=0.02)

    def test_the_echo_asks_for_the_same(self):
        again = submit(self.daemon, self.found["request"]).json
        self.assertEqual(again["request"], self.found["request"])
        self.daemon.request("DELETE", f"/v1/comparisons/{again['id']}?purge=true")
        self.wait_until_removed(again)

    def test_a_key_is_one_comparison(self):
        body = comparison(passes=2, seeds=[5])
        first = submit(self.daemon, body, "once").json
        self.assertEqual(submit(self.daemon, body, "once").json["id"], first["id"])
        other = self.daemon.request("POST", "/v1/comparisons", json_body=comparison(passes=3),
                                    headers={"Idempotency-Key": "once"})
        self.assertEqual((other.status, other.json["code"]), (422, "idempotency_mismatch"))
        wait_for(self.daemon, first["id"])

    def test_faults_leave_nothing_behind(self):
        jobs = len(self.get("/v1/jobs?limit=1000").json["items"])
        comparisons = len(self.get("/v1/comparisons?limit=1000").json["items"])
        for change, pointer in (({"scene": "cornel-box"}, "/scene"), ({"seeds": [1, 1]}, "/seeds/1"),
                                ({"reference": None}, "/reference"), ({"reference": "job:J999999"}, "/reference"),
                                ({"entries": [{"method": {"name": "path_tracing"}},
                                              {"label": "x", "method": {"name": "path_tracing", "device": "gpu:7"}}]},
                                 "/entries/1/method/device")):
            with self.subTest(change=change):
                reply = self.daemon.request("POST", "/v1/comparisons", json_body={**comparison(), **change})
                self.assertEqual(reply.status, 422, reply)
                self.assertEqual([error["pointer"] for error in reply.json["errors"]], [pointer])
        self.assertEqual(len(self.get("/v1/jobs?limit=1000").json["items"]), jobs)
        self.assertEqual(len(self.get("/v1/comparisons?limit=1000").json["items"]), comparisons)

    def test_its_jobs_are_not_removed_by_themselves(self):
        job = self.found["jobs"][0]["id"]
        reply = self.daemon.request("DELETE", f"/v1/jobs/{job}?purge=true")
        self.assertEqual((reply.status, reply.json["code"]), (409, "wrong_state"))
        self.assertEqual(self.daemon.job(job)["state"], "succeeded")

    def test_pages_of_the_list(self):
        extra = [submit(self.daemon, comparison(passes=1, seeds=[seed])).json["id"] for seed in (11, 12)]
        whole = self.get("/v1/comparisons").json
        self.assertIsNone(whole["next_cursor"])
        ids = [item["id"] for item in whole["items"]]
        self.assertEqual(ids, sorted(ids, key=lambda name: -int(name[1:])))
        self.assertNotIn("table", whole["items"][0])
        paged, cursor = [], ""
        while cursor is not None:
            page = self.get(f"/v1/comparisons?limit=1&cursor={cursor}").json
            paged += [item["id"] for item in page["items"]]
            cursor = page["next_cursor"]
        self.assertEqual(paged, ids)
        for comparison_id in extra:
            wait_for(self.daemon, comparison_id)

    def test_cancelled_and_removed(self):
        long = {**comparison(size=32), "stop": {"seconds": 600},
                "reference": {"method": {"name": "path_tracing"}, "stop": {"seconds": 601}}}
        first = submit(self.daemon, long).json
        reference = first["reference"]["job"]
        self.daemon.wait_for_job(reference, ("running",))
        self.assertEqual(wait_for(self.daemon, first["id"], ("running",))["job_states"]["queued"], 6)
        self.assertEqual(self.daemon.request("DELETE", f"/v1/comparisons/{first['id']}").status, 202)
        self.assertEqual(wait_for(self.daemon, first["id"])["state"], "cancelled")
        self.daemon.wait_for_job(reference, ("cancelled",))  # nobody else wants it
        self.assertEqual(self.daemon.request("DELETE", f"/v1/comparisons/{first['id']}").status, 200)

        long["reference"] = f"job:{self.found['jobs'][0]['id']}"
        long["image"] = {"width": 16, "height": 16}
        second = submit(self.daemon, long).json
        self.daemon.wait_for_job(second["jobs"][0]["id"], ("running",))
        self.assertEqual(self.daemon.request("DELETE", f"/v1/comparisons/{second['id']}?purge=true").status, 202)
        self.wait_until_removed(second)
        self.assertEqual(self.daemon.request("GET", f"/v1/comparisons/{second['id']}").status, 404)
        films = {path.name.split("-")[0] for path in (self.daemon.data_dir / "films").iterdir()}
        self.assertFalse(films & {job["id"] for job in second["jobs"]})
        self.assertEqual(self.daemon.request("DELETE", f"/v1/comparisons/{first['id']}?purge=true").status, 200)
        self.assertEqual(self.daemon.request("GET", f"/v1/comparisons/{first['id']}").status, 404)

    # --- reports

    def test_the_csv_has_every_point(self):
        reply = self.get(f"/v1/comparisons/{self.found['id']}/report.csv")
        self.assertTrue(reply.headers["content-type"].startswith("text/csv"))
        rows = list(csv.DictReader(io.StringIO(reply.text, newline="")))
        curves = self.get(f"/v1/comparisons/{self.found['id']}/report.json").json["curves"]
        self.assertEqual(len(rows), sum(len(curve["points"]) for curve in curves))
        self.assertEqual({row["label"] for row in rows}, {LABEL, "photon_mapping"})
        first = curves[0]["points"][0]
        self.assertEqual(float(rows[0]["relative_mse"]), first["metrics"]["relative_mse"])
        self.assertEqual(rows[0]["photons"], "")

    def test_a_picture_that_is_lacking_for_the_moment_is_there_at_the_next_look(self):
        one = comparison(passes=1, seeds=[31], entries=[{"label": "one", "method": {"name": "path_tracing"}}])
        compared = wait_for(self.daemon, submit(self.daemon, one).json["id"])
        path = f"/v1/comparisons/{compared['id']}"
        before = self.get(path).json
        blocking = self.daemon.submit(small_job(size=16, passes=100_000_000))["id"]
        self.daemon.wait_for_passes(blocking)
        # Whoever prefers that is not kept waiting until a map is drawn beside the job.
        reply = self.daemon.request("GET", f"{path}/report.html", headers={"Prefer": "respond-async"})
        self.assertEqual((reply.status, Page(reply.text).images, reply.text.count(LACKING)), (200, 1 + 1, 2))
        self.daemon.request("DELETE", f"/v1/jobs/{blocking}?purge=true")
        self.daemon.wait_until(lambda: self.daemon.request("GET", f"/v1/jobs/{blocking}").status == 404, "it is removed")
        text = self.get(f"{path}/report.html").text
        self.assertEqual((Page(text).images, text.count(LACKING)), (1 + 3, 0))
        self.assertEqual(self.get(path).json, before, "the comparison has changed meanwhile, and its page with it")

    def test_the_page_needs_nothing_beside_itself(self):
        reply = self.get(f"/v1/comparisons/{self.found['id']}/report.html")
        text = reply.text
        page = Page(text)
        self.assertEqual((page.scripts, page.fetched, page.handlers), (1, [], []))
        self.assertEqual(page.images, 1 + 3 * 3)  # the reference; image, error map and FLIP map of each row
        self.assertNotIn(LABEL, text)
        self.assertNotIn("http://", text.replace("http://127.0.0.1:8080/v1/comparisons", ""))
        self.assertEqual(text.count('<svg class="plot"'), 2)
        self.assertNotIn(" style=", text)
        # Its policy permits exactly its own script and style.
        policy = reply.headers["content-security-policy"]
        for tag in ("style", "script"):
            inline = re.search(f"<{tag}>(.*?)</{tag}>", text, re.DOTALL).group(1)
            digest = base64.b64encode(hashlib.sha256(inline.encode()).digest()).decode()
            self.assertIn(f"{tag}-src 'sha256-{digest}'", policy)
        self.assertIn("default-src 'none'", policy)
        for fact in ("cornell-box", "To repeat it", *(job["id"] for job in self.found["jobs"])):
            self.assertIn(fact, text)
        hashes = [self.daemon.job(job["id"])["statistics"]["pixel_hash"] for job in self.found["jobs"]]
        self.assertTrue(all(pixel_hash in text for pixel_hash in hashes))

        def is_known():  # once bias has come into it, which is measured after the last job
            path = f"/v1/comparisons/{self.found['id']}/report.html"
            known = {"If-None-Match": self.get(path).headers["etag"]}
            return self.daemon.request("GET", path, headers=known).status == 304
        self.daemon.wait_until(is_known, "the page is the same as before")

    def test_a_page_of_what_is_under_way_says_so(self):
        blocking = self.daemon.submit({**small_job(size=16), "stop": {"seconds": 600}})["id"]
        self.daemon.wait_for_job(blocking, ("running",))
        waiting = submit(self.daemon, comparison(passes=4, seeds=[21])).json["id"]
        text = self.get(f"/v1/comparisons/{waiting}/report.html").text
        self.assertIn("Unfinished: 0 of 3 jobs", text)
        self.daemon.request("DELETE", f"/v1/jobs/{blocking}?purge=true")
        wait_for(self.daemon, waiting)
        self.assertNotIn("Unfinished", self.get(f"/v1/comparisons/{waiting}/report.html").text)


class RestartTest(SameErrors, unittest.TestCase):
    def test_a_killed_daemon_goes_on_to_the_same_table(self):
        body = comparison(passes=200, size=32)
        with Daemon() as undisturbed:
            undisturbed.wait_ready()
            expected = errors_at_passes(undisturbed, wait_for(undisturbed, submit(undisturbed, body).json["id"]))
        with Daemon() as daemon:
            daemon.wait_ready()
            found = submit(daemon, body, "key").json
            for step in (1, 3, 5):  # jobs of the comparison: each time another one is under way
                job_id = found["jobs"][step]["id"]
                daemon.wait_for_job_that(lambda job: job["state"] in OVER or job["passes_done"] > 0, "to be under way", job_id)
                daemon.kill()
                daemon.start()
                daemon.wait_ready()
                self.assertEqual(submit(daemon, body, "key").json["id"], found["id"])
            done = wait_for(daemon, found["id"])
            self.assertEqual(done["state"], "succeeded", done)
            self.assertEqual([job["id"] for job in done["jobs"]], [job["id"] for job in found["jobs"]])
            self.assert_same_errors(errors_at_passes(daemon, done), expected, {1, 2, 4, 8, 16, 32, 64, 128})
            self.assertTrue(all(row["succeeded"] == 2 for row in done["table"]))


if __name__ == "__main__":
    unittest.main()
