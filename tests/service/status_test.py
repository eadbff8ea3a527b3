"""The daemon's status: what it says, and what it counts; asked for, and told to whoever listens to the whole daemon."""

import json
import os
import signal
import time
import unittest

from api_test import EventStream
from photond_daemon import Daemon, DaemonTestCase, small_job

ENDLESS = 100_000_000  # passes: over long after the test
MEMORY_LIMIT = 3 << 30


class StatusTest(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon("--memory-limit", MEMORY_LIMIT)
        self.addCleanup(self.daemon.close)
        self.daemon.wait_ready()

    def status(self):
        reply = self.daemon.request("GET", "/v1/status")
        self.assertEqual(reply.status, 200, reply)
        return reply.json

    def test_processes(self):
        status = self.status()
        (cpu,) = self.daemon.request("GET", "/v1/devices").json["items"][:1]
        by_device = {worker["device"]: worker for worker in status["workers"]}
        self.assertEqual((by_device["cpu"]["device_name"], by_device["none"]["device_name"]), (cpu["name"], None))
        self.assertEqual({worker["memory_limit_bytes"] for worker in status["workers"]}, {MEMORY_LIMIT})
        with open(f"/proc/{self.daemon.process.pid}/statm") as statm:
            resident = int(statm.read().split()[1]) * os.sysconf("SC_PAGESIZE")
        self.assertAlmostEqual(status["resident_bytes"] / resident, 1, delta=0.25)

    def test_totals_are_those_of_the_statistics(self):
        nothing = {"jobs": {"succeeded": 0, "failed": 0, "cancelled": 0}, "passes": 0, "pixels": 0, "render_seconds": 0,
                   "rays": {"camera": 0, "bounce": 0, "shadow": 0, "photon": 0}, "photons": 0}
        self.assertEqual(self.status()["totals"], nothing)
        path = self.daemon.run_job(small_job(size=24, passes=3))
        photon = self.daemon.run_job({**small_job(size=16, passes=2), "method": {
            "name": "photon_mapping", "parameters": {"photons": 1000, "gather_rays": 1}}})
        totals = self.status()["totals"]
        counts = [job["statistics"]["counts"] for job in (path, photon)]
        self.assertEqual(totals["jobs"], {"succeeded": 2, "failed": 0, "cancelled": 0})
        self.assertEqual((totals["passes"], totals["pixels"]), (5, 3 * 24 * 24 + 2 * 16 * 16))
        self.assertEqual(totals["rays"], {kind: sum(c["rays"][kind] for c in counts) for kind in nothing["rays"]})
        self.assertEqual(totals["photons"], counts[1]["photons_emitted"])
        self.assertGreater(totals["photons"], 0)
        self.assertAlmostEqual(totals["render_seconds"], path["seconds"] + photon["seconds"], places=6)
        # A job that goes on from its film adds what it does now, and nothing twice.
        self.daemon.request("POST", f"/v1/jobs/{path['id']}/extend", json_body={"stop": {"passes": 7}})
        extended = self.daemon.wait_for_job(path["id"])
        after = self.status()["totals"]
        self.assertEqual((after["passes"], after["pixels"]), (9, 7 * 24 * 24 + 2 * 16 * 16))
        self.assertEqual(after["rays"]["camera"], totals["rays"]["camera"]
                         + extended["statistics"]["counts"]["rays"]["camera"] - counts[0]["rays"]["camera"])
        self.assertAlmostEqual(after["render_seconds"], extended["seconds"] + photon["seconds"], places=6)
        self.daemon.stop()
        self.daemon.start()
        self.assertEqual(self.status()["totals"], nothing, "they are of this daemon's life")

    def test_what_runs_is_counted_and_what_was_lost_stays_counted(self):
        job_id = self.daemon.submit(small_job(size=16, passes=ENDLESS))["id"]
        self.daemon.wait_until(lambda: self.status()["totals"]["passes"] >= 10, "the passes of a running job are counted",
                               job=job_id)
        before = self.status()["totals"]
        self.assertEqual(before["pixels"], before["passes"] * 16 * 16)
        self.assertGreater(before["render_seconds"], 0)
        self.assertEqual(sum(before["jobs"].values()), 0)
        os.kill(self.daemon.workers()["cpu"], signal.SIGKILL)
        self.daemon.wait_for_job_that(lambda job: len(job["attempts"]) == 2, "to be tried again", job_id)
        self.assertGreaterEqual(self.status()["totals"]["passes"], before["passes"])
        self.daemon.request("DELETE", f"/v1/jobs/{job_id}")
        self.daemon.wait_for_job(job_id)
        self.assertEqual(self.status()["totals"]["jobs"], {"succeeded": 0, "failed": 0, "cancelled": 1})


class StatusEventsTest(DaemonTestCase):
    def test_the_stream_of_the_whole_daemon_tells_it_every_second(self):
        def uptime_of_next(stream):
            return json.loads(stream.next()["data"])["uptime_seconds"]

        def first_comes_at_once():
            """Before the second one of a stream that has just had its first."""
            with EventStream(self.daemon, "/v1/events") as earlier:
                uptime_of_next(earlier)
                with EventStream(self.daemon, "/v1/events") as stream:
                    return uptime_of_next(stream) < uptime_of_next(earlier)
        # A busy machine may keep the daemon for a second between the two, but not every time.
        self.assertTrue(any(first_comes_at_once() for _ in range(20)), "the first comes at once")
        begun = time.monotonic()
        with EventStream(self.daemon, "/v1/events") as stream:
            told = []
            for _ in range(4):
                event = stream.next()
                self.assertEqual((event["event"], "id" in event), ("status", False), "it is nothing to resume by")
                told.append((time.monotonic(), json.loads(event["data"])))
            # At most one a second, and without end; how late they are is the machine's.
            self.assertGreater(told[3][0] - begun, 2.9)
            asked = self.daemon.request("GET", "/v1/status").json
            self.assertEqual(set(told[3][1]), set(asked))
            self.assertEqual(told[3][1]["workers"][0]["device"], asked["workers"][0]["device"])
            uptimes = [status["uptime_seconds"] for _, status in told]
            self.assertEqual(uptimes, sorted(set(uptimes)), "each is of its moment")
            self.assertGreaterEqual(told[3][1]["event_clients"], 1)

    def test_a_jobs_stream_is_of_the_job_alone(self):
        job_id = self.daemon.submit(small_job(size=16, passes=ENDLESS))["id"]
        kinds = set()
        with EventStream(self.daemon, f"/v1/jobs/{job_id}/events") as stream:
            with EventStream(self.daemon, "/v1/events") as everything:
                for _ in range(2):  # of the daemon's status, which must not be told in the job's stream
                    while everything.next()["event"] != "status":
                        pass
            newest, passes = 0, self.daemon.wait_for_passes(job_id)["passes_done"]
            while newest < passes:  # all that was told until then
                event = stream.next()
                kinds.add(event["event"])
                told = json.loads(event["data"])
                self.assertEqual(told["id"], job_id)
                newest = max(newest, told.get("passes_done", 0))
        self.daemon.request("DELETE", f"/v1/jobs/{job_id}")
        self.daemon.wait_for_job(job_id)
        self.assertLessEqual(kinds, {"state", "progress", "curve"})
        self.assertIn("progress", kinds)

    def test_who_listens_is_counted(self):
        def wait_for_clients(count):
            self.daemon.wait_until(lambda: self.daemon.request("GET", "/v1/status").json["event_clients"] == count,
                                   f"{count} listen")

        wait_for_clients(0)  # that the streams of other tests are gone is noticed a little later
        with EventStream(self.daemon, "/v1/events") as one, EventStream(self.daemon, "/v1/events") as two:
            one.next(), two.next()
            wait_for_clients(2)


if __name__ == "__main__":
    unittest.main()
