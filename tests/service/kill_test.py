"""kill -9 of the daemon and of its worker at random moments, while clients submit jobs and comparisons with idempotent
retries (reliability.md, "Kills"): accepted jobs lost 0, doubled 0, pixel hashes other than undisturbed 0, tables
of comparisons complete and equal to the undisturbed one.

100 kills in CI; 1,000 in the long form. Moments come from a fixed seed. A job that is hit at every one of its attempts
fails by its true reason, `worker_lost`; it is then retried, as its owner would, and goes on from its last film.
"""

import http.client
import os
import pathlib
import random
import signal
import sqlite3
import sys
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from photond_daemon import Daemon, small_job, wait_until  # noqa: E402

SEEDS = 3
CLIENTS = 2
# Clients are paced by kills, not by the clock, so that a slow machine does the same work as a fast one.
KILLS_PER_JOB = 3          # of one client
KILLS_PER_COMPARISON = 40
PASSES = 300
SIZE = 48
COMPARISON = {
    "scene": "cornell-box", "image": {"width": SIZE, "height": SIZE},
    "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 300}},
    "entries": [{"label": "deep", "method": {"name": "path_tracing"}},
                {"label": "shallow", "method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": [1, 2]}}],
    "stop": {"passes": PASSES}, "metrics": ["relative_mse", "rmse"], "seeds": [1, 2],
}
OVER = ("succeeded", "failed", "cancelled")


def job_of(seed):
    return small_job(size=SIZE, passes=PASSES, seed=seed)


def errors_at_passes(report):
    """{(label, parameters, seed): {passes: metrics}}, of the points after 1, 2, 4 ... passes and at the end: those at
    moments of the clock depend on the machine."""
    fixed = {2 ** k for k in range(32)} | {PASSES}
    points_of = {curve["job"]: curve["points"] for curve in report["curves"]}
    return {(job["label"], str(sorted(job["parameters"].items())), job["seed"]):
            {point["passes"]: [point["metrics"][name] for name in COMPARISON["metrics"]]
             for point in points_of[job["id"]] if point["passes"] in fixed}
            for job in report["jobs"]}


class Disturbed(unittest.TestCase):
    kills = 0  # set by the forms below

    @classmethod
    def setUpClass(cls):
        if not cls.kills:
            raise unittest.SkipTest("the forms below say how often")

    def setUp(self):
        self.daemon = Daemon("--save-seconds", 0.1)
        self.addCleanup(self.daemon.close)
        self.daemon.wait_ready()
        self.expected = {}
        for seed in range(1, SEEDS + 1):
            self.expected[seed] = self.hash_of(self.daemon.wait_for_job(self.daemon.submit(job_of(seed))["id"]))
        self.assertEqual(len(set(self.expected.values())), SEEDS)
        first = self.daemon.request("POST", "/v1/comparisons", json_body=COMPARISON)
        self.assertEqual(first.status, 202, first)
        self.undisturbed = self.comparison_over(first.json["id"])
        self.assertEqual(self.undisturbed["state"], "succeeded")
        self.undisturbed_hashes = self.hashes_of(self.undisturbed)
        self.undisturbed_errors = errors_at_passes(self.report_of(self.undisturbed))
        self.assertEqual(len(self.undisturbed_errors), 6)
        self.accepted = {}  # key -> set of ids it was ever answered with
        self.seeds = {}     # key -> seed of a job; none for a comparison
        self.done = threading.Event()
        self.lock = threading.Lock()
        self.struck = threading.Condition()
        self.strikes = 0    # kills so far

    # --- looking ------------------------------------------------------------------------------------------------------
    @staticmethod
    def hash_of(job):
        return job["statistics"]["pixel_hash"]

    def comparison(self, comparison_id):
        reply = self.daemon.request("GET", f"/v1/comparisons/{comparison_id}")
        self.assertEqual(reply.status, 200, reply)
        return reply.json

    def comparison_over(self, comparison_id):
        wait_until(lambda: self.comparison(comparison_id)["state"] in OVER, f"{comparison_id} does not end")
        return self.comparison(comparison_id)

    def report_of(self, comparison):
        reply = self.daemon.request("GET", f"/v1/comparisons/{comparison['id']}/report.json")
        self.assertEqual(reply.status, 200, reply)
        return reply.json

    def hashes_of(self, comparison):
        return [self.hash_of(self.daemon.job(job["id"])) for job in comparison["jobs"]]

    # --- disturbing ---------------------------------------------------------------------------------------------------
    def submit_until_answered(self, path, body, key):
        """As a client should: the same request again until it is answered. False when the test ends first."""
        while True:
            try:
                reply = self.daemon.request("POST", path, json_body=body, headers={"Idempotency-Key": key}, timeout_s=5)
                if reply.status == 202:
                    with self.lock:
                        self.accepted.setdefault(key, set()).add(reply.json["id"])
                    return True
            except (OSError, ValueError, http.client.HTTPException):
                pass
            if self.done.wait(0.02):
                return False

    def wait_for_strikes(self, count):
        """False when the test ends first."""
        with self.struck:
            self.struck.wait_for(lambda: self.strikes >= count or self.done.is_set())
        return not self.done.is_set()

    def submit_jobs(self, name):
        for number in range(1_000_000):
            key, seed = f"{name}-{number}", number % SEEDS + 1
            self.seeds[key] = seed
            if not (self.submit_until_answered("/v1/jobs", job_of(seed), key)
                    and self.wait_for_strikes((number + 1) * KILLS_PER_JOB)):
                return

    def submit_comparisons(self):
        for number in range(1_000_000):
            key = f"comparison-{number}"
            if not (self.submit_until_answered("/v1/comparisons", COMPARISON, key)
                    and self.wait_for_strikes((number + 1) * KILLS_PER_COMPARISON)):
                return

    def kill_daemon(self):
        children = self.daemon.children()
        self.daemon.kill()
        wait_until(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in children), "children live on")
        store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
        try:
            self.assertEqual(store.execute("PRAGMA integrity_check").fetchone(), ("ok",))
        finally:
            store.close()
        self.daemon.start()

    def kill_worker(self):
        pid = self.daemon.workers().get("cpu")
        if pid is None:
            return False  # between two of them
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            return False
        return True

    # --- judging ------------------------------------------------------------------------------------------------------
    def succeeded(self, job_id):
        """The job, over; one that was hit at every attempt is retried until it is through."""
        while True:
            job = self.daemon.wait_for_job(job_id)
            if job["state"] == "succeeded":
                return job
            self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "worker_lost"), job["failure"])
            self.assertEqual([a["outcome"] for a in job["attempts"]][-3:], ["lost"] * 3)
            self.retried += 1
            self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{job_id}/retry").status, 202)

    def test_nothing_is_lost_doubled_or_different(self):
        randomness = random.Random(20261121)
        self.retried = 0
        threads = [threading.Thread(target=self.submit_jobs, args=(f"c{i}",)) for i in range(CLIENTS)]
        threads.append(threading.Thread(target=self.submit_comparisons))
        for thread in threads:
            thread.start()
        hit = {"daemon": 0, "worker": 0}
        try:
            while sum(hit.values()) < self.kills:
                time.sleep(randomness.uniform(0.02, 0.9))
                if randomness.random() < 0.5:
                    self.kill_daemon()
                    hit["daemon"] += 1
                elif self.kill_worker():
                    hit["worker"] += 1
                with self.struck:
                    self.strikes = sum(hit.values())
                    self.struck.notify_all()
        finally:
            with self.struck:
                self.done.set()
                self.struck.notify_all()
            for thread in threads:
                thread.join()

        resumed = 0
        comparisons = []
        for key, ids in self.accepted.items():
            self.assertEqual(len(ids), 1, f"{key} was accepted as several")
            if key not in self.seeds:
                comparisons.append(next(iter(ids)))
                continue
            job = self.succeeded(next(iter(ids)))
            self.assertEqual(self.hash_of(job), self.expected[self.seeds[key]], key)
            resumed += job["statistics"]["resumed_passes"] > 0
        self.assertGreater(len(comparisons), 0)
        for comparison_id in comparisons:
            for job in self.comparison(comparison_id)["jobs"]:
                resumed += self.succeeded(job["id"])["statistics"]["resumed_passes"] > 0
            comparison = self.comparison_over(comparison_id)
            self.assertEqual(comparison["state"], "succeeded")
            self.assertEqual(self.hashes_of(comparison), self.undisturbed_hashes)
            self.assertEqual(len(comparison["table"]), len(self.undisturbed["table"]))
            self.assertEqual(errors_at_passes(self.report_of(comparison)), self.undisturbed_errors)

        # Every job in the store belongs to a request, and every film to a job.
        jobs, cursor = [], ""
        while cursor is not None:
            page = self.daemon.request("GET", "/v1/jobs?limit=1000" + cursor).json
            jobs += page["items"]
            cursor = page["next_cursor"] and f"&cursor={page['next_cursor']}"
        plain = [job for job in jobs if job["role"] == "render" and job["comparison"] is None]
        self.assertLessEqual(len(plain) - SEEDS, len(self.seeds), "more jobs than requests")
        self.assertEqual(len([job for job in jobs if job["role"] == "reference"]), 2, "two films of one reference for all")
        listed = self.daemon.request("GET", "/v1/comparisons?limit=1000").json["items"]
        self.assertEqual(len(listed), len(comparisons) + 1)
        films = {film.name.split("-")[0] for film in (self.daemon.data_dir / "films").iterdir()}
        self.assertEqual(films, {job["id"] for job in jobs})
        self.assertEqual(len(list((self.daemon.data_dir / "films").iterdir())), len(jobs), "a film too many")
        print(f"{hit['daemon']} kills of the daemon, {hit['worker']} of the worker: {len(plain)} jobs and "
              f"{len(comparisons)} comparisons, {resumed} went on from a film, {self.retried} retried by hand")


class HundredKillsTest(Disturbed):
    kills = int(os.environ.get("PHOTOND_KILLS", "100"))


@unittest.skipUnless(os.environ.get("PHOTOND_LONG"), "by the label long")
class LongThousandKillsTest(Disturbed):
    kills = 1000


if __name__ == "__main__":
    unittest.main()
