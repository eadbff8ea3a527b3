"""Films as artefacts: saved while a job runs, gone on from after a kill, extended, merged. Whatever way the passes of
an image came together, its bits are those of one undisturbed run.
"""

import os
import signal
import unittest

from photond_daemon import Daemon, small_job

ENDLESS = 100_000_000  # passes: over long after the test
LONGER = {"size": 64, "passes": 800}  # long enough to be hit in the middle


def hash_of(job):
    return job["statistics"]["pixel_hash"]


class ResumingTest(unittest.TestCase):
    """Of a worker or daemon that is killed only what came after the last saving is lost."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--save-seconds", 0.05, "--threads", 1)
        cls.daemon.wait_ready()
        cls.undisturbed = cls.daemon.wait_for_job(cls.daemon.submit(small_job(**LONGER))["id"])

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def films(self, job):
        return sorted(film.name for film in (self.daemon.data_dir / "films").glob(job["id"] + "-*.film"))

    def saved(self, job):
        """The job, running, once a film of it was saved."""
        self.daemon.wait_for_kept_film(job["id"])  # of the first attempt
        self.daemon.wait_for_passes(job["id"])
        running = self.daemon.job(job["id"])
        self.assertEqual(running["state"], "running", "too fast to be hit: make it longer")
        return running

    def check_went_on(self, job):
        self.assertEqual(job["state"], "succeeded", job["failure"])
        self.assertEqual(hash_of(job), hash_of(self.undisturbed))
        self.assertGreater(job["statistics"]["resumed_passes"], 0)
        self.assertEqual(job["passes_done"], LONGER["passes"])
        self.assertEqual(self.films(job), [f"{job['id']}-{len(job['attempts'])}.film"])
        log = self.daemon.request("GET", job["links"]["log"]).text
        self.assertIn("going on from a film of", log)
        passes = [point["passes"] for point in job["curve"]]
        self.assertEqual(passes, sorted(set(passes)), "one curve over all attempts")

    def test_a_killed_worker(self):
        job = self.daemon.submit(small_job(**LONGER))
        self.saved(job)
        os.kill(self.daemon.workers()["cpu"], signal.SIGKILL)
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual([a["outcome"] for a in job["attempts"]], ["lost", "succeeded"])
        self.assertGreater(job["attempts"][1]["passes_done"], job["attempts"][0]["passes_done"] - 1)
        self.check_went_on(job)

    def test_a_killed_daemon(self):
        job = self.daemon.submit(small_job(**LONGER))
        self.saved(job)
        self.daemon.kill()
        self.daemon.start()
        held = self.daemon.job(job["id"])
        self.assertGreater(held["passes_done"], 0, "what is saved is there at once")
        self.check_went_on(self.daemon.wait_for_job(job["id"]))

    def test_a_damaged_film(self):
        job = self.daemon.submit(small_job(**LONGER))
        self.saved(job)
        self.daemon.kill()
        (name,) = self.films(job)
        film = self.daemon.data_dir / "films" / name
        content = bytearray(film.read_bytes())
        content[len(content) // 2] ^= 1
        film.write_bytes(content)
        self.daemon.start()
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual((job["state"], hash_of(job)), ("succeeded", hash_of(self.undisturbed)))
        self.assertEqual(job["statistics"]["resumed_passes"], 0)
        self.assertIn("begins anew", self.daemon.request("GET", job["links"]["log"]).text)

    def test_a_cancelled_job_is_retried_from_its_film(self):
        job = self.daemon.submit(small_job(**LONGER))
        self.saved(job)
        self.daemon.request("DELETE", f"/v1/jobs/{job['id']}")
        cancelled = self.daemon.wait_for_job(job["id"])
        self.assertEqual(cancelled["state"], "cancelled")
        self.assertGreater(cancelled["passes_done"], 0)
        retried = self.daemon.request("POST", f"/v1/jobs/{job['id']}/retry")
        self.assertEqual(retried.status, 202, retried)
        self.check_went_on(self.daemon.wait_for_job(job["id"]))

    def test_a_failed_job_keeps_its_film(self):
        job = self.daemon.submit(small_job(size=64, passes=ENDLESS))
        running = self.saved(job)
        # Two crashes fail it unless a film is saved between them, which a slow look may let happen.
        while running["state"] != "failed":
            attempts = len(running["attempts"])
            os.kill(self.daemon.workers()["cpu"], signal.SIGSEGV)
            running = self.daemon.wait_for_job_that(
                lambda job: len(job["attempts"]) > attempts or job["state"] == "failed",
                "to be tried again or to have failed", job["id"])
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual(job["failure"]["code"], "worker_crashed")
        self.assertGreater(job["passes_done"], 0)
        self.assertEqual(self.daemon.request("GET", job["links"]["image"]).status, 200)


class JoiningTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.whole = cls.daemon.run_job(small_job(passes=48))

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def extend(self, job_id, stop, status=202):
        reply = self.daemon.request("POST", f"/v1/jobs/{job_id}/extend", json_body={"stop": stop})
        self.assertEqual(reply.status, status, reply)
        return reply.json

    def merge(self, jobs, status=201, **options):
        ids = [job["id"] for job in jobs]
        reply = self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": ids}, **options)
        self.assertEqual(reply.status, status, reply)
        return reply.json

    def parts(self, number, passes=48, **more):
        cuts = [passes * i // number for i in range(number + 1)]
        return [self.daemon.submit(small_job(passes=last - first, first_pass=first, **more))
                for first, last in zip(cuts, cuts[1:])]

    # --- extend

    def test_extended_it_is_the_longer_job(self):
        job = self.daemon.run_job(small_job(passes=16))
        extended = self.extend(job["id"], {"passes": 48})
        self.assertEqual((extended["id"], extended["state"], extended["request"]["stop"]["passes"]),
                         (job["id"], "queued", 48))
        self.assertEqual(extended["passes_done"], 16)
        self.extend(job["id"], {"passes": 48})  # heard no answer, said again
        done = self.daemon.wait_for_job(job["id"])
        self.assertEqual((hash_of(done), done["passes_done"]), (hash_of(self.whole), 48))
        self.assertEqual(done["statistics"]["resumed_passes"], 16)
        self.assertGreater(done["seconds"], job["seconds"])
        self.assertEqual(self.extend(job["id"], {"passes": 48})["state"], "succeeded", "said again when it is done")
        self.assertEqual(len(self.daemon.job(job["id"])["attempts"]), 2)

    def test_what_cannot_be_extended(self):
        job = self.daemon.run_job(small_job(passes=16))
        refused = self.extend(job["id"], {"passes": 8}, 422)
        self.assertEqual(refused["errors"][0]["pointer"], "/stop")
        self.assertIn("16 passes", refused["detail"])
        self.extend(job["id"], {}, 422)
        self.extend(job["id"], {"passes": 0}, 422)
        self.extend(job["id"], {"target": {"metric": "rmse", "value": 1}}, 422)
        self.extend("J99999", {"passes": 8}, 404)
        reply = self.daemon.request("POST", f"/v1/jobs/{job['id']}/extend", json_body={"stop": {"passes": 64}, "x": 1})
        self.assertEqual(reply.status, 422)
        running = self.daemon.submit(small_job(passes=ENDLESS))
        self.extend(running["id"], {"passes": 8}, 409)
        self.daemon.request("DELETE", f"/v1/jobs/{running['id']}")
        self.daemon.wait_for_job(running["id"])

    def test_a_cancelled_job_is_extended(self):
        job = self.daemon.submit(small_job(passes=ENDLESS))
        self.daemon.wait_for_passes(job["id"])
        self.daemon.request("DELETE", f"/v1/jobs/{job['id']}")
        passes = self.daemon.wait_for_job(job["id"])["passes_done"] + 10
        self.extend(job["id"], {"passes": passes})
        done = self.daemon.wait_for_job(job["id"])
        self.assertEqual((done["state"], done["passes_done"]), ("succeeded", passes))

    # --- merge

    def test_any_number_of_parts_is_the_whole(self):
        runs = {number: self.parts(number) for number in (1, 2, 3, 7, 16)}
        for number, jobs in runs.items():
            with self.subTest(parts=number):
                jobs = [self.daemon.wait_for_job(job["id"]) for job in jobs]
                merged = self.merge(list(reversed(jobs)))
                self.assertEqual((merged["role"], merged["state"], merged["passes_done"]), ("merged", "succeeded", 48))
                self.assertEqual(hash_of(merged), hash_of(self.whole))
                self.assertEqual((merged["request"]["first_pass"], merged["request"]["stop"]["passes"]), (0, 48))
                self.assertEqual(merged["statistics"]["pass_ranges"], [[0, 48]])
                self.assertAlmostEqual(merged["seconds"], sum(job["seconds"] for job in jobs), places=6)
        pixels = self.daemon.request("GET", f"/v1/jobs/{merged['id']}/pixels").body
        self.assertEqual(pixels, self.daemon.request("GET", f"/v1/jobs/{self.whole['id']}/pixels").body)
        # It stands alone, also after a restart, and can be gone on with.
        for job in jobs:
            self.assertEqual(self.daemon.request("DELETE", f"/v1/jobs/{job['id']}?purge=true").status, 200)
        self.daemon.kill()
        self.daemon.start()
        self.assertEqual(self.daemon.job(merged["id"]), merged)
        self.extend(merged["id"], {"passes": 64})
        done = self.daemon.wait_for_job(merged["id"])
        self.assertEqual(done["statistics"]["resumed_passes"], 48)
        self.assertEqual(hash_of(done), hash_of(self.daemon.run_job(small_job(passes=64))))

    def test_unlike_things_are_refused(self):
        first, second = (self.daemon.wait_for_job(job["id"]) for job in self.parts(2, 4))
        other_seed = self.daemon.run_job(small_job(passes=2, first_pass=2, seed=2))
        other_layers = self.daemon.run_job(small_job(passes=2, first_pass=2, layers=["albedo"]))
        overlapping = self.daemon.run_job(small_job(passes=3, first_pass=1))
        running = self.daemon.submit(small_job(passes=ENDLESS))
        for jobs, pointer, word in (([first, second, other_seed], "/jobs/2", "seed"),
                                    ([first, other_layers], "/jobs/1", "layers"),
                                    ([first, overlapping], "/jobs/1", "pass"), ([first, first], "/jobs/1", "twice"),
                                    ([first, running], "/jobs/1", "not over"),
                                    ([first, {"id": "J99999"}], "/jobs/1", "no job"), ([], "/jobs", "1 to 1000")):
            with self.subTest(word=word):
                problem = self.merge(jobs, 422)
                self.assertEqual([error["pointer"] for error in problem["errors"]], [pointer])
                self.assertIn(word, problem["detail"])
        self.daemon.request("DELETE", f"/v1/jobs/{running['id']}")
        self.daemon.wait_for_job(running["id"])
        self.assertEqual(list((self.daemon.data_dir / "spool").iterdir()), [], "nothing is left lying")
        # Parts with a gap between them are merged, but have no one pass to go on from.
        apart = self.daemon.run_job(small_job(passes=2, first_pass=8))
        gap = self.merge([first, apart])
        self.assertEqual(gap["statistics"]["pass_ranges"], [[0, 2], [8, 10]])
        self.extend(gap["id"], {"passes": 100}, 409)

    def test_the_same_key_is_the_same_job(self):
        jobs = [self.daemon.wait_for_job(job["id"]) for job in self.parts(2, 4)]
        key = {"headers": {"Idempotency-Key": "merged"}}
        merged = self.merge(jobs, **key)
        self.assertEqual(self.merge(jobs, **key)["id"], merged["id"])
        self.merge(jobs[:1], 422, **key)
        listed = self.daemon.request("GET", "/v1/jobs?role=merged&limit=1000").json["items"]
        self.assertEqual(len(list((self.daemon.data_dir / "films").glob("merged-*"))),
                         len([job for job in listed if not job["attempts"]]), "those extended since have others")
        served = self.daemon.request("GET", f"/v1/jobs/{merged['id']}/film")
        self.assertEqual((served.status, served.body[:8]), (200, b"PHOTFILM"))


if __name__ == "__main__":
    unittest.main()
