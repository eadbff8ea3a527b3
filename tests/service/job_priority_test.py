"""The priority of a job that is there: changed, obeyed, told, kept."""

import json
import unittest

from api_test import EventStream
from photond_daemon import Daemon, small_job

ENDLESS = 100_000_000  # passes: over long after the test


class JobPriorityTest(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon()
        self.addCleanup(self.daemon.close)
        self.daemon.wait_ready()

    def running(self):
        """A job that holds the device until it is cancelled."""
        job_id = self.daemon.submit(small_job(size=16, passes=ENDLESS))["id"]
        self.daemon.wait_for_passes(job_id)
        return job_id

    def change(self, job_id, priority):
        reply = self.daemon.request("PATCH", f"/v1/jobs/{job_id}", json_body={"priority": priority})
        self.assertEqual(reply.status, 200, reply)
        return reply.json

    def begun(self, ids):
        """The jobs in the order in which their first attempts began."""
        jobs = [self.daemon.wait_for_job(job_id) for job_id in ids]
        self.assertEqual({job["state"] for job in jobs}, {"succeeded"})
        log = {job["id"]: self.daemon.request("GET", f"/v1/jobs/{job['id']}/log.txt").text for job in jobs}
        starts = {job_id: text[:text.index(" attempt 1 begins")].rsplit("\n", 1)[-1] for job_id, text in log.items()}
        return sorted(ids, key=lambda job_id: starts[job_id])

    def test_a_waiting_job_moves_and_the_queue_outlives_the_daemon(self):
        holder = self.running()
        first, second, third, fourth = (self.daemon.submit(small_job(seed=seed))["id"] for seed in range(4))
        hash_key = {**small_job(seed=1)}
        changed = self.change(third, 50)
        self.assertEqual((changed["state"], changed["request"]["priority"]), ("queued", 50))
        self.change(first, -3)
        self.change(fourth, 50)
        self.assertEqual(self.change(fourth, 50)["request"]["priority"], 50, "said twice")
        log = self.daemon.request("GET", f"/v1/jobs/{fourth}/log.txt").text
        self.assertEqual(log.count("priority changed from 0 to 50 on request"), 1, log)
        page = self.daemon.request("GET", "/v1/jobs?view=summary&state=queued").json
        self.assertEqual([job["priority"] for job in page["items"]], [50, 50, 0, -3])
        self.daemon.kill()  # what was answered is on the disk
        self.daemon.start()
        self.daemon.wait_ready()
        self.assertEqual(self.daemon.job(third)["request"]["priority"], 50)
        self.daemon.request("DELETE", f"/v1/jobs/{holder}")
        self.assertEqual(self.begun([first, second, third, fourth]), [third, fourth, second, first])
        # What is rendered is the same as without any of this.
        plain = self.daemon.run_job(hash_key)
        moved = self.daemon.job(second)
        self.assertEqual(plain["statistics"]["job_hash"], moved["statistics"]["job_hash"])
        self.assertEqual(self.daemon.job(third)["request"]["priority"], 50, "it is kept when the job is over")

    def test_a_running_job_keeps_it_for_its_next_attempt(self):
        job_id = self.running()
        with EventStream(self.daemon, f"/v1/jobs/{job_id}/events") as stream:
            first = stream.next()
            self.assertEqual((first["event"], json.loads(first["data"])["priority"]), ("state", 0))
            passes = json.loads(first["data"])["passes_done"]
            changed = self.change(job_id, 9)
            self.assertEqual((changed["state"], changed["request"]["priority"]), ("running", 9))
            while True:
                event = stream.next()
                data = json.loads(event["data"])
                if event["event"] == "state":
                    break
            self.assertEqual((data["id"], data["state"], data["priority"]), (job_id, "running", 9))
            self.assertGreaterEqual(data["passes_done"], passes, "what it has done is not taken back")
        self.daemon.request("DELETE", f"/v1/jobs/{job_id}")
        over = self.daemon.wait_for_job(job_id)
        self.assertEqual((over["state"], over["request"]["priority"]), ("cancelled", 9))
        holder = self.running()
        other = self.daemon.submit(small_job(priority=8))["id"]
        again = self.daemon.request("POST", f"/v1/jobs/{job_id}/extend", json_body={"stop": {"passes": over["passes_done"] + 1}})
        self.assertEqual((again.status, again.json["request"]["priority"]), (202, 9), again)
        self.daemon.request("DELETE", f"/v1/jobs/{holder}")
        self.daemon.wait_for_job(other)
        self.assertLessEqual(self.daemon.wait_for_job(job_id)["finished"], self.daemon.job(other)["started"])

    def test_a_reference_is_raised_with_the_job_that_needs_it(self):
        holder = self.running()
        made = {"method": {"name": "path_tracing"}, "stop": {"passes": 2}}
        job = self.daemon.submit(small_job(size=8, reference=made))
        self.change(job["id"], 20)
        reference = self.daemon.job(job["reference_job"])
        self.assertEqual((reference["state"], reference["request"]["priority"]), ("queued", 20))
        plain = self.daemon.submit(small_job(priority=10))["id"]
        self.daemon.request("DELETE", f"/v1/jobs/{holder}")
        self.assertEqual(self.daemon.wait_for_job(job["id"])["state"], "succeeded")
        self.assertLessEqual(self.daemon.job(job["id"])["finished"], self.daemon.wait_for_job(plain)["started"])

    def test_a_job_of_a_comparison_may_be_moved(self):
        holder = self.running()
        body = {"scene": "cornell-box", "image": {"width": 8, "height": 8}, "stop": {"passes": 2}, "seeds": [1, 2],
                "metrics": ["estimated_relative_mse"], "entries": [{"method": {"name": "path_tracing"}}]}
        reply = self.daemon.request("POST", "/v1/comparisons", json_body=body)
        self.assertEqual(reply.status, 202, reply)
        last = reply.json["jobs"][-1]["id"]
        self.assertEqual(self.change(last, 1)["comparison"], reply.json["id"])
        self.daemon.request("DELETE", f"/v1/jobs/{holder}")
        ids = [job["id"] for job in reply.json["jobs"]]
        self.assertEqual(self.begun(ids), ids[::-1])

    def test_refusals(self):
        job_id = self.daemon.run_job(small_job())["id"]
        over = self.daemon.request("PATCH", f"/v1/jobs/{job_id}", json_body={"priority": 1})
        self.assertEqual((over.status, over.json["code"]), (409, "wrong_state"), over)
        self.assertEqual(self.daemon.request("PATCH", "/v1/jobs/J999", json_body={"priority": 1}).status, 404)
        waiting = self.running()
        for body, pointer in (({"priority": 101}, "/priority"), ({"priority": -101}, "/priority"),
                              ({"priority": 0.5}, "/priority"), ({"priority": "1"}, "/priority"),
                              ({"priority": None}, "/priority"), ({}, "/priority"), ({"priority": 1, "prio": 1}, "/prio"),
                              ({"priority": 1, "state": "queued"}, "/state"), ([], "")):
            with self.subTest(body=body):
                reply = self.daemon.request("PATCH", f"/v1/jobs/{waiting}", json_body=body)
                self.assertEqual(reply.status, 422, reply)
                self.assertIn(pointer, [error["pointer"] for error in reply.json["errors"]])
        self.assertEqual(self.daemon.job(waiting)["request"]["priority"], 0)


if __name__ == "__main__":
    unittest.main()
