"""Previews of the layers that look at a method: each shows the pixels that the job has, exposure where it is light."""

import struct
import unittest

import numpy

from image_files import decoded_png
from photond_daemon import Daemon, small_job

LOOKS = ["clamped", "voxels", "vpls", "split_normal", "split_indirect"]
WIDTH = 24


def srgb(linear):
    """Display values, 0 to 255."""
    low = numpy.clip(linear, 0, 1)
    return 255 * numpy.where(low <= 0.0031308, 12.92 * low, 1.055 * low ** (1 / 2.4) - 0.055)


class LayerPreviewsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        body = small_job("cornell-box", WIDTH, 2, "svo_many_lights", layers=LOOKS + ["depth"])
        body["method"]["parameters"] = {"vpls": 64, "voxel_resolution": 32, "visibility": "svo"}
        cls.job = cls.daemon.wait_for_job(cls.daemon.submit(body)["id"])
        assert cls.job["state"] == "succeeded", cls.job

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def get(self, what):
        return self.daemon.request("GET", f"/v1/jobs/{self.job['id']}/{what}")

    def pixels(self, layer):
        reply = self.get(f"pixels?layer={layer}")
        self.assertEqual(reply.status, 200, reply)
        values = numpy.array(struct.unpack(f"<{len(reply.body) // 4}f", reply.body))
        return values.reshape(WIDTH, WIDTH, -1)

    def preview(self, layer, query=""):
        reply = self.get(f"preview.png?layer={layer}{query}")
        self.assertEqual(reply.status, 200, reply)
        return decoded_png(reply.body)

    def assert_shows(self, shown, expected):
        self.assertLessEqual(numpy.abs(shown - numpy.broadcast_to(expected, shown.shape)).max(), 0.501)

    def test_light_is_shown_as_light(self):
        for layer in ("clamped", "voxels", "split_indirect"):
            with self.subTest(layer):
                pixels = self.pixels(layer)
                self.assertGreater(pixels.max(), 0)
                self.assert_shows(self.preview(layer), srgb(pixels))
                self.assert_shows(self.preview(layer, "&exposure=2"), srgb(4 * pixels))

    def test_virtual_lights_are_dots(self):
        pixels = self.pixels("vpls")
        self.assertEqual(pixels.shape[2], 1)
        self.assertGreater(pixels.max(), 0)
        self.assert_shows(self.preview("vpls"), srgb(pixels))
        self.assert_shows(self.preview("vpls", "&exposure=-1"), srgb(pixels / 2))

    def test_normals_are_colours(self):
        pixels = self.pixels("split_normal")
        self.assertLess(pixels.min(), -0.5)
        self.assertGreater(pixels.max(), 0.5)
        self.assert_shows(self.preview("split_normal"), 255 * (pixels + 1) / 2)
        for query in ("&exposure=1", "&curve=filmic"):
            self.assertEqual(self.get("preview.png?layer=split_normal" + query).status, 422)

    def test_the_api_says_which_there_are(self):
        parameters = self.daemon.request("GET", "/v1/openapi.json").json["paths"]["/v1/jobs/{id}/preview.png"]["get"][
            "parameters"]
        known = next(parameter["schema"]["enum"] for parameter in parameters if parameter["name"] == "layer")
        self.assertLessEqual(set(LOOKS), set(known))
        for layer in known:
            there = layer in LOOKS or layer in ("beauty", "emitted", "direct", "indirect")
            self.assertEqual(self.get(f"preview.png?layer={layer}").status, 200 if there else 422, layer)
        self.assertEqual(self.get("preview.png?layer=depth").status, 422)


if __name__ == "__main__":
    unittest.main()
