"""The daemon's status: what it says, and what it counts; asked for, and told to whoever listens to the whole daemon."""

import json
import os
import signal
import time
import unittest

from api_test import EventStream
from photond_daemon import Daemon, DaemonTestCase, deadline_after, small_job

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
        deadline = deadline_after()
        while self.status()["totals"]["passes"] < 10:
            self.assertLess(time.monotonic(), deadline, "the passes of a running job are not counted")
            time.sleep(0.05)
        before = self.status()["totals"]
        self.assertEqual(before["pixels"], before["passes"] * 16 * 16)
        self.assertGreater(before["render_seconds"], 0)
        self.assertEqual(sum(before["jobs"].values()), 0)
        os.kill(self.daemon.workers()["cpu"], signal.SIGKILL)
        while len(self.daemon.job(job_id)["attempts"]) < 2:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        self.assertGreaterEqual(self.status()["totals"]["passes"], before["passes"])
        self.daemon.request("DELETE", f"/v1/jobs/{job_id}")
        self.daemon.wait_for_job(job_id)
        self.assertEqual(self.status()["totals"]["jobs"], {"succeeded": 0, "failed": 0, "cancelled": 1})


class StatusEventsTest(DaemonTestCase):
    def test_the_stream_of_the_whole_daemon_tells_it_every_second(self):
        def first_after():
            begun = time.monotonic()
            with EventStream(self.daemon, "/v1/events") as stream:
                stream.next()
                return time.monotonic() - begun
        # How late one is may be the machine's; of some that came by the tick of a second, not all would be late.
        self.assertTrue(any(first_after() < 0.9 for _ in range(5)), "the first comes at once")
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
            least, deadline = time.monotonic() + 3, deadline_after()
            while time.monotonic() < least or "progress" not in kinds:
                self.assertLess(time.monotonic(), deadline, kinds)
                event = stream.next()
                kinds.add(event["event"])
                self.assertEqual(json.loads(event["data"])["id"], job_id)
        self.daemon.request("DELETE", f"/v1/jobs/{job_id}")
        self.daemon.wait_for_job(job_id)
        self.assertLessEqual(kinds, {"state", "progress", "curve"})
        self.assertIn("progress", kinds)

    def test_who_listens_is_counted(self):
        def wait_for_clients(count):
            deadline = deadline_after()
            while self.daemon.request("GET", "/v1/status").json["event_clients"] != count:
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.02)

        wait_for_clients(0)  # that the streams of other tests are gone is noticed a little later
        with EventStream(self.daemon, "/v1/events") as one, EventStream(self.daemon, "/v1/events") as two:
            one.next(), two.next()
            wait_for_clients(2)


if __name__ == "__main__":
    unittest.main()
