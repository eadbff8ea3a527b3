"""The FLIP map of any two images: its pixels are those whose mean the metrics give, and a picture shows."""

import unittest

import numpy

from image_files import encoded
from photond_daemon import Daemon, small_job

WIDTH = 32


class FlipMapTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.reference = cls.render(64, seed=1)
        cls.noisy = cls.render(1, seed=2, reference=f"job:{cls.reference}")

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    @classmethod
    def render(cls, passes, **changes):
        job = cls.daemon.wait_for_job(cls.daemon.submit(small_job("cornell-box", WIDTH, passes, **changes))["id"])
        assert job["state"] == "succeeded", job
        return job["id"]

    def get(self, image, reference, query=""):
        return self.daemon.request("GET", f"/v1/flip?image={image}&reference={reference}{query}")

    def read(self, reply, kind="<f4"):
        self.assertEqual(reply.status, 200, reply)
        shape = [int(reply.headers["x-image-" + side]) for side in ("height", "width", "channels")]
        self.assertEqual(shape[2], 1)
        return numpy.frombuffer(reply.body, kind).reshape(shape[:2])

    def test_its_mean_is_the_metric(self):
        pair = {"image": f"job:{self.noisy}", "reference": f"job:{self.reference}"}
        for layer, named in (("beauty", "flip_{}"), ("indirect", "indirect:flip_{}")):
            for flip_range in ("hdr", "ldr"):
                metric = named.format(flip_range)
                with self.subTest(metric):
                    reply = self.get(*pair.values(), f"&layer={layer}&range={flip_range}")
                    flip = self.read(reply)
                    self.assertEqual(flip.shape, (WIDTH, WIDTH))
                    self.assertGreaterEqual(flip.min(), 0)
                    self.assertLessEqual(flip.max(), 1)
                    expected = self.daemon.request("POST", "/v1/metrics", json_body={**pair, "metrics": [metric]}).json
                    expected = expected["metrics"][metric]
                    self.assertGreater(expected, 0.01)
                    self.assertAlmostEqual(flip.mean(dtype=float), expected, 6)
                    self.assertAlmostEqual(float(reply.headers["x-flip-mean"]), expected, 12)
        self.assertEqual(self.get(*pair.values()).body, self.get(*pair.values(), "&layer=beauty&range=hdr").body)
        half = self.get(*pair.values(), "&precision=half")
        self.assertTrue(numpy.array_equal(self.read(half, "<f2"),
                                          self.read(self.get(*pair.values())).astype("<f2")))

    def test_the_picture_of_a_job_says_the_same_mean(self):
        picture = self.daemon.request("GET", f"/v1/jobs/{self.noisy}/flip.png?range=ldr")
        raw = self.get(f"job:{self.noisy}", f"job:{self.reference}", "&range=ldr")
        self.assertEqual(picture.headers["x-flip-mean"], raw.headers["x-flip-mean"])

    def test_jobs_and_images_go_together(self):
        exr = self.daemon.request("GET", f"/v1/jobs/{self.reference}/image.exr").body
        image = self.daemon.request("POST", "/v1/images", body=exr, headers={"Content-Type": "image/x-exr"}).json
        same = self.read(self.get(f"image:{image['id']}", f"job:{self.reference}"))
        self.assertEqual(same.max(), 0)
        by_image = self.get(f"job:{self.noisy}", f"image:{image['id']}")
        self.assertEqual(self.read(by_image).tobytes(),
                         self.read(self.get(f"job:{self.noisy}", f"job:{self.reference}")).tobytes())

    def test_a_job_without_a_film_is_waited_for(self):
        long = self.daemon.submit({**small_job(size=16), "stop": {"seconds": 3600}})["id"]
        waiting = self.daemon.submit(small_job(size=16))["id"]
        try:
            for pair in ((waiting, self.reference), (self.reference, waiting)):
                reply = self.get(*(f"job:{job}" for job in pair))
                self.assertEqual((reply.status, reply.body), (202, b""))
                self.assertIn("retry-after", reply.headers)
        finally:
            for job in (long, waiting):
                self.daemon.request("DELETE", f"/v1/jobs/{job}")

    def test_bad_requests_name_every_fault(self):
        good = f"job:{self.noisy}", f"job:{self.reference}"
        small = encoded(numpy.ones((4, 4, 3)), ["R", "G", "B"])
        small = self.daemon.request("POST", "/v1/images", body=small, headers={"Content-Type": "image/x-exr"}).json
        for reply, pointers in (
                (self.daemon.request("GET", "/v1/flip"), ["/image", "/reference"]),
                (self.get("J1", "picture:2", "&layer=albedo&range=sdr&precision=double"),
                 ["/image", "/reference", "/layer", "/range", "/precision"]),
                (self.get("job:J999", good[1]), ["/image"]),
                (self.get(good[0], "image:none"), ["/reference"]),
                (self.get(*good, "&layer=caustic"), ["/layer"]),
                (self.get(*good, "&rnge=ldr"), ["/rnge"]),
                (self.get(f"image:{small['id']}", good[1]), ["/image"])):
            self.assertEqual(reply.status, 422, reply)
            self.assertEqual([error["pointer"] for error in reply.json["errors"]], pointers, reply)
        self.assertIn("4 x 4", reply.json["detail"])


if __name__ == "__main__":
    unittest.main()
