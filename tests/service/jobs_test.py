"""Jobs over HTTP: submitted, looked at, listed, cancelled, retried, purged; their artefacts, log and events."""

import pathlib
import sys
import threading
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from photond_daemon import DaemonTestCase, small_job  # noqa: E402

ENDLESS = 100_000_000  # passes: over long after the test


class JobsTest(DaemonTestCase):
    daemon_arguments = ("--max-queue", 5)

    def tearDown(self):
        for state in ("queued", "running"):
            for job in self.daemon.request("GET", f"/v1/jobs?state={state}").json["items"]:
                self.daemon.request("DELETE", f"/v1/jobs/{job['id']}")
                self.daemon.wait_for_job(job["id"])

    def endless(self):
        """A job that runs until it is cancelled; returned when its first pass is done."""
        job = self.daemon.submit(small_job(size=16, passes=ENDLESS))
        self.daemon.wait_for_passes(job["id"])
        return job["id"]

    def test_a_picture_that_is_all_black_says_so(self):
        away = {"look_at": {"eye": [40, 40, 40], "target": [80, 80, 80]}}
        black = self.daemon.run_job({**small_job(passes=1), "camera": away})
        self.assertRegex(black["statistics"]["warnings"][0], "^every pixel is black: ")
        self.assertIn("every pixel is black", self.daemon.request("GET", f"/v1/jobs/{black['id']}/log.txt").text)
        self.assertEqual(self.daemon.run_job(small_job(passes=1))["statistics"]["warnings"], [])

    def test_runs_to_the_end(self):
        accepted = self.daemon.submit(small_job(passes=3, labels={"study": "a"}))
        self.assertEqual(accepted["state"], "queued")
        self.assertIsNone(accepted["started"])
        job = self.daemon.wait_for_job(accepted["id"])
        self.assertEqual(job["state"], "succeeded", job["failure"])
        self.assertEqual((job["passes_done"], job["progress"], job["failure"]), (3, 1, None))
        self.assertLessEqual(job["created"], job["started"])
        self.assertLessEqual(job["started"], job["finished"])
        self.assertEqual([a["outcome"] for a in job["attempts"]], ["succeeded"])
        self.assertEqual(job["request"]["labels"], {"study": "a"})
        self.assertEqual(job["request"]["method"]["device"], "cpu")
        self.assertEqual(len(job["statistics"]["pixel_hash"]), 64)
        statistics = self.daemon.request("GET", f"/v1/jobs/{job['id']}/statistics.json")
        self.assertEqual(statistics.json, job["statistics"])
        log = self.daemon.request("GET", f"/v1/jobs/{job['id']}/log.txt").text
        self.assertLess(log.index("queued for cpu"), log.index("attempt 1 begins"))
        self.assertLess(log.index("attempt 1 begins"), log.index("attempt 1 succeeded"))

    def test_artefacts_are_kept_by_content(self):
        job = self.daemon.wait_for_job(self.daemon.submit(small_job())["id"])
        path = f"/v1/jobs/{job['id']}"
        whole = self.daemon.request("GET", path + "/image.exr")
        half = self.daemon.request("GET", path + "/image.exr?precision=half")
        self.assertEqual((whole.status, half.status), (200, 200))
        self.assertEqual(whole.body[:4], b"\x76\x2f\x31\x01")  # OpenEXR's magic number
        self.assertNotEqual(whole.headers["etag"], half.headers["etag"])
        again = self.daemon.request("GET", path + "/image.exr")
        self.assertEqual((again.headers["etag"], again.body), (whole.headers["etag"], whole.body))
        unchanged = self.daemon.request("GET", path + "/image.exr", headers={"If-None-Match": whole.headers["etag"]})
        self.assertEqual((unchanged.status, unchanged.body), (304, b""))
        part = self.daemon.request("GET", path + "/image.exr", headers={"Range": "bytes=4-11"})
        self.assertEqual((part.status, part.body), (206, whole.body[4:12]))
        self.assertEqual(self.daemon.request("GET", path + "/preview.png").body[:8], b"\x89PNG\r\n\x1a\n")
        raw = self.daemon.request("GET", path + "/pixels?layer=direct&precision=float")
        self.assertEqual(len(raw.body), 32 * 32 * 3 * 4)
        self.assertEqual(self.daemon.request("GET", path + "/pixels?layer=nothing").status, 422)
        self.assertEqual(self.daemon.request("GET", path + "/difference.exr").status, 404)
        self.assertEqual(self.daemon.request("GET", path + "/curve.csv").text.split("\n")[0],
                         "seconds,passes,photons,estimated_relative_mse")

    def test_looks_at_the_film_while_it_runs(self):
        job_id = self.endless()
        image = self.daemon.request("GET", f"/v1/jobs/{job_id}/image.exr")
        self.assertEqual(image.status, 200, image)
        self.assertEqual(self.daemon.job(job_id)["state"], "running", "looking must not end the job")
        waiting = self.daemon.submit(small_job())
        early = self.daemon.request("GET", f"/v1/jobs/{waiting['id']}/image.exr")
        self.assertEqual((early.status, early.body, early.headers["retry-after"]), (202, b"", "1"))

    def test_cancels_running_and_queued_and_retries(self):
        running = self.endless()
        queued = self.daemon.submit(small_job())["id"]
        self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{queued}/retry").status, 409)
        reply = self.daemon.request("DELETE", f"/v1/jobs/{queued}")
        self.assertEqual((reply.status, reply.json["state"]), (202, "cancelled"))
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{queued}/image.exr").status, 404)
        self.assertEqual(self.daemon.request("DELETE", f"/v1/jobs/{running}").status, 202)
        job = self.daemon.wait_for_job(running)
        self.assertEqual(job["state"], "cancelled")
        self.assertGreater(job["passes_done"], 0)
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{running}/image.exr").status, 200, "what was rendered stays")
        again = self.daemon.request("DELETE", f"/v1/jobs/{running}")
        self.assertEqual((again.status, again.json), (200, job))

        retried = self.daemon.request("POST", f"/v1/jobs/{queued}/retry")
        self.assertEqual((retried.status, retried.json["id"], retried.json["state"]), (202, queued, "queued"))
        self.assertEqual(self.daemon.wait_for_job(queued)["state"], "succeeded")
        self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{queued}/retry").status, 409)

    def test_purges(self):
        job = self.daemon.wait_for_job(self.daemon.submit(small_job(), "purged")["id"])
        films = self.daemon.data_dir / "films"
        self.assertTrue(list(films.glob(job["id"] + "-*")))
        self.assertEqual(self.daemon.request("DELETE", f"/v1/jobs/{job['id']}?purge=true").status, 200)
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job['id']}").status, 404)
        self.assertFalse(list(films.glob(job["id"] + "-*")))
        running = self.endless()
        self.assertEqual(self.daemon.request("DELETE", f"/v1/jobs/{running}?purge=true").status, 202)
        self.daemon.wait_until(lambda: self.daemon.request("GET", f"/v1/jobs/{running}").status == 404, "it is removed")
        self.assertFalse(list(films.glob(running + "-*")))

    def test_idempotency(self):
        body = small_job(seed=7)
        first = self.daemon.submit(body, "key-1")
        self.assertEqual(self.daemon.submit(body, "key-1")["id"], first["id"])
        self.assertEqual(self.daemon.submit(dict(reversed(list(body.items()))), "key-1")["id"], first["id"])
        self.assertNotEqual(self.daemon.submit(body, "key-2")["id"], first["id"])
        other = self.daemon.request("POST", "/v1/jobs", json_body=small_job(seed=8), headers={"Idempotency-Key": "key-1"})
        self.assertEqual((other.status, other.json["code"]), (422, "idempotency_mismatch"))
        replies = []
        threads = [threading.Thread(target=lambda: replies.append(self.daemon.submit(body, "key-3")["id"])) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual((len(replies), len(set(replies))), (8, 1))

    def test_order_limits_and_refusals(self):
        self.endless()
        low = self.daemon.submit(small_job(priority=-5))["id"]
        normal = [self.daemon.submit(small_job())["id"] for _ in range(2)]
        high = self.daemon.submit(small_job(priority=5))["id"]
        last = self.daemon.submit(small_job(), "held")["id"]
        full = self.daemon.request("POST", "/v1/jobs", json_body=small_job())
        self.assertEqual((full.status, full.json["code"]), (429, "queue_full"))
        self.assertIn("retry-after", full.headers)
        self.assertEqual(self.daemon.submit(small_job(), "held")["id"], last, "a repeated request is answered all the same")
        running = self.daemon.request("GET", "/v1/jobs?state=running").json["items"][0]["id"]
        self.daemon.request("DELETE", f"/v1/jobs/{running}")
        started = {job_id: self.daemon.wait_for_job(job_id)["attempts"][0]["started"] for job_id in [high, *normal, last, low]}
        self.assertEqual(list(started.values()), sorted(started.values()))

        for change, code in (({"scene": "cornel-box"}, "unknown_name"), ({"camera": {"name": "left"}}, "unknown_name"),
                             ({"method": {"name": "path_tracing", "device": "gpu"}}, None),
                             ({"image": {"width": 16384, "height": 16384}}, "out_of_range")):
            reply = self.daemon.request("POST", "/v1/jobs", json_body={**small_job(), **change})
            self.assertEqual(reply.status, 422, reply)
            if code:
                self.assertEqual(reply.json["code"], code, reply)
            self.assertTrue(reply.json["errors"][0]["pointer"], reply)
        for path in ("/v1/jobs/J0", "/v1/jobs/x", "/v1/jobs/J999999999"):
            self.assertEqual(self.daemon.request("GET", path).status, 404)

    def test_lists_by_pages_and_filters(self):
        made = [self.daemon.submit(small_job(labels={"page": str(i % 2)}), f"list-{i}")["id"] for i in range(4)]
        for job_id in made:
            self.daemon.wait_for_job(job_id)
        seen, cursor = [], ""
        while True:
            page = self.daemon.request("GET", f"/v1/jobs?label=page&limit=3{cursor}").json
            seen += [job["id"] for job in page["items"]]
            if page["next_cursor"] is None:
                break
            cursor = f"&cursor={page['next_cursor']}"
        self.assertEqual(seen, made[::-1])
        odd = self.daemon.request("GET", "/v1/jobs?label=page%3D1&state=succeeded&scene=cornell-box&method=path_tracing").json
        self.assertEqual([job["id"] for job in odd["items"]], [made[3], made[1]])
        self.assertEqual(self.daemon.request("GET", "/v1/jobs?label=page&scene=furnace").json["items"], [])
        for query in ("limit=0", "limit=1001", "state=done", "cursor=x"):
            self.assertGreaterEqual(self.daemon.request("GET", "/v1/jobs?" + query).status, 400, query)


if __name__ == "__main__":
    unittest.main()
