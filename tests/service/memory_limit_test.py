"""The memory limit of a worker: a job that just fits runs, one that does not (accepted by a daemon that had more, met by
one that has less) fails with out_of_memory at once; the next one runs, and the worker has not even been replaced.
"""

import re
import tempfile
import unittest

from photond_daemon import UNDER_SANITIZER, Daemon, small_job

ALL_LAYERS = ["caustic", "albedo", "normal", "position", "depth", "standard_error"]
LIMIT = 48 << 20
LARGE = small_job(size=384, layers=ALL_LAYERS)  # a film of 74 MB
RESIDENT = "freed memory stays resident under a sanitizer: hundreds of megabytes"


class MemoryLimitTest(unittest.TestCase):
    @unittest.skipIf(UNDER_SANITIZER, RESIDENT)
    def test_the_limit_can_be_used_up(self):
        """It is about what jobs hold; what the process is made of comes on top."""
        # Long enough for the daemon to look at the worker's memory a few times.
        job = {**small_job("interior", size=512, layers=ALL_LAYERS), "stop": {"seconds": 2}}
        with Daemon("--threads", 1) as daemon:
            needed = daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).json["memory_bytes"]
        for share, status in ((1.01, 202), (0.99, 422)):
            with Daemon("--memory-limit", int(share * needed), "--threads", 1) as daemon:
                daemon.wait_ready()
                daemon.request("GET", "/v1/scenes/interior")  # judged: the estimate knows it
                reply = daemon.request("POST", "/v1/jobs", json_body=job)
                self.assertEqual(reply.status, status, reply)
                if status == 202:
                    done = daemon.wait_for_job(reply.json["id"])
                    self.assertEqual((done["state"], len(done["attempts"])), ("succeeded", 1), done)
                    self.assertEqual(daemon.request("GET", f"/v1/jobs/{done['id']}/preview.png").status, 200)
                restarts = [worker["restarts"] for worker in daemon.request("GET", "/v1/status").json["workers"]]
                self.assertEqual(restarts, [0, 0], daemon.log())

    @unittest.skipIf(UNDER_SANITIZER, RESIDENT)
    def test_what_no_longer_fits_fails_and_the_rest_goes_on(self):
        with tempfile.TemporaryDirectory(prefix="photond-test-") as around:
            folder = around + "/data"  # the log is written beside it
            with Daemon("--threads", 1, data_dir=folder) as daemon:
                daemon.wait_ready()
                done = daemon.wait_for_job(daemon.submit(LARGE)["id"])
                self.assertEqual(done["state"], "succeeded", done)
                endless = daemon.submit({**small_job(size=16), "stop": {"seconds": 3600}})["id"]
                daemon.wait_for_job(endless, states=("running",))
                large = daemon.submit(LARGE)["id"]
                scene = daemon.submit(small_job("interior", size=16))["id"]  # 32 MB: it fits
                small = daemon.submit(small_job())["id"]
                self.assertEqual(daemon.stop(), 0)
            with Daemon("--memory-limit", LIMIT, data_dir=folder) as daemon:
                daemon.wait_ready()
                workers = daemon.workers()
                daemon.request("DELETE", f"/v1/jobs/{endless}")
                failed = daemon.wait_for_job(large)
                self.assertEqual((failed["state"], failed["failure"]["code"], failed["failure"]["status"]),
                                 ("failed", "out_of_memory", 422), failed)
                needed, limit = [int(figure) for figure in re.findall(r"\d{7,}", failed["failure"]["detail"])][:2]
                self.assertGreater(needed, LIMIT)
                self.assertEqual(limit, LIMIT)
                self.assertEqual([attempt["outcome"] for attempt in failed["attempts"]], ["failed"])
                self.assertEqual(failed["passes_done"], 0)
                self.assertEqual(daemon.request("GET", f"/v1/jobs/{large}/image.exr").status, 404)
                self.assertEqual(daemon.wait_for_job(scene)["state"], "succeeded")
                next_one = daemon.wait_for_job(small)
                self.assertEqual(next_one["state"], "succeeded", next_one)
                self.assertEqual(daemon.workers(), workers)
                # Submitted now it is refused before it is a job, and a retry of the old one fails the same way.
                reply = daemon.request("POST", "/v1/jobs", json_body=LARGE)
                self.assertEqual((reply.status, reply.json["code"]), (422, "out_of_memory"), reply)
                self.assertEqual(daemon.request("POST", f"/v1/jobs/{large}/retry").status, 202)
                self.assertEqual(daemon.wait_for_job(large)["failure"]["code"], "out_of_memory")
                # The helper cannot take up the film that was finished then, and says so.
                reply = daemon.request("GET", f"/v1/jobs/{done['id']}/image.exr")
                self.assertEqual((reply.status, reply.json["code"]), (422, "out_of_memory"), reply)
                self.assertEqual(daemon.request("GET", f"/v1/jobs/{small}/image.exr").status, 200)
                restarts = [worker["restarts"] for worker in daemon.request("GET", "/v1/status").json["workers"]]
                self.assertEqual(restarts, [0, 0])

    @unittest.skipIf(UNDER_SANITIZER, RESIDENT)
    def test_a_scene_that_does_not_fit_by_itself(self):
        with tempfile.TemporaryDirectory(prefix="photond-test-") as around:
            folder = around + "/data"  # the log is written beside it
            with Daemon("--threads", 1, data_dir=folder) as daemon:
                daemon.wait_ready()
                endless = daemon.submit({**small_job(size=16), "stop": {"seconds": 3600}})["id"]
                daemon.wait_for_job(endless, states=("running",))
                scene = daemon.submit(small_job("interior", size=16))["id"]
                small = daemon.submit(small_job())["id"]
                self.assertEqual(daemon.stop(), 0)
            with Daemon("--memory-limit", 16 << 20, data_dir=folder) as daemon:
                daemon.wait_ready()
                daemon.request("DELETE", f"/v1/jobs/{endless}")
                failed = daemon.wait_for_job(scene)
                self.assertEqual((failed["state"], failed["failure"]["code"], len(failed["attempts"])),
                                 ("failed", "out_of_memory", 1), failed)
                self.assertEqual(daemon.wait_for_job(small)["state"], "succeeded")


@unittest.skipIf(UNDER_SANITIZER, "a sanitizer maps terabytes")
class AddressSpaceTest(unittest.TestCase):
    def test_a_small_one_leaves_jobs_less_memory(self):
        job = small_job(size=704, layers=ALL_LAYERS)
        with Daemon("--threads", 2, address_space=1700 << 20) as daemon:  # 1408 MiB of it for a worker itself
            daemon.wait_ready()
            workers = daemon.request("GET", "/v1/status").json["workers"]
            self.assertEqual([worker["memory_limit_bytes"] for worker in workers], 2 * [292 << 20], workers)
            needed = daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).json["memory_bytes"]
            self.assertGreater(needed, 230 << 20)
            done = daemon.run_job(job)
            self.assertEqual((done["state"], len(done["attempts"])), ("succeeded", 1), done)
            for picture in ("image.exr", "preview.png"):
                self.assertEqual(daemon.request("GET", f"/v1/jobs/{done['id']}/{picture}").status, 200)
            reply = daemon.request("POST", "/v1/jobs", json_body={**job, "image": {"width": 900, "height": 900}})
            self.assertEqual((reply.status, reply.json["code"]), (422, "out_of_memory"), reply)

    def test_one_that_is_too_small_is_said_to_be(self):
        for mib, arguments, words in (
                (100, (), r"needs 1703936: 1441792 for a worker of 2 threads and 262144 for what its jobs hold"),
                (600, (), r"granted 614400 KiB of address space \(ulimit -v\); photond needs 1703936"),
                (1663, (), r"needs 1703936"),
                (1700, ("--memory-limit", 1 << 30), r"needs 2490368: .* and 1048576 for what its jobs hold")):
            with self.subTest(mib=mib), self.assertRaisesRegex(RuntimeError, words):
                Daemon("--threads", 2, *arguments, address_space=mib << 20).close()


if __name__ == "__main__":
    unittest.main()
