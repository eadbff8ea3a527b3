"""What jobs are measured against: other jobs, uploaded images, and references rendered once for all who ask for the
same; waiting for them, failing with them; curves, targets, differences and maps; POST /v1/metrics.
"""

import csv
import io
import os
import signal
import unittest

from photond_daemon import Daemon, small_job

PATHS = {"name": "path_tracing"}
ENDLESS = 100_000_000  # passes: over long after the test


def made(passes, **method):
    return {"method": {**PATHS, **method}, "stop": {"passes": passes}}


def rows(daemon, role):
    return daemon.request("GET", f"/v1/jobs?limit=1000&role={role}").json["items"]


class ReferencesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.fine = cls.daemon.run_job(small_job(passes=64, seed=99, layers=["caustic"]))
        exr = cls.daemon.request("GET", cls.fine["links"]["image"]).body
        cls.image = cls.daemon.request("POST", "/v1/images", body=exr, headers={"Content-Type": "image/x-exr"}).json

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def get(self, path, status=200):
        reply = self.daemon.request("GET", path)
        self.assertEqual(reply.status, status, (path, reply))
        return reply

    def refused(self, body, pointer, status=422, path="/v1/jobs"):
        reply = self.daemon.request("POST", path, json_body=body)
        self.assertEqual(reply.status, status, reply)
        if pointer is not None:
            self.assertIn(pointer, [error["pointer"] for error in reply.json["errors"]], reply)
        return reply.json["detail"]

    def test_a_job_and_the_image_of_it_measure_alike(self):
        against_job = self.daemon.run_job(small_job(passes=4, reference=f"job:{self.fine['id']}", metrics=["indirect:rmse"]))
        against_image = self.daemon.run_job(small_job(passes=4, reference=f"image:{self.image['id']}"))
        self.assertEqual((against_job["reference_job"], against_job["reference_jobs"]), (self.fine["id"], [self.fine["id"]]))
        self.assertEqual((against_image["reference_job"], against_image["reference_jobs"]), (None, None))
        for job, form in ((against_job, "film"), (against_image, "image")):
            about = job["statistics"]["reference"]
            self.assertEqual((about["form"], about["confidence"], about["denominators"]), (form, None, {}))
            self.assertIn("errors hold its noise", " ".join(about["notes"]))
            self.assertEqual(job["statistics"]["error_interval"], {})
            self.assertEqual({str(point["intervals"]) for point in job["curve"]}, {"{}"})
        error, other = against_job["statistics"]["error"], against_image["statistics"]["error"]
        self.assertAlmostEqual(error["relative_mse"] / other["relative_mse"], 1, places=5)
        self.assertGreater(error["indirect:rmse"], 0)
        self.assertEqual(against_job["error_now"],
                         {"metric": "relative_mse", "value": error["relative_mse"], "interval": None})
        # Measuring leaves the picture alone.
        self.assertEqual(against_job["statistics"]["pixel_hash"],
                         self.daemon.run_job(small_job(passes=4))["statistics"]["pixel_hash"])

    def test_the_curve(self):
        job = self.daemon.run_job(small_job(passes=8, reference=f"job:{self.fine['id']}"))
        passes = [point["passes"] for point in job["curve"]]
        self.assertEqual(passes, sorted(set(passes)))
        self.assertLessEqual({1, 2, 4, 8}, set(passes))
        self.assertEqual(job["curve"][-1]["metrics"]["relative_mse"], job["statistics"]["error"]["relative_mse"])
        reply = self.get(job["links"]["curve"])
        self.assertEqual(reply.headers["content-type"].split(";")[0], "text/csv")
        table = list(csv.DictReader(io.StringIO(reply.text)))
        self.assertEqual(list(table[0])[:3], ["seconds", "passes", "photons"])
        self.assertEqual([int(row["passes"]) for row in table], passes)
        self.assertEqual(table[0]["photons"], "", "path tracing emits none")
        for row, point in zip(table, job["curve"]):
            for metric, value in point["metrics"].items():
                self.assertEqual(row[metric], "" if value is None else repr(value))
        events = self.daemon.request("GET", f"/v1/jobs/{job['id']}").json
        self.assertEqual(events["curve"], job["curve"])

    def test_a_target_stops_the_job(self):
        job = self.daemon.run_job({**small_job(reference=f"job:{self.fine['id']}"),
                            "stop": {"passes": 4096, "target": {"metric": "relative_mse", "value": 0.2}}})
        self.assertLess(job["passes_done"], 4096)
        self.assertLessEqual(job["statistics"]["error"]["relative_mse"], 0.2)
        by_passes = self.daemon.run_job(small_job(passes=job["passes_done"]))
        self.assertEqual(job["statistics"]["pixel_hash"], by_passes["statistics"]["pixel_hash"])
        estimated = self.daemon.run_job({**small_job(),
                                  "stop": {"passes": 4096,
                                           "target": {"metric": "estimated_relative_mse", "value": 0.2}}})
        self.assertLess(estimated["passes_done"], 4096)
        self.assertEqual(estimated["error_now"]["metric"], "estimated_relative_mse")

    def test_pictures_of_the_difference(self):
        job = self.daemon.run_job(small_job(passes=2, reference=f"job:{self.fine['id']}"))
        for name, magic in (("difference.exr", b"\x76\x2f\x31\x01"), ("flip.png", b"\x89PNG"),
                            ("error.png", b"\x89PNG"), ("flip.png?layer=direct&range=ldr", b"\x89PNG"),
                            ("error.png?layer=indirect", b"\x89PNG")):
            self.assertEqual(self.get(f"/v1/jobs/{job['id']}/{name}").body[:4], magic, name)
        flips = {self.get(f"/v1/jobs/{job['id']}/flip.png?range={range_}").body for range_ in ("ldr", "hdr")}
        self.assertEqual(len(flips), 2)
        self.get(f"/v1/jobs/{job['id']}/flip.png?layer=albedo", 422)
        self.get(f"/v1/jobs/{job['id']}/flip.png?range=mdr", 422)
        for name in ("difference", "flip", "error_map", "film", "curve"):
            self.assertEqual(self.get(job["links"][name]).status, 200, name)
        # Without a reference there is nothing to differ from, and the answer says so.
        for name in ("difference.exr", "flip.png", "error.png"):
            self.assertIn("has no reference", self.get(f"/v1/jobs/{self.fine['id']}/{name}", 404).json["detail"])
        self.assertIsNone(self.fine["links"]["difference"])

    def test_rendered_once_for_several(self):
        before = len(rows(self.daemon, "reference"))
        jobs = [self.daemon.submit(small_job(passes=2, seed=seed, reference=made(48), labels={"n": str(seed)}))
                for seed in range(1, 5)]
        films = [self.daemon.wait_for_job(row["id"]) for row in rows(self.daemon, "reference")[::-1][before:]]
        self.assertEqual([(film["role"], film["request"]["seed"], film["passes_done"], film["request"]["labels"])
                          for film in films], [("reference", 1, 24, {}), ("reference", 2, 24, {})])
        ids = [film["id"] for film in films]
        for job in jobs:
            self.assertEqual((job["reference_job"], job["reference_jobs"]), (ids[0], ids))
        done = [self.daemon.wait_for_job(job["id"]) for job in jobs]
        self.assertEqual({job["state"] for job in done}, {"succeeded"})
        self.assertGreaterEqual(min(job["started"] for job in done), max(film["finished"] for film in films))
        log = self.get(done[0]["links"]["log"]).text
        self.assertIn(f"waits for its reference, job {ids[0]} and {ids[1]}", log)
        # Their random numbers are their own: the same passes of the same seed would be the same noise.
        twin = self.daemon.run_job(small_job(passes=24))
        hashes = {job["statistics"]["pixel_hash"] for job in [twin, *films]}
        self.assertEqual(len(hashes), 3)
        # Of another number of passes, or with a layer more to measure, they are other images.
        self.daemon.run_job(small_job(passes=1, reference=made(50)))
        self.daemon.run_job(small_job(passes=1, reference=made(48), layers=["caustic", "depth"], metrics=["caustic:rmse"]))
        self.assertEqual(len(rows(self.daemon, "reference")), before + 6)
        self.assertEqual(rows(self.daemon, "reference")[0]["request"]["layers"], ["caustic"])

    def test_what_each_of_two_films_is_asked_for(self):
        def films(stop):
            job = self.daemon.submit(small_job(reference={"method": PATHS, "stop": stop}))
            stops = [self.daemon.job(film)["request"]["stop"] for film in job["reference_jobs"]]
            for film in [job["id"], *job["reference_jobs"]]:
                self.daemon.request("DELETE", f"/v1/jobs/{film}")
            self.assertEqual(stops[0], stops[1])
            return {name: value for name, value in stops[0].items() if value is not None}

        self.assertEqual(films({"passes": 7}), {"passes": 4})
        self.assertEqual(films({"passes": 1}), {"passes": 1})
        self.assertEqual(films({"seconds": 0.5}), {"seconds": 0.25})
        self.assertEqual(films({"seconds": 0.0015}), {"seconds": 0.001}, "the least there is")
        self.assertEqual(films({"passes": 64, "target": {"metric": "estimated_relative_mse", "value": 0.25}}),
                         {"passes": 32, "target": {"metric": "estimated_relative_mse", "value": 0.5}})

    def test_two_films_take_their_noise_out_of_the_error(self):
        job = self.daemon.run_job(small_job(passes=64, seed=5, reference=made(4), metrics=["direct:mse"]))
        truth = self.daemon.run_job(small_job(passes=64, seed=5, reference=f"job:{self.fine['id']}"))
        statistics, about = job["statistics"], job["statistics"]["reference"]
        self.assertEqual((about["form"], about["confidence"], about["passes"]), ("two_films", 0.9, 4))
        self.assertEqual(about["denominators"], {"relative_mse": "neighbours", "direct:relative_mse": "neighbours"})
        interval = statistics["error_interval"]
        self.assertLessEqual({"relative_mse", "mse", "rmse", "direct:mse"}, set(interval))
        self.assertLess(interval["mse"][0], statistics["error"]["mse"])
        # Two passes each are far noisier than the image; a film of 64 other passes, as noisy as that, says how far it is.
        noise = statistics["reference_error"]["mse"]
        self.assertGreater(noise, 5 * truth["statistics"]["error"]["mse"])
        self.assertLess(abs(statistics["error"]["mse"]), noise / 2)
        self.assertEqual({warning.split(" ")[0] for warning in about["warnings"]} & set(interval), set())
        last = job["curve"][-1]
        self.assertEqual(last["intervals"]["mse"], interval["mse"])
        self.assertEqual(last["metrics"]["mse"], statistics["error"]["mse"])
        self.assertEqual(job["error_now"], {"metric": "relative_mse", "value": statistics["error"]["relative_mse"],
                                            "interval": interval["relative_mse"]})
        root = statistics["error"]["rmse"]
        self.assertEqual(root is None, statistics["error"]["mse"] < 0)
        self.assertAlmostEqual(interval["rmse"][1] ** 2, interval["mse"][1], places=9)
        # The same by request; pictures are of the difference from both.
        sources = [f"job:{film}" for film in job["reference_jobs"]]
        # (A reference's two films have other streams than jobs have: their seeds may be named together.)
        body = {"image": f"job:{job['id']}", "references": sources, "metrics": ["mse", "mae"]}
        asked = self.daemon.request("POST", "/v1/metrics", json_body=body).json
        self.assertEqual(asked["metrics"]["mse"], statistics["error"]["mse"])
        self.assertEqual(asked["intervals"]["mse"], interval["mse"])
        self.assertEqual(asked["metrics"]["mae"], statistics["error"]["mae"])
        for name in ("difference.exr", "flip.png", "error.png"):
            self.get(f"/v1/jobs/{job['id']}/{name}")

    def test_what_cannot_be_measured_is_refused(self):
        fine = f"job:{self.fine['id']}"
        self.refused(small_job(size=16, reference=fine), "/reference")
        self.refused(small_job(size=16, reference=f"image:{self.image['id']}"), "/reference")
        self.refused(small_job(reference="job:J99999"), "/reference")
        bare = self.daemon.run_job(small_job())
        detail = self.refused(small_job(reference=f"job:{bare['id']}", layers=["caustic"], metrics=["caustic:rmse"]),
                              "/metrics/0")
        self.assertIn("caustic", detail)
        queued = self.daemon.submit(small_job(passes=ENDLESS))["id"]
        self.daemon.request("DELETE", f"/v1/jobs/{queued}")
        if not self.daemon.wait_for_job(queued)["passes_done"]:
            self.refused(small_job(reference=f"job:{queued}"), "/reference")
        self.refused(small_job(reference=made(1, device="gpu:0")), "/reference/method/device")

    def test_a_reference_that_does_not_come(self):
        waiting = [self.daemon.submit(small_job(reference=made(ENDLESS), seed=seed)) for seed in (1, 2)]
        reference, second = waiting[0]["reference_jobs"]
        self.assertEqual(waiting[1]["reference_jobs"], [reference, second])
        for image in ("image.exr", "curve.csv", "flip.png"):
            self.get(f"/v1/jobs/{waiting[0]['id']}/{image}", 202)
        purge = self.daemon.request("DELETE", f"/v1/jobs/{reference}?purge=true")
        self.assertEqual(purge.status, 409, purge)
        self.assertIn(waiting[0]["id"], purge.json["detail"])
        # Who needs it more raises it.
        urgent = self.daemon.submit(small_job(reference=made(ENDLESS), priority=7))
        self.assertEqual(urgent["reference_jobs"], [reference, second])
        self.assertEqual(self.daemon.job(second)["request"]["priority"], 7)
        self.assertEqual(self.daemon.request("DELETE", f"/v1/jobs/{urgent['id']}").status, 202)
        self.daemon.request("DELETE", f"/v1/jobs/{reference}")
        for job in waiting:
            job = self.daemon.wait_for_job(job["id"])
            self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "wrong_state"), job)
            self.assertIn(f"job {reference}, was cancelled", job["failure"]["detail"])
            self.assertEqual(job["attempts"], [])
        self.daemon.wait_for_job(second, ("cancelled",))  # nobody needs it any more
        # Nor for a job that is cancelled: one film may run, the other one does not begin.
        lonely = self.daemon.submit(small_job(reference=made(ENDLESS, parameters={"indirect_bounces": 1})))
        self.daemon.request("DELETE", f"/v1/jobs/{lonely['id']}")
        self.daemon.wait_for_job(lonely["reference_jobs"][1], ("cancelled",))
        self.daemon.request("DELETE", f"/v1/jobs/{lonely['reference_job']}")
        # Asked for again it is made anew, and so for a job that is tried again.
        again = self.daemon.request("POST", f"/v1/jobs/{waiting[0]['id']}/retry").json
        self.assertNotEqual(again["reference_job"], reference)
        self.daemon.request("DELETE", f"/v1/jobs/{again['reference_job']}")
        self.assertEqual(self.daemon.wait_for_job(again["id"])["state"], "failed")

    def test_metrics_on_request(self):
        job = self.daemon.run_job(small_job(passes=4, reference=f"job:{self.fine['id']}"))
        image, reference = f"job:{job['id']}", f"job:{self.fine['id']}"
        ask = {"image": image, "reference": reference}
        reply = self.daemon.request("POST", "/v1/metrics", json_body=ask)
        self.assertEqual(reply.status, 200, reply)
        metrics = reply.json["metrics"]
        self.assertGreaterEqual(set(metrics), {"relative_mse", "rmse", "mae", "smape", "rmse_8bit", "flip_ldr",
                                               "flip_hdr", "bias", "relative_bias", "percentiles", "firefly_count"})
        self.assertEqual(metrics["relative_mse"], job["statistics"]["error"]["relative_mse"])
        some = self.daemon.request("POST", "/v1/metrics", json_body={**ask, "metrics": ["direct:rmse", "mae"]}).json
        self.assertEqual(set(some["metrics"]), {"direct:rmse", "mae"})
        by_image = {**ask, "reference": f"image:{self.image['id']}"}
        by_image = self.daemon.request("POST", "/v1/metrics", json_body=by_image).json
        self.assertAlmostEqual(by_image["metrics"]["mae"], metrics["mae"], places=5)
        for body, pointer, status in (
                ({}, "/image", 422), ({"image": image}, "/reference", 422),
                ({**ask, "metric": ["mae"]}, "/metric", 422),
                ({**ask, "references": [image, reference]}, "/references", 422),
                ({"image": image, "references": [reference]}, "/references", 422),
                ({"image": image, "references": reference}, "/references", 422),
                ({"image": image, "references": [reference, 1]}, "/references/1", 422),
                ({"image": image, "references": [reference, "J1"]}, "/references/1", 422),
                ({"image": image, "references": [reference, reference]}, "/references/1", 422),
                ({**ask, "image": "J1"}, "/image", 422), ({**ask, "image": "job:J99999"}, "/image", 422),
                ({**ask, "reference": "image:none"}, "/reference", 422), ({**ask, "metrics": []}, "/metrics", 422),
                ({**ask, "metrics": ["mea"]}, "/metrics/0", 422), ({**ask, "metrics": ["mae", 1]}, "/metrics/1", 422),
                ({**ask, "metrics": ["albedo:mae"]}, "/metrics/0", 422),
                ({**ask, "metrics": ["estimated_relative_mse"]}, "/metrics/0", 422)):
            with self.subTest(body=body):
                self.refused(body, pointer, status, "/v1/metrics")
        small = self.daemon.run_job(small_job(size=16))
        self.refused({**ask, "image": f"job:{small['id']}"}, "/image", 422, "/v1/metrics")

    def test_two_references_take_their_noise_out(self):
        shot = self.daemon.run_job(small_job(passes=64, seed=5))
        noisy = [self.daemon.run_job(small_job(passes=2, seed=seed)) for seed in (6, 7)]
        sources = [f"job:{job['id']}" for job in noisy]

        def measure(**body):
            body = {"image": f"job:{shot['id']}", "metrics": ["relative_mse", "mse", "rmse", "mae", "direct:mse"], **body}
            reply = self.daemon.request("POST", "/v1/metrics", json_body=body)
            self.assertEqual(reply.status, 200, reply)
            return reply.json

        against_fine = measure(reference=f"job:{self.fine['id']}")
        self.assertIsNone(against_fine["intervals"])
        spoilt, crossed = measure(reference=sources[0]), measure(references=sources)
        self.assertGreater(spoilt["metrics"]["mse"], 4 * against_fine["metrics"]["mse"], "two passes are mostly noise")
        self.assertEqual(set(crossed["intervals"]), {"relative_mse", "mse", "rmse", "direct:mse"})
        least, greatest = crossed["intervals"]["mse"]
        self.assertLess(least, crossed["metrics"]["mse"])
        self.assertLess(abs(crossed["metrics"]["mse"]), spoilt["metrics"]["mse"] / 2)
        self.assertAlmostEqual(crossed["intervals"]["rmse"][1] ** 2, greatest, places=9)
        self.assertIsNone(crossed["reference_error"]["mse"])
        self.assertGreater(crossed["reference_error"]["mae"], 0, "against their mean")
        swapped = measure(references=sources[::-1])
        self.assertAlmostEqual(swapped["metrics"]["mse"], crossed["metrics"]["mse"], places=12)
        again = self.daemon.run_job(small_job(passes=4, seed=6))
        detail = self.refused({"image": sources[0], "references": [sources[0], f"job:{again['id']}"]}, "/references/1",
                              422, "/v1/metrics")
        self.assertIn("seed 6", detail)


class WaitingTest(unittest.TestCase):
    def test_across_kills_and_a_restart(self):
        with Daemon() as daemon:
            daemon.wait_ready()
            job = daemon.submit({**small_job(size=64), "reference": made(600)})
            reference = job["reference_job"]
            self.assertEqual(daemon.wait_for_job(reference, ("running",))["role"], "reference")
            daemon.kill()
            daemon.start()
            job = daemon.wait_for_job(job["id"])
            self.assertEqual((job["state"], job["reference_job"]), ("succeeded", reference), job["failure"])
            self.assertEqual(len(job["attempts"]), 1, "it was never begun before its reference was there")
            self.assertEqual(daemon.job(reference)["state"], "succeeded")
            # Kept over the restart, and taken by who asks for the same.
            self.assertEqual(daemon.stop(), 0)
            daemon.start()
            other = daemon.wait_for_job(daemon.submit({**small_job(size=64, seed=5), "reference": made(600)})["id"])
            self.assertEqual((other["state"], other["reference_job"]), ("succeeded", reference))
            self.assertEqual(len(rows(daemon, "reference")), 2)
            # Once nobody needs it, it can go; what it was good for then says so.
            self.assertEqual(daemon.request("DELETE", f"/v1/jobs/{reference}?purge=true").status, 200)
            gone = daemon.request("GET", f"/v1/jobs/{other['id']}/difference.exr")
            self.assertEqual(gone.status, 404)
            self.assertIn(f"job {reference}, has been removed", gone.json["detail"])

    def test_a_reference_that_fails(self):
        with Daemon() as daemon:
            daemon.wait_ready()
            job = daemon.submit({**small_job(), "reference": made(ENDLESS)})
            for attempt in (1, 2):
                daemon.wait_for_job_that(lambda found: len(found["attempts"]) == attempt and found["passes_done"] > 0,
                                         f"to have done a pass of attempt {attempt}", job["reference_job"])
                os.kill(daemon.workers()["cpu"], signal.SIGSEGV)
            job = daemon.wait_for_job(job["id"])
            self.assertEqual(job["state"], "failed")
            self.assertIn(f"job {job['reference_job']}, failed: attempt 2 crashed", job["failure"]["detail"])


if __name__ == "__main__":
    unittest.main()
