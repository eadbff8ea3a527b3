"""kill -9 of the daemon and of its worker at random moments, while clients submit jobs and comparisons with idempotent
retries (reliability.md, "Kills"): accepted jobs lost 0, doubled 0, pixel hashes other than undisturbed 0, tables
of comparisons complete and equal to the undisturbed one.

In CI each of the two is killed once at each of the moments of ChosenKillsTest, the moments at which something is half
done. The long form kills 1,000 times at random moments, which come from a fixed seed. A job that is hit at every one of its
attempts fails by its true reason, `worker_lost`; it is then retried, as its owner would, and goes on from its last film.
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
from photond_daemon import OVER, Daemon, small_job, wait_until  # noqa: E402

SEEDS = 3
CLIENTS = 2
# Clients are paced by kills, not by the clock, so that a slow machine does the same work as a fast one.
KILLS_PER_JOB = 4          # of one client
KILLS_PER_COMPARISON = 10
PASSES = 200
SIZE = 32
COMPARISON = {
    "scene": "cornell-box", "image": {"width": SIZE, "height": SIZE},
    "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 200}},
    "entries": [{"label": "deep", "method": {"name": "path_tracing"}},
                {"label": "shallow", "method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": [1, 2]}}],
    "stop": {"passes": PASSES}, "metrics": ["relative_mse", "rmse"], "seeds": [1, 2],
}


def job_of(seed, **more):
    return small_job(size=SIZE, passes=PASSES, seed=seed, **more)


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
    """What is done around the kills; the forms below kill, in disturb()."""

    def setUp(self):
        self.daemon = Daemon("--save-seconds", 0.05)
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
        return self.daemon.wait_for_state(f"/v1/comparisons/{comparison_id}")

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
                reply = self.daemon.request("POST", path, json_body=body, headers={"Idempotency-Key": key})
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
        """Kills the daemon, looks at its store, and starts it again."""
        children = self.daemon.children()
        self.daemon.kill()
        wait_until(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in children), "its children have ended")
        store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
        try:
            self.assertEqual(store.execute("PRAGMA integrity_check").fetchone(), ("ok",))
        finally:
            store.close()
        self.daemon.start()

    def kill_worker(self, pid=None):
        """False where there is none, between two of them. `pid` is that of one that is known."""
        pid = pid or self.daemon.workers().get("cpu")
        if pid is None:
            return False
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            return False
        return True

    def count(self, victim):
        """Notes a kill, by which the clients are paced."""
        with self.struck:
            self.hit[victim] += 1
            self.strikes += 1
            self.struck.notify_all()

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
        self.retried = 0
        self.hit = {"daemon": 0, "worker": 0}
        threads = [threading.Thread(target=self.submit_jobs, args=(f"c{i}",)) for i in range(CLIENTS)]
        threads.append(threading.Thread(target=self.submit_comparisons))
        for thread in threads:
            thread.start()
        try:
            self.disturb()
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
        print(f"{self.hit['daemon']} kills of the daemon, {self.hit['worker']} of the worker: {len(plain)} jobs and "
              f"{len(comparisons)} comparisons, {resumed} went on from a film, {self.retried} retried by hand")


class ChosenKillsTest(Disturbed):
    """The daemon and the worker are killed, each once at each moment of MOMENTS. A moment belongs to a job, or to a comparison,
    that is submitted for it and goes before what the clients submit. One that passes before it is met is sought again with
    another job.
    """

    def being_submitted(self, key):
        """The request is under way: it may have been stored or not, and has not been answered."""
        self.seeds[key] = 1
        submission = threading.Thread(target=self.submit_until_answered, args=("/v1/jobs", job_of(1), key))
        submission.start()
        self.addCleanup(submission.join)

    def accepted_now(self, key):
        """The job waits, and no attempt of it may have begun."""
        self.submitted(key)

    def attempt_begins(self, key):
        """The worker loads the scene, or has just begun to render."""
        self.seek(self.submitted(key), lambda job: job["state"] == "running")

    def passes_are_done(self, key):
        """What was rendered may not have been saved."""
        self.seek(self.submitted(key), lambda job: job["passes_done"] > 0)

    def film_is_written(self, key):
        """Half of a film lies on the disk, under another name."""
        self.seek_file(self.submitted(key), "-1.film.part")

    def film_is_saved(self, key):
        """The daemon may not have heard of it."""
        self.seek_file(self.submitted(key), "-1.film")

    def goes_on_from_its_film(self, key):
        """A second attempt renders, of a job whose worker was killed after its first film."""
        job_id = self.submitted(key)
        self.seek_file(job_id, "-1.film")
        self.kill_worker()
        self.count("worker")
        self.seek(job_id, lambda job: len(job["attempts"]) > 1 and job["passes_done"] > 0)

    def end_is_near(self, key):
        """The last passes are done, the last film is written, and the end is told and recorded."""
        self.seek(self.submitted(key), lambda job: job["progress"] > 0.9)

    def over_now(self, key):
        """The end has just been recorded."""
        self.daemon.wait_for_job(self.submitted(key))

    def comparison_is_accepted(self, key):
        """Its jobs are all in the store, or none is."""
        self.compared(key)

    def job_of_a_comparison_is_over(self, key):
        """The next one begins, and the table changes."""
        jobs = self.compared(key)["jobs"]
        self.daemon.wait_for_job(jobs[1]["id"])

    def started_now(self, key):
        """The daemon listens; its workers start, and what was lost is queued again."""
        self.submitted(key)
        self.kill_daemon()
        self.count("daemon")

    MOMENTS = (being_submitted, accepted_now, attempt_begins, passes_are_done, film_is_written, film_is_saved,
               goes_on_from_its_film, end_is_near, over_now, comparison_is_accepted, job_of_a_comparison_is_over, started_now)

    class Missed(Exception):
        """The job was over before its moment was met."""

    def submitted(self, key):
        self.seeds[key] = 1
        self.assertTrue(self.submit_until_answered("/v1/jobs", job_of(1, priority=50), key))
        return next(iter(self.accepted[key]))

    def compared(self, key):
        self.assertTrue(self.submit_until_answered("/v1/comparisons", {**COMPARISON, "priority": 50}, key))
        return self.comparison(next(iter(self.accepted[key])))

    def seek(self, job_id, arrived):
        while not arrived(job := self.daemon.job(job_id)):
            if job["state"] in OVER:
                raise self.Missed

    def seek_file(self, job_id, ending):
        """The file of the job that ends in that; it may be there for less than a millisecond."""
        path = str(self.daemon.data_dir / "films" / (job_id + ending))
        while True:
            for _ in range(1000):
                if os.path.exists(path):
                    return
            if self.daemon.job(job_id)["state"] in OVER:
                raise self.Missed

    def disturb(self):
        missed = 0
        for moment in self.MOMENTS:
            for victim in ("daemon", "worker"):
                while True:
                    worker = self.daemon.wait_until(lambda: self.daemon.workers().get("cpu"), "there is a worker")
                    try:
                        moment(self, f"{moment.__name__}-{victim}-{missed}")
                        break
                    except self.Missed:
                        missed += 1
                if victim == "daemon":
                    self.kill_daemon()
                elif not self.kill_worker(worker):  # it is another one by now
                    self.daemon.wait_until(self.kill_worker, "there is a worker to be killed")
                self.count(victim)
        print(f"{len(self.MOMENTS)} moments; {missed} were missed at first")


@unittest.skipUnless(os.environ.get("PHOTOND_LONG"), "by the label long")
class LongThousandKillsTest(Disturbed):
    KILLS = int(os.environ.get("PHOTOND_KILLS", "1000"))

    def disturb(self):
        randomness = random.Random(20261121)
        while self.strikes < self.KILLS:
            time.sleep(randomness.uniform(0.02, 0.9))
            if randomness.random() < 0.5:
                self.kill_daemon()
                self.count("daemon")
            elif self.kill_worker():
                self.count("worker")


del Disturbed  # a base, not a test case
if __name__ == "__main__":
    unittest.main()
