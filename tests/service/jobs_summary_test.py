"""Lists of jobs: as summaries, by every filter, at any place; and how quick they are over a long history."""

import os
import sys
import pathlib
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from many_jobs import fill_history  # noqa: E402
from photond_daemon import Daemon, small_job  # noqa: E402

ENDLESS = 100_000_000  # passes: over long after the test
SHARED = ("id", "role", "comparison", "sequence", "state", "progress", "passes_done", "seconds", "error_now", "created", "started",
          "finished")


def expected_summary(job):
    """What the list must show of a job's whole object."""
    request = job["request"]
    return {**{key: job[key] for key in SHARED}, "scene": request["scene"], "method": request["method"]["name"],
            "device": job["attempts"][-1]["device"], "width": request["image"]["width"],
            "height": request["image"]["height"], "priority": request["priority"], "labels": request["labels"],
            "waits_for": None, "waiting_for": job["waiting_for"], "failure": job["failure"] and job["failure"]["detail"]}


class Lists(unittest.TestCase):
    def page(self, query, status=200):
        reply = self.daemon.request("GET", "/v1/jobs?" + query)
        self.assertEqual(reply.status, status, f"{query}: {reply!r}")
        return reply.json

    def ids(self, query):
        return [job["id"] for job in self.page(query)["items"]]


class SummaryTest(Lists):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def test_a_summary_says_what_the_whole_job_says(self):
        made = [self.daemon.submit(small_job(labels={"study": "summary", "a\"b": "ü,\\"}, priority=7)),
                self.daemon.submit(small_job(labels={"study": "summary"}, method="photon_mapping", passes=2))]
        for job in made:
            self.daemon.wait_for_job(job["id"])
        page = self.page("view=summary&label=study%3Dsummary")
        self.assertEqual(page["total"], 2)
        self.assertIsNone(page["next_cursor"])
        whole = self.page("label=study%3Dsummary")
        self.assertNotIn("total", whole)
        self.assertEqual(whole["items"], self.page("view=full&label=study%3Dsummary")["items"])
        self.assertEqual(page["items"], [expected_summary(job) for job in whole["items"]])
        self.assertEqual(self.ids("view=summary&label=a%22b%3D%C3%BC%2C%5C"), [made[0]["id"]])

    def test_a_running_job_is_shown_as_it_is_now(self):
        job_id = self.daemon.submit(small_job(size=16, passes=ENDLESS, labels={"study": "now"}))["id"]
        self.addCleanup(self.daemon.wait_for_job, job_id)
        self.addCleanup(self.daemon.request, "DELETE", f"/v1/jobs/{job_id}")

        def shown():
            (summary,) = self.page("view=summary&state=queued,running&label=study%3Dnow")["items"]
            return summary["passes_done"] > 0 and summary
        summary = self.daemon.wait_until(shown, "a pass is shown", job=job_id)
        self.assertEqual((summary["state"], summary["finished"]), ("running", None))
        self.assertGreater(summary["seconds"], 0)

    def test_waiting_jobs_are_listed_as_they_will_run(self):
        endless = self.daemon.submit(small_job(size=16, passes=ENDLESS, priority=100))["id"]
        self.daemon.wait_for_job(endless, states=("running",))  # and so in the queue no more
        reference = {"method": {"name": "path_tracing"}, "stop": {"passes": 3}}
        plain = self.daemon.submit(small_job(labels={"study": "order"}))["id"]
        measured = self.daemon.submit(small_job(labels={"study": "order"}, reference=reference))
        urgent = self.daemon.submit(small_job(labels={"study": "order"}, priority=9))["id"]
        awaited, second = measured["reference_jobs"]
        queue = self.page("view=summary&order=queue")
        self.assertEqual([job["id"] for job in queue["items"]], [urgent, plain, awaited, second, measured["id"]])
        self.assertEqual([job["waits_for"] for job in queue["items"]], [None, None, None, None, awaited])
        self.assertEqual(queue["total"], 5)
        self.assertEqual(self.ids("order=queue&offset=1&limit=2"), [plain, awaited])
        self.assertEqual(self.ids("order=queue&label=study%3Dorder"), [urgent, plain, measured["id"]])
        self.daemon.request("DELETE", f"/v1/jobs/{endless}")
        for job in (urgent, plain, measured["id"]):
            self.daemon.wait_for_job(job)
        self.assertEqual(self.page("view=summary&order=queue"), {"items": [], "next_cursor": None, "total": 0})
        ended = self.page("view=summary&order=ended&limit=6")
        self.assertEqual([job["id"] for job in ended["items"]],
                         [measured["id"], second, awaited, plain, urgent, endless])
        self.assertIsNone(ended["next_cursor"])

    def test_bad_queries_are_refused_with_the_place(self):
        for query, pointer in (("view=short", "/view"), ("state=queued,", "/state"), ("state=queued,done", "/state"),
                               ("state=,", "/state"), ("offset=-1", "/offset"), ("offset=1.5", "/offset"),
                               ("offset=x", "/offset"), ("limit=0", "/limit"), ("role=x", "/role"),
                               ("label=%3Dx", "/label"), ("order=x", "/order"),
                               ("order=ended&cursor=5", "/cursor"), ("view=summary&offzet=1", "/offzet")):
            with self.subTest(query=query):
                problem = self.page(query, 422)
                self.assertEqual(problem["errors"][0]["pointer"], pointer, problem)


class HistoryTest(Lists):
    """A few hundred jobs: every way to ask for a part of them gives that part of the whole list."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(start=False)
        fill_history(cls.daemon.data_dir, 300)
        cls.daemon.start()
        cls.daemon.wait_ready()
        cls.all = cls.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def test_the_history_is_one(self):
        self.assertEqual(len(self.all), 300)
        self.assertEqual({job["state"] for job in self.all}, {"succeeded", "failed", "cancelled"})
        self.assertTrue(any(job["failure"] for job in self.all))
        self.assertEqual(self.page("view=summary&limit=1000")["items"], [expected_summary(job) for job in self.all])

    def expect(self, query, keep):
        expected = [job["id"] for job in self.all if keep(job)]
        self.assertNotIn(len(expected), (0, len(self.all)), f"{query} chooses nothing, or everything")
        page = self.page(f"view=summary&limit=1000&{query}")
        self.assertEqual(([job["id"] for job in page["items"]], page["total"]), (expected, len(expected)), query)
        self.assertEqual(self.ids(f"limit=1000&{query}"), expected, query)

    def test_filters(self):
        self.expect("state=failed", lambda job: job["state"] == "failed")
        self.expect("state=failed,cancelled", lambda job: job["state"] in ("failed", "cancelled"))
        self.expect("method=path_tracing", lambda job: job["request"]["method"]["name"] == "path_tracing")
        self.expect("scene=interior", lambda job: job["request"]["scene"] == "interior")
        self.expect("label=study%3Dgather", lambda job: job["request"]["labels"]["study"] == "gather")
        self.expect("label=run%3D17", lambda job: job["request"]["labels"]["run"] == "17")
        self.expect("state=succeeded&scene=keyhole&method=photon_mapping&device=cpu&role=render&label=study",
                    lambda job: (job["state"], job["request"]["scene"], job["request"]["method"]["name"]) ==
                    ("succeeded", "keyhole", "photon_mapping"))
        for query in ("device=gpu%3A0", "method=none", "scene=none", "label=none", "label=study%3Dno", "role=merged"):
            self.assertEqual((self.ids(query), self.page("view=summary&" + query)["total"]), ([], 0), query)

    def test_those_that_ended_last_come_first(self):
        ended = sorted(self.all, key=lambda job: (job["finished"], int(job["id"][1:])), reverse=True)
        page = self.page("view=summary&order=ended&limit=1000")
        self.assertEqual(([job["id"] for job in page["items"]], page["total"]), ([job["id"] for job in ended], 300))
        self.assertEqual(self.ids("order=ended&state=failed&offset=2&limit=3"),
                         [job["id"] for job in ended if job["state"] == "failed"][2:5])
        self.assertEqual(self.ids("order=queue"), [])

    def test_places(self):
        ids = [job["id"] for job in self.all]
        for view in ("full", "summary"):
            for offset, limit in ((0, 7), (1, 7), (293, 7), (297, 7), (299, 1), (300, 7), (4_000_000_000, 1)):
                page = self.page(f"view={view}&offset={offset}&limit={limit}")
                self.assertEqual([job["id"] for job in page["items"]], ids[offset:offset + limit], (view, offset))
                self.assertEqual(page["next_cursor"] is None, offset + limit > 300, (view, offset))
            first = self.page(f"view={view}&limit=10")
            after = self.page(f"view={view}&limit=10&offset=5&cursor={first['next_cursor']}")
            self.assertEqual([job["id"] for job in after["items"]], ids[15:25])
        self.assertEqual(self.page("view=summary&offset=200&limit=1")["total"], 300)


@unittest.skipUnless(os.environ.get("PHOTOND_LONG"), "takes minutes: set PHOTOND_LONG")
class LongHundredThousandJobs(Lists):
    """Any page of any filter, with the total, within 50 ms of 99 in 100 requests."""

    JOBS = 100_000

    def test_any_page_is_quick(self):
        daemon = self.daemon = Daemon(start=False)
        self.addCleanup(daemon.close)
        fill_history(daemon.data_dir, self.JOBS)
        daemon.start()
        daemon.wait_ready()
        filters = ("", "&state=succeeded", "&state=failed,cancelled", "&state=queued,running", "&method=photon_mapping",
                   "&scene=interior", "&device=cpu", "&label=study", "&label=study%3Dgather", "&label=run%3D5",
                   "&label=study&state=succeeded&method=path_tracing&scene=keyhole&device=cpu&role=render",
                   "&label=none")
        milliseconds = {}
        for round_ in range(40):
            for given in filters:
                # The list's top, its middle, and past where the filter's jobs end.
                for offset in (0, round_ * 1000, 99_000 + round_):
                    begun = time.perf_counter()
                    page = self.page(f"view=summary&limit=100&offset={offset}{given}")
                    milliseconds.setdefault(given, []).append(1000 * (time.perf_counter() - begun))
                    self.assertLessEqual(len(page["items"]), min(100, page["total"]))
        every = sorted(value for values in milliseconds.values() for value in values)
        p99 = every[len(every) * 99 // 100]
        for given, values in milliseconds.items():
            values.sort()
            print(f"{given or 'no filter':90} median {values[len(values) // 2]:6.1f} ms, most {values[-1]:6.1f} ms")
        print(f"{len(every)} pages of 100 among {self.JOBS} jobs: median {every[len(every) // 2]:.1f} ms, p99 {p99:.1f} ms")
        self.assertEqual(self.page("view=summary&limit=1")["total"], self.JOBS)
        self.assertLess(p99, 50)


if __name__ == "__main__":
    unittest.main()
