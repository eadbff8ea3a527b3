"""POST /v1/jobs?dry_run=true: what a job would take, against what jobs then do take; and what is refused by it."""

import json
import re
import time
import unittest

import malformed_gltf
from photond_daemon import UNDER_SANITIZER, Daemon, DaemonTestCase, small_job

ALL_LAYERS = ["caustic", "albedo", "normal", "position", "depth", "standard_error"]
# reliability.md, "Estimates": within 1.5 of the measured. What the structures hold is counted by byte and varies by nothing
# but the ray structure, so we hold ourselves to less.
WITHIN = 1.1
# The resident set is the kernel's view of the same: freed memory used again and lazily mapped pages blur it by a few MB.
WITHIN_RESIDENT = 1.5
RESIDENT_FROM_BYTES = 32 << 20
SCENES = ("cornell-box", "cornell-box-glass", "cornell-box-glossy", "furnace", "caustic-ring", "keyhole", "interior")


class EstimateTest(DaemonTestCase):
    def estimate(self, body, **options):
        reply = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=body, **options)
        self.assertEqual(reply.status, 200, reply)
        self.assertEqual(set(reply.json), {"memory_bytes", "device_memory_bytes", "seconds", "pass_seconds", "left_out", "warnings"})
        return reply.json

    def hold_to_measured(self, body):
        """The estimate's share of what is counted, after the job was rendered."""
        estimated = self.estimate(body)["memory_bytes"]
        job = self.daemon.wait_for_job(self.daemon.submit(body)["id"])
        self.assertEqual(job["state"], "succeeded", job)
        memory = job["statistics"]["memory"]
        what = f"{body['scene']} {body['image']}: estimated {estimated}, {json.dumps(memory)}"
        self.assertLess(estimated, WITHIN * memory["accounted_bytes"], what)
        self.assertGreater(estimated * WITHIN, memory["accounted_bytes"], what)
        resident = memory["peak_resident_bytes"] - memory["baseline_resident_bytes"]
        if estimated > RESIDENT_FROM_BYTES and not UNDER_SANITIZER:  # which keeps what was freed
            self.assertLess(estimated, WITHIN_RESIDENT * resident, what)
            self.assertGreater(estimated * WITHIN_RESIDENT, resident, what)
        return estimated / memory["accounted_bytes"]

    def test_memory_of_builtin_scenes(self):
        shares = {}
        for scene in SCENES:
            for size, layers in ((32, []), (128, ALL_LAYERS), (512, [])):
                share = self.hold_to_measured(small_job(scene, size, layers=layers))
                shares[f"{scene} {size} {len(layers)}"] = share
        print(f"\nestimated over counted: {min(shares.values()):.3f} to {max(shares.values()):.3f}")

    def test_memory_of_an_uploaded_scene_and_an_environment(self):
        reply = self.daemon.request("POST", "/v1/scenes", body=malformed_gltf.valid(),
                                    headers={"Content-Type": "model/gltf-binary"})
        scene = reply.json
        self.assertGreater(scene["memory_bytes"], 0)
        width, height = 512, 256
        hdr = (f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
               + bytes([128, 128, 128, 129]) * (width * height))
        image = self.daemon.request("POST", "/v1/images", body=hdr, headers={"Content-Type": "image/vnd.radiance"}).json
        without = small_job(scene["id"], 64)
        lit = {**without, "environment": {"image": f"image:{image['id']}"}}
        self.hold_to_measured(without)
        self.hold_to_measured(lit)
        # Radiance and its cumulative table.
        self.assertAlmostEqual(self.estimate(lit)["memory_bytes"] - self.estimate(without)["memory_bytes"],
                               width * height * 16, delta=0.02 * width * height * 16)

    def test_nothing_is_queued(self):
        before = self.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]
        headers = {"Idempotency-Key": "only-asked"}
        for _ in range(3):
            self.estimate(small_job(seed=77), headers=headers)
        self.assertEqual([job["id"] for job in self.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]],
                         [job["id"] for job in before])
        # The key is still free, for whatever body.
        self.assertEqual(self.daemon.submit(small_job(seed=78), "only-asked")["request"]["seed"], 78)
        reply = self.daemon.request("POST", "/v1/jobs?dry_run=false", json_body=small_job())
        self.assertEqual(reply.status, 202)

    def test_seconds_follow_from_what_was_rendered(self):
        with Daemon() as daemon:
            daemon.wait_ready()

            def seconds(**changes):
                reply = daemon.request("POST", "/v1/jobs?dry_run=true", json_body={**small_job(), **changes})
                return reply.json["seconds"]
            self.assertIsNone(seconds())
            self.assertEqual(seconds(stop={"seconds": 12.5}), 12.5)
            job = daemon.wait_for_job(daemon.submit(small_job("keyhole", 32, 4))["id"])
            elsewhere = job["seconds"] / (32 * 32 * 4)
            self.assertAlmostEqual(seconds(), elsewhere * 32 * 32, delta=1e-6 * elsewhere * 32 * 32)
            job = daemon.wait_for_job(daemon.submit(small_job("cornell-box", 64, 2))["id"])
            here = job["seconds"] / (64 * 64 * 2)
            self.assertAlmostEqual(seconds(stop={"passes": 10}), here * 32 * 32 * 10, delta=1e-5 * here * 32 * 32 * 10)
            self.assertEqual(seconds(stop={"passes": 10**9, "seconds": 3}), 3)

            def told(seconds):
                stop = {"stop": {"seconds": seconds}}
                return daemon.request("POST", "/v1/jobs?dry_run=true", json_body={**small_job(size=1024), **stop}).json
            self.assertEqual(told(600)["warnings"], [])
            a_pass = told(600)["pass_seconds"]
            self.assertEqual(told(a_pass / 2)["seconds"], a_pass)
            [warning] = told(a_pass / 2)["warnings"]
            self.assertRegex(warning, "^a pass takes about .*, and the first one is always finished: the .* asked for "
                                      "will be overshot$")

    def test_the_same_faults_as_a_job_of_its_own(self):
        for body in (small_job("cornel-box"), small_job(colour="red"), small_job(size=0), small_job(method="magic"),
                     {**small_job(), "method": {"name": "path_tracing", "device": "gpu"}},
                     small_job(camera={"name": "left"}), small_job(environment={"image": "image:none"})):
            dry = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=body)
            wet = self.daemon.request("POST", "/v1/jobs", json_body=body)
            self.assertEqual(dry.status, 422, dry)
            self.assertEqual((dry.json["code"], dry.json["errors"]), (wet.json["code"], wet.json["errors"]))
        reply = self.daemon.request("POST", "/v1/jobs?dry_run=perhaps", json_body=small_job())
        self.assertEqual((reply.status, reply.json["errors"][0]["pointer"]), (422, "/dry_run"), reply)


class TooLargeTest(unittest.TestCase):
    LIMIT = 256 << 20

    def test_what_does_not_fit_is_refused_with_the_estimate(self):
        with Daemon("--memory-limit", self.LIMIT) as daemon:
            daemon.wait_ready()
            fits = small_job(size=512)
            self.assertEqual(daemon.request("POST", "/v1/jobs?dry_run=true", json_body=fits).status, 200)
            workers = daemon.workers()
            slowest = 0
            for width, height, layers, code in ((2048, 2048, [], "out_of_memory"), (1024, 1024, ALL_LAYERS, "out_of_memory"),
                                                (65536, 65536, ALL_LAYERS, "out_of_range")):
                body = {**small_job(layers=layers), "image": {"width": width, "height": height}}
                for path in ("/v1/jobs?dry_run=true", "/v1/jobs"):
                    begun = time.monotonic()
                    reply = daemon.request("POST", path, json_body=body)
                    slowest = max(slowest, time.monotonic() - begun)
                    self.assertEqual((reply.status, reply.json["code"]), (422, code), reply)
                    [error] = reply.json["errors"]
                    self.assertEqual(error["pointer"], "/image")
                    needed = int(re.search(r"needs about (\d+) bytes", error["detail"])[1])
                    self.assertGreater(needed, self.LIMIT)
                    # The film alone: three layers and three sums of squares, 16 bytes each, three channels.
                    self.assertGreater(needed, 288 * width * height)
                    self.assertLess(needed, 700 * width * height)
            print(f"\nslowest refusal {slowest * 1000:.1f} ms")
            # Judged by arithmetic: no job, and the worker has not been asked.
            self.assertEqual(daemon.request("GET", "/v1/jobs").json["items"], [])
            self.assertEqual(daemon.workers(), workers)
            self.assertEqual(daemon.wait_for_job(daemon.submit(fits)["id"])["state"], "succeeded")


if __name__ == "__main__":
    unittest.main()
