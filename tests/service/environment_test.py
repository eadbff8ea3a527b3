"""Environment images from the upload to the pixel: what misses the scene shows the image's radiance times `scale`, turned
by `rotation`; what is hit is lit by it. The images are written by OpenImageIO, the expected values computed here.
"""

import json
import math
import pathlib
import struct
import tempfile
import unittest

import numpy
import OpenImageIO as oiio

import tiny_scene
from photond_daemon import Daemon, small_job

MEDIA_TYPES = {".exr": "image/x-exr", ".hdr": "image/vnd.radiance"}
# Exact in half, float and RGBE; so are their products with SCALE.
RADIANCE = numpy.array([1.5, 0.75, 0.25], numpy.float32)
SCALE = 2.5
ALBEDO = 0.5
FALSE_ALARM_SIGMA = 5.2  # two-sided 2e-7 for each of three channels: below 1e-6 together
MUST_DETECT = 0.01       # a relative error this large may not go unnoticed


def dark_triangle():
    """A Lambert triangle of albedo ALBEDO, seen by a camera that looks past it too; no light."""
    document, binary = tiny_scene.triangle(60)
    document["extensionsUsed"] = ["KHR_materials_specular"]
    document["materials"] = [{"doubleSided": True, "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
                              "pbrMetallicRoughness": {"baseColorFactor": [ALBEDO, ALBEDO, ALBEDO, 1],
                                                       "metallicFactor": 0}}]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class EnvironmentTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="photond-test-")
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.scene = cls.daemon.request("POST", "/v1/scenes", body=dark_triangle(),
                                       headers={"Content-Type": "model/gltf-binary"}).json["id"]

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()
        cls.folder.cleanup()

    def upload(self, pixels, suffix=".exr", precision="float"):
        """Rows of RGB as an image of the daemon's; "image:ID"."""
        pixels = numpy.ascontiguousarray(pixels, numpy.float32)
        path = str(pathlib.Path(self.folder.name) / f"environment{suffix}")
        out = oiio.ImageOutput.create(path)
        self.assertTrue(out.open(path, oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, precision)), oiio.geterror())
        self.assertTrue(out.write_image(pixels), out.geterror())
        out.close()
        reply = self.daemon.request("POST", "/v1/images", body=pathlib.Path(path).read_bytes(),
                                    headers={"Content-Type": MEDIA_TYPES[suffix]})
        self.assertIn(reply.status, (200, 201), reply)
        self.assertEqual((reply.json["width"], reply.json["height"]), pixels.shape[1::-1])
        return f"image:{reply.json['id']}"

    def render(self, environment, size=32, passes=2, **more):
        job = small_job(self.scene, size, passes, environment=environment, **more)
        job = self.daemon.wait_for_job(self.daemon.submit(job)["id"])
        self.assertEqual(job["state"], "succeeded", job)
        self.assertEqual((job["statistics"]["nan_count"], job["statistics"]["infinity_count"]), (0, 0))
        return job

    def layer(self, job, name):
        reply = self.daemon.request("GET", f"/v1/jobs/{job['id']}/pixels?layer={name}")
        self.assertEqual(reply.status, 200, reply)
        size = job["request"]["image"]
        return numpy.frombuffer(reply.body, "<f4").reshape(size["height"], size["width"], -1)

    # --- constant all around

    def test_what_misses_is_the_radiance_times_scale_exactly(self):
        constant = numpy.broadcast_to(RADIANCE, (4, 8, 3))
        for suffix, precision in ((".exr", "float"), (".exr", "half"), (".hdr", "float")):
            image = self.upload(constant, suffix, precision)
            for scale, rotation in ((1, 0), (SCALE, 0), (SCALE, 1.25), (0, 0)):
                with self.subTest(suffix=suffix, precision=precision, scale=scale, rotation=rotation):
                    job = self.render({"image": image, "scale": scale, "rotation": rotation}, layers=["depth"])
                    self.assertTrue(job["statistics"]["needs"]["environment"])
                    missed = self.layer(job, "depth")[:, :, 0] == 0
                    self.assertGreater(missed.sum(), 200)
                    self.assertGreater((~missed).sum(), 200)
                    expected = RADIANCE * numpy.float32(scale)
                    for name, value in (("beauty", expected), ("emitted", expected), ("direct", 0), ("indirect", 0)):
                        seen = self.layer(job, name)[missed]
                        self.assertTrue((seen == value).all(), f"{name}: {value} expected, {seen.min(0)} to {seen.max(0)}")

    def test_what_is_hit_reflects_its_share(self):
        """A flat Lambert surface under L everywhere sends albedo x L, with no light from itself."""
        image = self.upload(numpy.broadcast_to(RADIANCE, (4, 8, 3)))
        job = self.render({"image": image, "scale": SCALE}, passes=64, layers=["depth", "albedo", "standard_error"])
        hit = self.layer(job, "depth")[:, :, 0] > 0
        inside = hit.copy()  # pixels with nothing but hits around them: no sample of theirs missed
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                inside &= numpy.roll(hit, (dy, dx), (0, 1))
        inside[[0, -1], :] = inside[:, [0, -1]] = False
        self.assertGreater(inside.sum(), 100)
        self.assertLess(abs(self.layer(job, "albedo")[inside] - ALBEDO).max(), 1e-6)
        self.assertTrue((self.layer(job, "emitted")[inside] == 0).all())
        self.assertTrue((self.layer(job, "indirect")[inside] == 0).all())
        expected = ALBEDO * SCALE * RADIANCE.astype(float)
        mean = self.layer(job, "direct")[inside].astype(float).mean(0)
        error = self.layer(job, "standard_error")[inside].astype(float)
        sigma = numpy.sqrt((error**2).sum(0)) / inside.sum()
        print(f"\nhit: {mean} for {expected}, sigma {sigma}")
        self.assertTrue((abs(mean - expected) <= FALSE_ALARM_SIGMA * sigma + 1e-6 * expected).all(), (mean, sigma))
        self.assertTrue((FALSE_ALARM_SIGMA * sigma < MUST_DETECT * expected).all(), "too noisy to notice a defect")

    # --- where things are

    @staticmethod
    def bilinear(pixels, direction, rotation):
        """The image looked up by our own reading of conventions.md, "Environment": its middle is at -Z, +X to the right of it, the top
        row at +Y; turning by `rotation` moves what is at -Z towards -X."""
        x, y, z = direction
        height, width, _ = pixels.shape
        column = (0.5 + (math.atan2(x, -z) + rotation) / (2 * math.pi)) * width - 0.5
        row = math.acos(y / math.sqrt(x * x + y * y + z * z)) / math.pi * height - 0.5
        left, top = math.floor(column), math.floor(row)
        result = 0
        for r, part_r in ((top, 1 - (row - top)), (top + 1, row - top)):
            for c, part_c in ((left, 1 - (column - left)), (left + 1, column - left)):
                result = result + part_r * part_c * pixels[min(max(r, 0), height - 1), c % width].astype(float)
        return result

    def test_every_direction_shows_its_place_in_the_image(self):
        pixels = numpy.random.default_rng(5).uniform(0.25, 4, (8, 16, 3)).astype(numpy.float32)
        image = self.upload(pixels)
        directions = [(0, 0, -1), (1, 0, 0), (-1, 0, 0), (0.1, 0.1, 1), (-0.1, -0.3, 1), (1, 2, -0.5), (-0.7, -2, 0.4),
                      (0.3, 0.9, -0.8), (0.2, 2, 0.3), (-0.4, -2, -0.1)]
        for rotation in (0, 0.6, -2.2, 7):
            for direction in directions:
                eye = (30, 40, 50)  # away from the triangle
                look_at = {"eye": eye, "target": [e + d for e, d in zip(eye, direction)], "up": [0.3, 1, 0.2],
                           "yfov": 2e-4}
                job = self.render({"image": image, "scale": SCALE, "rotation": rotation}, size=4, passes=1,
                                  camera={"look_at": look_at})
                expected = SCALE * self.bilinear(pixels, direction, rotation)
                seen = self.layer(job, "emitted")
                # Half a field of view is at most 0.002 texels here, and neighbours differ by less than a factor of 16.
                self.assertLess(abs(seen / expected - 1).max(), 0.03, (direction, rotation, seen[0, 0], expected))

    def test_it_lights_from_where_it_is(self):
        """One bright texel above and in front of the triangle or behind it, by rotation alone: lit, or not."""
        pixels = numpy.zeros((8, 16, 3), numpy.float32)
        pixels[4, 8] = 100  # just below the horizon, just right of -Z: behind the triangle as the camera sees it
        document = {"image": self.upload(pixels)}
        brightness = {}
        for name, rotation in (("behind", 0), ("in front", math.pi)):
            job = self.render({**document, "rotation": rotation}, passes=16, layers=["depth"])
            hit = self.layer(job, "depth")[:, :, 0] > 0
            brightness[name] = float(self.layer(job, "direct")[hit].mean())
        self.assertEqual(brightness["behind"], 0)
        # E = L x cos x the texel's bilinear solid angle; albedo / pi of it. The texel lies within 35 degrees of the normal.
        solid_angle = (2 * math.pi / 16) * (math.pi / 8)
        self.assertGreater(brightness["in front"], 0.7 * ALBEDO / math.pi * 100 * solid_angle * math.cos(math.radians(35)))
        self.assertLess(brightness["in front"], 1.3 * ALBEDO / math.pi * 100 * solid_angle)


if __name__ == "__main__":
    unittest.main()
