"""What the service survives: killed workers, killed helper, a killed daemon, a stopped one. Accepted jobs are never lost
nor doubled, and what they give has the same bits as an undisturbed run.

PHOTOND_KILLS is the number of times the daemon is killed (default 10).
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

KILLS = int(os.environ.get("PHOTOND_KILLS", "10"))
SEEDS = 4
LONGER = {"size": 64, "passes": 300}  # long enough to be hit in the middle


def hash_of(job):
    return job["statistics"]["pixel_hash"]


class WorkerTest(unittest.TestCase):
    """Attempts that end without a result (protocol.md, "The daemon")."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.undisturbed = cls.daemon.wait_for_job(cls.daemon.submit(small_job(**LONGER))["id"])

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def hit(self, job_id, attempt, signal_number):
        """Sends a signal to the worker once that attempt has done a pass; returns the worker's process id."""
        self.daemon.wait_for_job_that(lambda job: len(job["attempts"]) == attempt and job["passes_done"] > 0,
                                      f"to have done a pass of attempt {attempt}", job_id)
        pid = self.daemon.workers()["cpu"]
        os.kill(pid, signal_number)
        return pid

    def test_killed_from_outside_it_runs_again_to_the_same_bits(self):
        job = self.daemon.submit(small_job(**LONGER))
        # What a worker leaves that is killed while it saves its film.
        (self.daemon.data_dir / "films" / (job["id"] + "-1.film.part")).write_bytes(b"half a film")
        pid = self.hit(job["id"], 1, signal.SIGKILL)
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual(job["state"], "succeeded", job["failure"])
        self.assertEqual([a["outcome"] for a in job["attempts"]], ["lost", "succeeded"])
        self.assertIn("signal 9", job["attempts"][0]["reason"])
        self.assertEqual(hash_of(job), hash_of(self.undisturbed))
        self.assertNotEqual(self.daemon.workers()["cpu"], pid)
        films = [film.name for film in (self.daemon.data_dir / "films").glob(job["id"] + "-*")]
        self.assertEqual(films, [job["id"] + "-2.film"])

    def test_lost_three_times_it_fails(self):
        job_id = self.daemon.submit(small_job(size=64, passes=100_000_000))["id"]
        for attempt in (1, 2, 3):
            self.hit(job_id, attempt, signal.SIGKILL)
        job = self.daemon.wait_for_job(job_id)
        self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "worker_lost"))
        self.assertEqual([a["outcome"] for a in job["attempts"]], ["lost"] * 3)

    def test_crashing_twice_it_fails_and_others_go_on(self):
        job_id = self.daemon.submit(small_job(size=64, passes=100_000_000))["id"]
        behind = self.daemon.submit(small_job(**LONGER))["id"]
        for attempt in (1, 2):
            self.hit(job_id, attempt, signal.SIGSEGV)
        job = self.daemon.wait_for_job(job_id)
        self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "worker_crashed"))
        self.assertEqual([a["outcome"] for a in job["attempts"]], ["crashed"] * 2)
        self.assertEqual(hash_of(self.daemon.wait_for_job(behind)), hash_of(self.undisturbed))
        # By hand it may be tried again, with its attempts counted anew.
        self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{job_id}/retry").status, 202)
        self.hit(job_id, 3, signal.SIGSEGV)
        self.daemon.wait_for_job_that(lambda job: len(job["attempts"]) == 4, "to be tried again after one crash", job_id)
        self.daemon.request("DELETE", f"/v1/jobs/{job_id}")
        self.assertEqual(self.daemon.wait_for_job(job_id)["state"], "cancelled")

    def test_a_killed_helper_is_replaced(self):
        helper = next(w["pid"] for w in self.daemon.request("GET", "/v1/status").json["workers"] if w["device"] == "none")
        os.kill(helper, signal.SIGKILL)
        image = self.daemon.request("GET", f"/v1/jobs/{self.undisturbed['id']}/image.exr?precision=half")
        self.assertEqual(image.status, 200, image)
        self.daemon.wait_ready()


class HungWorkerTest(unittest.TestCase):
    def test_a_silent_worker_is_replaced(self):
        with Daemon("--heartbeat-timeout", 5) as daemon:
            daemon.wait_ready()
            expected = hash_of(daemon.wait_for_job(daemon.submit(small_job(**LONGER))["id"]))
            job_id = daemon.submit(small_job(**LONGER))["id"]
            daemon.wait_for_passes(job_id)
            os.kill(daemon.workers()["cpu"], signal.SIGSTOP)
            self.assertEqual(daemon.request("GET", "/healthz").status, 200)
            job = daemon.wait_for_job(job_id)
            self.assertEqual([a["outcome"] for a in job["attempts"]], ["hung", "succeeded"])
            self.assertEqual(hash_of(job), expected)

    def test_a_deaf_worker_cannot_hold_a_cancelled_job(self):
        with Daemon() as daemon:
            daemon.wait_ready()
            job_id = daemon.submit(small_job(size=64, passes=100_000_000))["id"]
            daemon.wait_for_passes(job_id)
            os.kill(daemon.workers()["cpu"], signal.SIGSTOP)
            self.assertEqual(daemon.request("DELETE", f"/v1/jobs/{job_id}").status, 202)
            self.assertEqual(daemon.wait_for_job(job_id)["state"], "cancelled")
            self.assertEqual(daemon.wait_for_job(daemon.submit(small_job())["id"])["state"], "succeeded")

    def test_a_job_past_its_deadline_fails(self):
        with Daemon("--max-job-seconds", 1) as daemon:
            job = daemon.wait_for_job(daemon.submit(small_job(passes=100_000_000))["id"])
            self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "timed_out"))
            self.assertEqual(daemon.wait_for_job(daemon.submit(small_job())["id"])["state"], "succeeded")


class GracefulStopTest(unittest.TestCase):
    def test_running_job_goes_back_to_the_queue(self):
        with Daemon() as daemon:
            daemon.wait_ready()
            expected = hash_of(daemon.wait_for_job(daemon.submit(small_job(**LONGER))["id"]))
            job_id = daemon.submit(small_job(**LONGER))["id"]
            behind = daemon.submit(small_job(**LONGER))["id"]
            daemon.wait_for_passes(job_id)
            workers = daemon.children()
            self.assertEqual(daemon.stop(), 0)
            for pid in workers:
                self.assertFalse(os.path.exists(f"/proc/{pid}"), "a child outlived the daemon")
            self.assertTrue(list((daemon.data_dir / "films").glob(job_id + "-1.film")), "its film was not saved")
            daemon.start()
            job = daemon.wait_for_job(job_id)
            self.assertEqual([a["outcome"] for a in job["attempts"]], ["stopped", "succeeded"])
            self.assertEqual([hash_of(job), hash_of(daemon.wait_for_job(behind))], [expected] * 2)

    def test_one_daemon_per_folder_and_no_open_door(self):
        with Daemon() as daemon:
            with self.assertRaises(RuntimeError):
                Daemon(data_dir=daemon.data_dir)
            self.assertEqual(daemon.request("GET", "/healthz").status, 200)
        with self.assertRaises(RuntimeError):
            Daemon("--listen", "0.0.0.0:0")
        with self.assertRaises(RuntimeError):
            Daemon("--devices", "gpu:99")


class ProgressTest(unittest.TestCase):
    def test_losses_are_counted_since_the_last_saved_progress(self):
        with Daemon("--save-seconds", 0.1) as daemon:
            daemon.wait_ready()
            job_id = daemon.submit(small_job(size=64, passes=100_000_000))["id"]
            for attempt in range(1, 6):
                daemon.wait_for_kept_film(job_id, attempt)
                daemon.kill()
                daemon.start()
                daemon.wait_ready()
            job = daemon.job(job_id)
            self.assertEqual([a["outcome"] for a in job["attempts"]][:5], ["lost"] * 5)
            self.assertIn(job["state"], ("queued", "running"))
            daemon.request("DELETE", f"/v1/jobs/{job_id}")


class KilledDaemonTest(unittest.TestCase):
    """Clients go on submitting, with idempotency keys, while the daemon is killed again and again."""

    def setUp(self):
        self.daemon = Daemon()
        self.addCleanup(self.daemon.close)
        self.daemon.wait_ready()
        self.expected = {}
        for seed in range(1, SEEDS + 1):
            job = self.daemon.wait_for_job(self.daemon.submit(small_job(seed=seed))["id"])
            self.expected[seed] = hash_of(job)
        self.assertEqual(len(set(self.expected.values())), SEEDS)
        self.accepted = {}  # key -> set of ids it was ever answered with
        self.seeds = {}
        self.done = threading.Event()
        self.lock = threading.Lock()

    def client(self, name):
        number = 0
        while not self.done.is_set():
            key, seed = f"{name}-{number}", number % SEEDS + 1
            self.seeds[key] = seed
            while True:  # until it is answered, as a client should
                try:
                    reply = self.daemon.request("POST", "/v1/jobs", json_body=small_job(seed=seed),
                                                headers={"Idempotency-Key": key})
                    if reply.status == 202:
                        with self.lock:
                            self.accepted.setdefault(key, set()).add(reply.json["id"])
                        break
                except (OSError, ValueError, http.client.HTTPException):
                    pass
                if self.done.wait(0.02):
                    return
            number += 1
            if self.done.wait(0.1):
                return

    def test_nothing_is_lost_or_doubled(self):
        randomness = random.Random(20260101)
        clients = [threading.Thread(target=self.client, args=(f"c{i}",)) for i in range(4)]
        for client in clients:
            client.start()
        try:
            for kill in range(KILLS):
                if kill % 2:  # else it may be while it starts
                    before = len(self.accepted)
                    wait_until(lambda: len(self.accepted) > before, "a job is accepted", self.daemon)
                time.sleep(randomness.uniform(0.02, 0.6))
                children = self.daemon.children()
                self.daemon.kill()
                wait_until(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in children), "children live on")
                store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
                self.assertEqual(store.execute("PRAGMA integrity_check").fetchone(), ("ok",))
                store.close()
                self.daemon.start()
        finally:
            self.done.set()
            for client in clients:
                client.join()
        succeeded = 0
        for key, ids in self.accepted.items():
            self.assertEqual(len(ids), 1, f"{key} was accepted as several jobs")
            job = self.daemon.wait_for_job(next(iter(ids)))
            if job["state"] == "failed":  # only by the true reason: hit at every one of its attempts
                self.assertEqual(job["failure"]["code"], "worker_lost")
                self.assertEqual([a["outcome"] for a in job["attempts"]], ["lost"] * 3)
                continue
            self.assertEqual(job["state"], "succeeded")
            self.assertEqual(hash_of(job), self.expected[self.seeds[key]])
            succeeded += 1
        self.assertGreater(succeeded, len(self.accepted) * 0.9)

        # Every job in the store belongs to a request, and every film to a job.
        jobs, cursor = [], ""
        while cursor is not None:
            page = self.daemon.request("GET", "/v1/jobs?limit=1000" + cursor).json
            jobs += [self.daemon.wait_for_job(job["id"]) for job in page["items"]]
            cursor = page["next_cursor"] and f"&cursor={page['next_cursor']}"
        self.assertLessEqual(len(jobs) - SEEDS, len(self.seeds), "more jobs than requests")
        films = sorted(film.name for film in (self.daemon.data_dir / "films").iterdir())
        named = sorted(f"{job['id']}-{len(job['attempts'])}.film" for job in jobs if job["state"] == "succeeded")
        self.assertEqual(films, named)
        newest = next(job for job in jobs if job["state"] == "succeeded")
        self.assertEqual(self.daemon.request("GET", newest["links"]["image"]).status, 200)


if __name__ == "__main__":
    unittest.main()
