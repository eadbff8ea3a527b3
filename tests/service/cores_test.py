"""Whether a job had its cores: a foreign busy loop is named in its statistics, its log and by the clients. How much it took
is printed, and asserted in the long form alone, on an idle machine."""

import os
import statistics as figures
import subprocess
import time
import unittest

from busy_loops import CORES, BusyLoops
from photond_daemon import BIN, DaemonTestCase, small_job

UNDISTURBED = 0.98
SENTENCE = r"^\S+ m?s of its processor time \(\d+ %\) were lost to .*: its clock cannot be compared; run it again\.$"


def timed_job(seconds, **more):
    return small_job(size=128, passes=None, stop={"seconds": seconds}, **more)


class CoresTest(DaemonTestCase):
    def test_every_job_says_what_it_had(self):
        cores = self.daemon.run_job(small_job(size=64, passes=4))["statistics"]["cores"]
        self.assertGreater(cores["processor_seconds"], 0)
        if cores["run_delay_seconds"] is None:
            self.skipTest("this kernel does not say how long threads wait")
        self.assertLessEqual(cores["lost_seconds"], cores["run_delay_seconds"])
        self.assertTrue(0 <= cores["share"] <= 1, cores)
        print(cores)

    def test_a_busy_loop_is_named(self):
        with BusyLoops():
            job = self.daemon.run_job(timed_job(0.7))
        statistics = job["statistics"]
        if statistics["cores"]["run_delay_seconds"] is None:
            self.assertIsNone(statistics["shared"])
            self.skipTest("this kernel does not say how long threads wait")
        shared = statistics["shared"]
        self.assertIsNotNone(shared, statistics["cores"])
        self.assertLess(shared["share"], UNDISTURBED)
        self.assertEqual(shared["lost_seconds"], statistics["cores"]["lost_seconds"])
        self.assertEqual(shared["share"], statistics["cores"]["share"])
        self.assertEqual(shared["to"][0]["who"], "others", shared)
        self.assertLessEqual(sum(taker["seconds"] for taker in shared["to"]), 1.001 * shared["lost_seconds"])
        self.assertRegex(shared["warning"], SENTENCE)
        self.assertIn("lost to others", shared["warning"])
        log = self.daemon.request("GET", f"/v1/jobs/{job['id']}/log.txt").text
        self.assertIn("warning: " + shared["warning"], log)
        url = f"http://{self.daemon.address}:{self.daemon.port}"
        shown = subprocess.run([BIN / "photonctl", "jobs", "show", job["id"]], env={**os.environ, "PHOTOND_URL": url},
                               capture_output=True, text=True, check=True).stdout
        self.assertIn(shared["warning"], shown)
        print(shared)

    def test_a_merged_film_has_no_one_clock(self):
        parts = [self.daemon.run_job(small_job(passes=1, first_pass=first)) for first in (0, 1)]
        merged = self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": [job["id"] for job in parts]}).json
        self.assertIsNone(merged["statistics"]["cores"])
        self.assertIsNone(merged["statistics"]["shared"])


class QuietMachineTest(DaemonTestCase):
    def log(self, job):
        return self.daemon.request("GET", f"/v1/jobs/{job['id']}/log.txt").text

    def test_begins_all_the_same_when_the_machine_stays_busy(self):
        with BusyLoops():
            job = self.daemon.submit(small_job(quiet_machine=2))

            found = self.daemon.wait_for_job_that(lambda job: job["waiting_for"] == "a quiet machine",
                                                  "to wait for a quiet machine", job["id"])
            self.assertEqual(found["state"], "queued")
            listed = self.daemon.request("GET", "/v1/jobs?view=summary&state=queued").json["items"]
            self.assertEqual([row["waiting_for"] for row in listed], ["a quiet machine"])
            behind = self.daemon.submit(small_job())  # keeps its place
            self.assertEqual(self.daemon.job(behind["id"])["waiting_for"], "its turn on cpu")
            done = self.daemon.wait_for_job(job["id"])
        self.assertEqual(done["state"], "succeeded")
        self.assertIsNone(done["waiting_for"])
        self.assertRegex(self.log(job), r"waits until nothing else runs on the machine, at most 2 s\n")
        self.assertRegex(self.log(job), r"warning: the machine is not quiet after \S+ s \(\S+ % of its processors are busy\): "
                                        r"it begins all the same\n")
        self.assertGreaterEqual(self.daemon.wait_for_job(behind["id"])["started"], done["started"])

    def test_others_do_not_wait(self):
        with BusyLoops():
            job = self.daemon.run_job(small_job())
        self.assertNotIn("waits until", self.log(job))

    def test_a_job_that_waits_can_be_cancelled(self):
        with BusyLoops():
            job = self.daemon.submit(small_job(quiet_machine=3600))
            self.daemon.request("DELETE", f"/v1/jobs/{job['id']}")
            self.assertEqual(self.daemon.wait_for_job(job["id"])["state"], "cancelled")
            self.daemon.run_job(small_job())

    def test_what_it_waits_for_is_no_part_of_what_it_shows(self):
        first, second = (self.daemon.run_job(small_job(**more)) for more in ({}, {"quiet_machine": 0}))
        for key in ("job_hash", "settings_hash", "pixel_hash"):
            self.assertEqual(first["statistics"][key], second["statistics"][key])


@unittest.skipUnless("PHOTOND_LONG" in os.environ, "takes an idle machine")
class LongCoresTest(DaemonTestCase):
    """What is said to be lost is what the same job is slower by, to 5 points of a hundred; alone nothing is lost."""

    def rate(self, loops):
        """Passes a second, and the share that the job says it had."""
        with BusyLoops(loops):
            if loops:
                time.sleep(0.2)
            job = self.daemon.run_job(timed_job(3))
        return job["passes_done"] / job["seconds"], job["statistics"]["cores"]["share"]

    def test_a_job_waits_for_the_busy_loop_to_end(self):
        with BusyLoops(1):
            job = self.daemon.submit(small_job(quiet_machine=60))
            time.sleep(4)
            self.assertEqual(self.daemon.job(job["id"])["state"], "queued")
        job = self.daemon.wait_for_job(job["id"])
        self.assertIn("the machine is quiet, after", self.daemon.request("GET", job["links"]["log"]).text)

    def test_a_busy_loop_is_quantified(self):
        self.rate(0)  # the first job's costs
        for loops in sorted({1, CORES // 2 or 1, CORES}):
            alone, beside = [], []
            for _ in range(3):
                alone.append(self.rate(0))
                beside.append(self.rate(loops))
            expected = figures.median(rate for rate, _ in beside) / figures.median(rate for rate, _ in alone)
            share = figures.median(share for _, share in beside)
            print(f"{loops} loops on {CORES} cores: {share:.3f} of its processor time, {expected:.3f} of its speed")
            for _, share_alone in alone:
                self.assertGreaterEqual(share_alone, UNDISTURBED, "the machine is not idle")
            self.assertAlmostEqual(share, expected, delta=0.05)


if __name__ == "__main__":
    unittest.main()
