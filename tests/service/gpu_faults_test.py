"""reliability.md, "GPU faults": a device that is lost, memory that is not there, pipelines that cannot be made. Never a
wrong image: the job's pixels are those of an undisturbed run, or it fails with a true reason."""

import pathlib
import tempfile
import unittest

from gpu_daemon import able_gpus, counted_calls, fault_environment, gpu_daemon, needs_gpu
from photond_daemon import small_job

GPU = able_gpus()[0] if able_gpus() else None
JOB = small_job(size=32, passes=4)
JOB["method"]["device"] = "gpu"
# Its passes build on what those before have counted, on the device.
JOB_WITH_STATE = small_job(size=32, passes=4)
JOB_WITH_STATE["method"] = {"name": "stochastic_progressive_photon_mapping", "device": "gpu",
                            "parameters": {"photons": 2000, "boundary": "none"}}
# How long its paths from the eye are under way the device says, submit by submit.
JOB_IN_WAVES = small_job(size=32, passes=3)
JOB_IN_WAVES["method"] = {"name": "vertex_connection_and_merging", "device": "gpu",
                          "parameters": {"adapt": False, "indirect_bounces": 4}}
# Draws its photons, and gathers its shadows.
JOB_DRAWN = small_job(size=32, passes=3)
JOB_DRAWN["method"] = {"name": "image_space_photon_mapping", "device": "gpu",
                       "parameters": {"photons": 2000, "scatter": "raster", "soft_shadow": "gather", "subsampling": 2,
                                      "bounce_map_texels": 500}}
# Marches through voxels, whose number grows from pass to pass.
JOB_OF_PROXIES = small_job(size=32, passes=3)
JOB_OF_PROXIES["method"] = {"name": "visibility_filtering", "device": "gpu",
                            "parameters": {"proxies": 2000, "voxels": 16, "shrink": True}}
# Sorts lights into cells, and sends their light on step by step.
JOB_IN_VOLUMES = small_job(size=32, passes=3)
JOB_IN_VOLUMES["method"] = {"name": "light_propagation_volumes", "device": "gpu",
                            "parameters": {"vpls": 1000, "cascades": 2}}
# Makes a tree, lights it and filters it up.
JOB_OF_CONES = small_job(size=32, passes=3)
JOB_OF_CONES["method"] = {"name": "voxel_cone_tracing", "device": "gpu",
                          "parameters": {"vpls": 1000, "voxel_resolution": 32}}
# Fills a cache before its passes, round by round.
JOB_WITH_CACHE = small_job(size=32, passes=3)
JOB_WITH_CACHE["method"] = {"name": "radiance_cache", "device": "gpu", "parameters": {"cells": 4096, "training": 1}}


def hash_of(job):
    return job["statistics"]["pixel_hash"]


def some_of(count):
    """Of 1 .. count the first, one between and the last."""
    return sorted({1, max(count // 2, 1), count})


@needs_gpu
class FaultTest(unittest.TestCase):
    expected = {}  # hashes, by method

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def daemon(self, call, at=None, **fault):
        # Films are saved after each pass, so that attempts do go on from one.
        return gpu_daemon("--save-seconds", "0.000001", devices="gpu",
                          environment=fault_environment(self.folder, call, at, **fault))

    def check_hash(self, job):
        """Of a job, that of its method's undisturbed run: the first that is seen."""
        self.assertEqual(hash_of(job), self.expected.setdefault(job["request"]["method"]["name"], hash_of(job)))

    def calls_of_a_job(self, call, job=JOB):
        """How many there are until the job's end; its undisturbed hash is kept."""
        with self.daemon(call) as daemon:
            self.check_hash(daemon.run_job(job))
        count = counted_calls(self.folder)
        self.assertGreater(count, 0, call)
        return count

    def lost(self, call, body=JOB, choose=some_of):
        for at in choose(self.calls_of_a_job(call, body)):
            with self.subTest(call=call, at=at), self.daemon(call, at) as daemon:
                pid = daemon.workers()[GPU["id"]]
                job = daemon.run_job(body)
                self.assertTrue((self.folder / "once").exists(), "the fault never came")
                if len(job["attempts"]) == 1:  # lost while it tidied up: the next job finds out
                    self.check_hash(job)
                    job = daemon.run_job(body)
                self.assertEqual([a["outcome"] for a in job["attempts"]], ["device_lost", "succeeded"])
                self.assertIn("the GPU stopped answering", job["attempts"][0]["reason"])
                self.check_hash(job)
                self.assertNotEqual(daemon.workers()[GPU["id"]], pid, "a process with a lost device went on")

    def test_lost_while_submitting(self):
        self.lost("vkQueueSubmit2")

    def test_lost_while_waiting(self):
        self.lost("vkWaitSemaphores")

    def test_lost_between_passes_that_build_on_one_another(self):
        """Midway, and near the end."""
        self.lost("vkWaitSemaphores", JOB_WITH_STATE, lambda count: (count // 2, count - 4))

    def test_lost_while_waves_are_under_way(self):
        self.lost("vkWaitSemaphores", JOB_IN_WAVES, lambda count: (count // 2,))

    def test_lost_while_photons_are_drawn(self):
        self.lost("vkQueueSubmit2", JOB_DRAWN, lambda count: (count // 2,))

    def test_lost_while_rays_march(self):
        self.lost("vkQueueSubmit2", JOB_OF_PROXIES, lambda count: (count // 2,))

    def test_lost_while_light_propagates(self):
        self.lost("vkQueueSubmit2", JOB_IN_VOLUMES, lambda count: (count // 2,))

    def test_lost_while_cones_look(self):
        self.lost("vkQueueSubmit2", JOB_OF_CONES, lambda count: (count // 2,))

    def test_lost_while_a_cache_is_filled(self):
        self.lost("vkQueueSubmit2", JOB_WITH_CACHE, lambda count: {1, (count + 1) // 2})

    def test_lost_twice_the_job_fails(self):
        with self.daemon("vkQueueSubmit2", 2, once=False) as daemon:
            job = daemon.wait_for_job(daemon.submit(JOB)["id"])
            self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "device_lost"))
            self.assertEqual([a["outcome"] for a in job["attempts"]], ["device_lost"] * 2)
            self.assertIn("the GPU stopped answering while submitting", job["failure"]["detail"])
            daemon.wait_ready()
            metrics = daemon.request("GET", "/metrics").text
            self.assertRegex(metrics, r'photond_worker_restarts_total\{reason="device_lost"\} 2')

    def survived(self, call, result, code, reason):
        """One fault of a process: the job of that moment fails, or never notices; the worker and later jobs live on."""
        for at in some_of(self.calls_of_a_job(call)):
            with self.subTest(call=call, at=at), self.daemon(call, at, result=result) as daemon:
                pid = daemon.workers()[GPU["id"]]
                job = daemon.wait_for_job(daemon.submit(JOB)["id"])
                self.assertTrue((self.folder / "once").exists(), "the fault never came")
                self.assertEqual((job["state"], job["failure"]["code"]), ("failed", code), job)
                self.assertRegex(job["failure"]["detail"], reason)
                self.assertEqual(len(job["attempts"]), 1)
                self.check_hash(daemon.run_job(JOB))
                self.assertEqual(daemon.workers()[GPU["id"]], pid, "the worker did not live on")

    def test_no_memory_on_the_device(self):
        self.survived("vkAllocateMemory", "memory", "out_of_memory", r"allocating \d+ bytes for .* beside \d+ bytes held")

    def test_a_pipeline_that_cannot_be_made(self):
        self.survived("vkCreateComputePipelines", "failed", "internal", r"\.comp.*VK_ERROR_INITIALIZATION_FAILED")


if __name__ == "__main__":
    unittest.main()
