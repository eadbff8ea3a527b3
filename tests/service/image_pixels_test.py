"""Pixels of uploaded images: each layer as the file has it, whatever program named its channels."""

import os
import sqlite3
import tempfile
import unittest

import numpy

from image_files import encoded
from photond_daemon import Daemon

WIDTH, HEIGHT = 37, 21  # odd, so that a row taken for another shows
CHANNELS = ["R", "G", "B", "A", "direct.R", "direct.G", "direct.B", "bent.X", "bent.Y", "bent.Z", "depth.Z", "grey.Y",
            "View.Combined.R", "View.Combined.G", "View.Combined.B", "matte.id"]
LAYERS = {"beauty": ["R", "G", "B"], "direct": ["direct.R", "direct.G", "direct.B"],
          "bent": ["bent.X", "bent.Y", "bent.Z"], "depth": ["depth.Z"], "grey": ["grey.Y"],
          "View.Combined": ["View.Combined.R", "View.Combined.G", "View.Combined.B"]}


class ImagePixelsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.pixels = numpy.random.default_rng(7).uniform(-2, 2, (HEIGHT, WIDTH, len(CHANNELS))).astype(numpy.float32)
        cls.image = cls.upload(encoded(cls.pixels, CHANNELS))

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    @classmethod
    def upload(cls, body, media_type="image/x-exr"):
        reply = cls.daemon.request("POST", "/v1/images", body=body, headers={"Content-Type": media_type})
        assert reply.status in (200, 201), reply
        return reply.json

    def get(self, query, image=None, headers=None):
        return self.daemon.request("GET", f"/v1/images/{(image or self.image)['id']}/pixels{query}", headers=headers)

    def read(self, reply, kind="<f4"):
        self.assertEqual(reply.status, 200, reply)
        shape = [int(reply.headers["x-image-" + side]) for side in ("height", "width", "channels")]
        return numpy.frombuffer(reply.body, kind).reshape(shape)

    def of_layer(self, name):
        return self.pixels[:, :, [CHANNELS.index(channel) for channel in LAYERS[name]]]

    def test_the_image_names_its_layers(self):
        layers = self.image["layers"]
        self.assertEqual(layers[0], {"name": "beauty", "channels": 3})
        self.assertEqual({layer["name"]: layer["channels"] for layer in layers},
                         {name: len(channels) for name, channels in LAYERS.items()})
        self.assertEqual(self.image["channels"], len(CHANNELS))
        again = self.daemon.request("GET", f"/v1/images/{self.image['id']}").json
        self.assertEqual(again, self.image)

    def test_each_layer_comes_bit_for_bit(self):
        for name in LAYERS:
            with self.subTest(name):
                reply = self.get(f"?layer={name}")
                self.assertEqual(reply.headers["x-image-overflowed"], "0")
                self.assertTrue(numpy.array_equal(self.read(reply), self.of_layer(name)))
        self.assertEqual(self.get("").body, self.get("?layer=beauty&precision=float").body)

    def test_half_is_rounded_and_overflow_counted(self):
        pixels = self.of_layer("beauty").copy()
        pixels[3, 5] = [70000, -70000, 65504]
        image = self.upload(encoded(pixels, ["R", "G", "B"]))
        reply = self.get("?precision=half", image)
        self.assertEqual(reply.headers["x-image-overflowed"], "2")
        with numpy.errstate(over="ignore"):
            expected = pixels.astype("<f2")
        self.assertTrue(numpy.array_equal(self.read(reply, "<f2"), expected))

    def test_images_of_grey_and_of_radiance_files(self):
        grey = self.upload(encoded(self.of_layer("grey"), ["Y"]))
        self.assertEqual(grey["layers"], [{"name": "beauty", "channels": 1}])
        self.assertTrue(numpy.array_equal(self.read(self.get("", grey)), self.of_layer("grey")))
        # Powers of two are exact in shared-exponent pixels.
        powers = 2.0 ** numpy.random.default_rng(1).integers(-3, 4, (HEIGHT, WIDTH, 1)).repeat(3, 2)
        hdr = self.upload(encoded(powers, ["R", "G", "B"], "image.hdr"), "image/vnd.radiance")
        self.assertEqual(hdr["layers"], [{"name": "beauty", "channels": 3}])
        self.assertTrue(numpy.allclose(self.read(self.get("", hdr)), powers, rtol=1 / 128))

    def test_it_is_kept_and_can_be_asked_for_in_parts(self):
        whole = self.get("?layer=depth")
        part = self.get("?layer=depth", headers={"Range": "bytes=8-23"})
        self.assertEqual((part.status, part.body), (206, whole.body[8:24]))
        same = self.get("?layer=depth", headers={"If-None-Match": whole.headers["etag"]})
        self.assertEqual((same.status, same.body), (304, b""))

    def test_bad_requests_name_the_fault(self):
        for query, pointer, words in (("?layer=bend", "/layer", "bent"), ("?layer=A", "/layer", "View.Combined"),
                                      ("?precision=double", "/precision", "double"),
                                      ("?lyer=beauty", "/lyer", "layer")):
            with self.subTest(query):
                reply = self.get(query)
                self.assertEqual(reply.status, 422, reply)
                self.assertEqual([error["pointer"] for error in reply.json["errors"]], [pointer])
                self.assertIn(words, reply.json["errors"][0]["detail"])
        self.assertEqual(self.get("", {"id": "none"}).status, 404)

    def test_an_image_without_any_layer_has_no_pixels(self):
        alone = self.upload(encoded(self.of_layer("grey"), ["A"]))
        self.assertEqual(alone["layers"], [])
        self.assertEqual(self.get("", alone).status, 422)


class OldImages(unittest.TestCase):
    def test_images_of_an_earlier_version_are_looked_at_again(self):
        with tempfile.TemporaryDirectory() as data:
            pixels = numpy.full((4, 5, 3), 0.25, numpy.float32)
            with Daemon(data_dir=data) as daemon:
                daemon.wait_ready()
                image = daemon.request("POST", "/v1/images", body=encoded(pixels, ["R", "G", "B"]),
                                       headers={"Content-Type": "image/x-exr"}).json
            [database] = [file for file in os.listdir(data) if file.endswith((".db", ".sqlite", ".sqlite3"))]
            store = sqlite3.connect(os.path.join(data, database))
            with store:
                self.assertEqual(store.execute("UPDATE images SET layers = ''").rowcount, 1)
            store.close()
            with Daemon(data_dir=data) as daemon:
                daemon.wait_ready()
                self.assertEqual(daemon.request("GET", f"/v1/images/{image['id']}").json, image)
                reply = daemon.request("GET", f"/v1/images/{image['id']}/pixels")
                self.assertEqual(reply.body, pixels.tobytes())


if __name__ == "__main__":
    unittest.main()
