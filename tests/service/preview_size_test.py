"""Previews of a size asked for: means of the light below each pixel, never larger than the image."""

import unittest

import numpy

from image_files import decoded_png
from layer_previews_test import srgb
from photond_daemon import Daemon, small_job

WIDTH, HEIGHT = 96, 64


class PreviewSizeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        body = small_job("cornell-box", WIDTH, 1)
        body["image"]["height"] = HEIGHT
        cls.job = cls.daemon.wait_for_job(cls.daemon.submit(body)["id"])
        assert cls.job["state"] == "succeeded", cls.job

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def get(self, query):
        return self.daemon.request("GET", f"/v1/jobs/{self.job['id']}/preview.png{query}")

    def picture(self, query):
        reply = self.get(query)
        self.assertEqual(reply.status, 200, reply)
        return decoded_png(reply.body)

    def test_each_pixel_is_the_mean_of_the_light_below_it(self):
        reply = self.daemon.request("GET", f"/v1/jobs/{self.job['id']}/pixels")
        light = numpy.frombuffer(reply.body, "<f4").reshape(HEIGHT, WIDTH, 3).astype(float)
        for side in (48, 24):
            step = WIDTH // side
            means = light.reshape(HEIGHT // step, step, side, step, 3).mean(axis=(1, 3))
            for query, gain in (("", 1), ("&exposure=-3", 1 / 8)):
                shown = self.picture(f"?max_size={side}{query}")
                self.assertEqual(shown.shape, means.shape)
                self.assertLessEqual(numpy.abs(shown - srgb(gain * means)).max(), 0.51)
        # One pass is noisy: means of display values would be much darker at the light's edge, so the test can fail.
        display = srgb(light).reshape(HEIGHT // 4, 4, WIDTH // 4, 4, 3).mean(axis=(1, 3))
        self.assertGreater(numpy.abs(display - self.picture("?max_size=24")).max(), 10)

    def test_sizes_that_do_not_divide_it(self):
        self.assertEqual(self.picture("?max_size=37").shape[:2], (25, 37))

    def test_it_is_never_scaled_up(self):
        whole = self.get("")
        self.assertEqual(self.picture("").shape[:2], (HEIGHT, WIDTH))
        for side in (WIDTH, 4096):
            self.assertEqual(self.get(f"?max_size={side}").body, whole.body)

    def test_bad_sizes_are_refused(self):
        for value in ("0", "15", "4097", "-16", "16.5", "x"):
            reply = self.get(f"?max_size={value}")
            self.assertEqual(reply.status, 422, reply)
            self.assertEqual([error["pointer"] for error in reply.json["errors"]], ["/max_size"])


if __name__ == "__main__":
    unittest.main()
