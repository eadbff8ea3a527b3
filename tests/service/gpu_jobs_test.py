"""Jobs on a GPU through the whole service: statistics, memory, side by side with the CPU, kills, merging, other devices
after a restart. Vulkan's validation layers run along."""

import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

import OpenImageIO as oiio

from gpu_daemon import able_gpus, gpu_daemon, needs_gpu, validation_messages
from photond_daemon import BIN, Daemon, small_job

GPU = able_gpus()[0] if able_gpus() else None
ENDLESS = 1_000_000


def gpu_job(device=None, size=32, passes=2, **more):
    job = small_job(size=size, passes=passes, **more)
    job["method"]["device"] = device or GPU["id"]
    return job


def hash_of(job):
    return job["statistics"]["pixel_hash"]


class GpuCase(unittest.TestCase):
    environment = {"PHOTOND_GPU_VALIDATION": "1"}
    options = ()

    @classmethod
    def setUpClass(cls):
        cls.daemon = gpu_daemon(*cls.options, environment=cls.environment)
        cls.addClassCleanup(cls.daemon.close)

    def tearDown(self):
        self.assertEqual(validation_messages(self.daemon), [])


@needs_gpu
class JobTest(GpuCase):
    def test_a_job_and_what_it_says_of_itself(self):
        job = self.daemon.run_job(gpu_job())
        statistics = job["statistics"]
        self.assertEqual(statistics["device"], {"id": GPU["id"], "name": GPU["name"], "driver": GPU["driver"],
                                                "software": GPU["software"]})
        on_gpu = {stage["name"]: stage["gpu_seconds"] for stage in statistics["stages"] if stage["gpu_seconds"]}
        self.assertTrue(on_gpu, statistics["stages"])
        self.assertGreater(statistics["counts"]["rays"]["camera"], 0)
        for name in ("load", "acceleration_build", "scene_upload"):
            self.assertIn(name, [stage["name"] for stage in statistics["stages"]])
        memory = statistics["memory"]
        self.assertTrue(memory["device_structures"])
        self.assertGreaterEqual(memory["peak_device_bytes"], sum(memory["device_structures"].values()))
        # The EXR says the same.
        with tempfile.NamedTemporaryFile(suffix=".exr") as file:
            file.write(self.daemon.request("GET", job["links"]["image"]).body)
            file.flush()
            image = oiio.ImageInput.open(file.name)
            attributes = {attribute.name: attribute.value for attribute in image.spec().extra_attribs}
            image.close()
        self.assertEqual(attributes["photond:device.driver"], GPU["driver"])
        stage, seconds = next(iter(on_gpu.items()))
        self.assertAlmostEqual(attributes[f"photond:stages.{stage}.gpu_seconds"], seconds, delta=1e-6 + 1e-5 * seconds)
        self.assertEqual(attributes["photond:memory.peak_device_bytes"], memory["peak_device_bytes"])
        # The same job gives the same bits, by whatever name the device goes, and from a warm scene.
        again = self.daemon.run_job(gpu_job("gpu"))
        self.assertEqual(hash_of(again), hash_of(job))
        self.assertEqual(again["statistics"]["memory"]["device_structures"], memory["device_structures"])
        self.assertEqual(again["attempts"][0]["device"], GPU["id"])

    def test_every_method_of_the_gpu_renders(self):
        """With its defaults, but few photons and lights; those that ask the host for rays (pilots, projection maps) among
        them. What is dear is that the driver compiles what the defaults choose: three times as much where there is glass.
        Two methods are given glass, the one for its map of caustic photons, the other for those beside its lights.
        """
        for method in self.daemon.request("GET", "/v1/methods").json["items"]:
            if "gpu" not in method["devices"]:
                continue
            of_glass = method["name"] in ("photon_mapping", "svo_many_lights")
            job = gpu_job(scene="cornell-box-glass" if of_glass else "cornell-box", size=16, passes=1)
            few = {"photons": 2000, "vpls": 64}
            job["method"].update(name=method["name"], parameters={
                name: number for name, number in few.items() if name in method["parameters"]["properties"]})
            with self.subTest(method["name"]):
                self.assertEqual(self.daemon.run_job(job)["state"], "succeeded")

    def test_photons_traced_on_the_cores(self):
        """The scene's ray structure then lies in the host's memory too, beside the photons of two passes."""
        job = gpu_job(scene="interior", size=32, passes=3, method="image_space_photon_mapping")
        estimates, memory = {}, {}
        for trace in ("gpu", "cpu"):
            job["method"]["parameters"] = {"trace": trace, "photons": 20_000}
            estimates[trace] = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).json["memory_bytes"]
            memory[trace] = self.daemon.run_job(job)["statistics"]["memory"]
            self.assertLess(memory[trace]["accounted_bytes"], 1.5 * estimates[trace], trace)
            self.assertLess(estimates[trace], 1.5 * memory[trace]["accounted_bytes"], trace)
        self.assertGreater(estimates["cpu"], estimates["gpu"])
        self.assertNotIn("acceleration", memory["gpu"]["structures"])
        self.assertIn("acceleration", memory["cpu"]["structures"])
        self.assertGreater(memory["cpu"]["structures"]["photons_ahead"], 0)

    def test_memory_is_estimated_and_refused(self):
        for scene, size in (("cornell-box", 256), ("furnace", 32), ("interior", 64)):
            job = gpu_job(scene=scene, size=size, passes=1)
            estimate = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).json
            used = self.daemon.run_job(job)["statistics"]["memory"]
            # reliability.md, "Estimates".
            for estimated, counted in (("device_memory_bytes", "peak_device_bytes"),
                                       ("memory_bytes", "accounted_bytes")):
                self.assertLess(used[counted], 1.5 * estimate[estimated], (scene, used, estimate))
                self.assertLess(estimate[estimated], 1.5 * used[counted], (scene, used, estimate))
        if not GPU["software"]:
            return  # a card has more than the host may hold
        huge = gpu_job(method="photon_mapping", passes=1)
        huge["method"]["parameters"] = {"photons": 1_000_000_000}  # of which the host holds none
        refused = self.daemon.request("POST", "/v1/jobs", json_body=huge)
        self.assertEqual((refused.status, refused.json["code"]), (422, "out_of_memory"), refused)
        self.assertRegex(refused.text, rf"a job may hold \d+ bytes of {GPU['id']} .* needs about \d+")
        on_cpu = small_job()
        self.assertIsNone(self.daemon.request("POST", "/v1/jobs?dry_run=true",
                                              json_body=on_cpu).json["device_memory_bytes"])

    def test_two_scenes_are_told_apart_in_memory(self):
        first = self.daemon.run_job(gpu_job(scene="cornell-box"))["statistics"]["memory"]
        self.daemon.run_job(gpu_job(scene="interior", passes=1))
        again = self.daemon.run_job(gpu_job(scene="cornell-box"))["statistics"]["memory"]
        self.assertEqual(first["device_structures"], again["device_structures"])
        self.assertEqual(first["peak_device_bytes"], again["peak_device_bytes"])

    def test_side_by_side_with_the_cpu(self):
        running = {}
        for device in ("cpu", GPU["id"]):
            running[device] = self.daemon.submit(gpu_job(device, passes=ENDLESS))["id"]
        jobs = running.values()
        for job in jobs:
            self.daemon.wait_for_passes(job)
        for job in jobs:
            self.assertEqual(self.daemon.request("DELETE", f"/v1/jobs/{job}").status, 202)
        for device, job_id in running.items():
            job = self.daemon.wait_for_job(job_id)
            self.assertEqual(job["state"], "cancelled")
            self.assertGreater(job["statistics"]["passes"], 0)
            self.assertEqual(job["statistics"]["device"]["id"], device)
            self.assertIs(job["statistics"]["host_shared"], True)
            self.assertIs(job["statistics"]["device_shared"], GPU["software"], "a software GPU has the host's cores")
        alone = self.daemon.run_job(gpu_job())["statistics"]
        self.assertEqual((alone["host_shared"], alone["device_shared"]), (False, False))

    def test_each_names_the_other_that_took_its_cores(self):
        if not GPU["software"]:
            self.skipTest("a card has cores of its own")
        both = [gpu_job(device, size=128, passes=None) for device in ("cpu", GPU["id"])]
        ids = [self.daemon.submit({**job, "stop": {"seconds": 1.5}})["id"] for job in both]
        for mine, other in (ids, reversed(ids)):
            statistics = self.daemon.wait_for_job(mine)["statistics"]
            if statistics["cores"]["run_delay_seconds"] is None:
                self.skipTest("this kernel does not say how long threads wait")
            print(mine, statistics["shared"])
            self.assertIn(f"job {other}", [taker["who"] for taker in statistics["shared"]["to"]])

    def test_passes_of_two_kinds_of_device_are_no_film(self):
        parts = [self.daemon.run_job(gpu_job(passes=1, first_pass=first)) for first in (0, 1)]
        whole = self.daemon.run_job(gpu_job(passes=2))
        merged = self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": [job["id"] for job in parts]})
        self.assertIn(merged.status, (201, 202), merged)
        self.assertEqual(hash_of(merged.json), hash_of(whole))
        on_cpu = self.daemon.run_job(gpu_job("cpu", passes=1, first_pass=1))
        refused = self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": [parts[0]["id"], on_cpu["id"]]})
        self.assertEqual(refused.status, 422, refused)
        self.assertIn("gpu", refused.text)

    def test_killed_it_goes_on_to_the_same_bits(self):
        expected = hash_of(self.daemon.run_job(gpu_job(size=64, passes=64)))
        job_id = self.daemon.submit(gpu_job(size=64, passes=64))["id"]
        self.daemon.wait_for_passes(job_id, 2)
        os.kill(self.daemon.workers()[GPU["id"]], signal.SIGKILL)
        job = self.daemon.wait_for_job(job_id)
        self.assertEqual((job["state"], [a["outcome"] for a in job["attempts"]]), ("succeeded", ["lost", "succeeded"]))
        self.assertEqual(hash_of(job), expected)

    def photonctl(self, *arguments):
        command = [str(BIN / "photonctl"), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=True,
                              env={**os.environ, "PHOTOND_URL": f"http://127.0.0.1:{self.daemon.port}"}).stdout

    def gpu_jobs(self):
        jobs = self.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]
        return sum(job["request"]["method"]["device"] == "gpu" for job in jobs)

    def test_photonctl(self):
        self.assertRegex(self.photonctl("devices"), rf"{GPU['id']} +(ready|busy) +{re.escape(GPU['name'][:20])}")
        small = ["--width", 16, "--height", 16, "--passes", 1]
        estimate = self.photonctl("render", "cornell-box", *small, "--device", "gpu", "--dry-run")
        self.assertRegex(estimate, r"memory .*, and [\d.]+ [kM]B of the GPU's")
        rendered = self.photonctl("render", "cornell-box", *small, "--device", "gpu")
        self.assertIn(GPU["driver"], rendered)
        self.assertRegex(rendered, r"device: scene positions +\d")
        compared = self.photonctl("compare", "cornell-box", *small, "--entry", "there=path_tracing", "--entry",
                                  "here=path_tracing@cpu", "--device", "gpu", "--reference", "path_tracing:4", "--json")
        devices = {row["label"]: row["method"]["device"] for row in json.loads(compared.splitlines()[-1])["request"]["entries"]}
        self.assertEqual(devices, {"there": "gpu", "here": "cpu"})
        before = self.gpu_jobs()
        table = json.loads(self.photonctl("hard-cases", "corner-90", "--short", "--seeds", 2, "--effort", 0.01,
                                          "--method", "path_tracing", "--device", "gpu", "--keep-jobs", "--json"))
        self.assertEqual(len(table["cases"][0]["cells"]), 1, table)
        self.assertGreater(self.gpu_jobs(), before)

    def test_compiled_pipelines_are_kept(self):
        self.daemon.run_job(gpu_job())
        caches = os.listdir(self.daemon.data_dir / "pipeline-cache")
        self.assertTrue(all(name == GPU["id"].replace(":", "-") + ".bin" for name in caches), caches)


@needs_gpu
class OtherDevicesTest(unittest.TestCase):
    def test_a_job_waits_for_a_daemon_that_has_its_device(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder) / "data"
            with gpu_daemon(devices=GPU["id"], data_dir=folder) as daemon:
                refused = daemon.request("POST", "/v1/jobs", json_body=small_job())
                self.assertEqual((refused.status, refused.json["code"]), (422, "device_unavailable"))
                job_id = daemon.submit(gpu_job(size=64, passes=400))["id"]
                daemon.wait_for_passes(job_id)
            with Daemon(data_dir=folder) as daemon:
                daemon.wait_ready()
                self.assertEqual(daemon.job(job_id)["state"], "queued")
                self.assertIn(f"1 jobs wait for device {GPU['id']}", daemon.log())
                self.assertEqual(daemon.run_job(small_job())["state"], "succeeded")
                self.assertEqual(daemon.request("DELETE", f"/v1/jobs/{job_id}").status, 202)
                again = daemon.request("POST", f"/v1/jobs/{job_id}/retry")
                self.assertEqual(again.json["code"], "device_unavailable", again)
            with gpu_daemon(data_dir=folder) as daemon:
                self.assertEqual(daemon.request("POST", f"/v1/jobs/{job_id}/retry").status, 202)
                daemon.wait_for_job(job_id, states=("running", "succeeded"))


if __name__ == "__main__":
    unittest.main()
