"""Films and images compared and joined by the real helper: films of a real worker, read back by other programs."""

import os
import tempfile
import unittest

import numpy
import OpenImageIO as oiio

from worker_process import WorkerProcess

WIDTH, HEIGHT, PASSES = 40, 30, 16


def read_image(path, kind="float"):
    image = oiio.ImageInput.open(path)
    assert image, oiio.geterror()
    spec = image.spec()
    pixels = numpy.asarray(image.read_image(kind)).reshape(spec.height, spec.width, spec.nchannels)
    image.close()
    return {name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)}


def rgb(channels, layer=""):
    return numpy.stack([channels[layer + c] for c in "RGB"], axis=-1)


class HelperErrors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        cls.worker, cls.helper = WorkerProcess("cpu", cls.folder), WorkerProcess("none", cls.folder)
        for process in (cls.worker, cls.helper):
            cls.addClassCleanup(process.close)
            process.wait_for("hello")
        cls.whole = cls.render("whole", 0, PASSES)
        cls.reference = cls.render("reference", 0, 64, seed=7)

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def body(cls, first_pass, passes, **changes):
        return {"scene": "cornell-box", "image": {"width": WIDTH, "height": HEIGHT},
                "method": {"name": "path_tracing"}, "stop": {"passes": passes}, "first_pass": first_pass, **changes}

    @classmethod
    def render(cls, name, first_pass, passes, **changes):
        request = cls.body(first_pass, passes, **changes)
        scene = request["scene"]
        cls.worker.send(type="render", job=name, attempt=1, request=request,
                        scene={"id": scene, "builtin": scene, "root": None, "file": None}, environment=None,
                        film=cls.path(name + ".film"), limits={"memory_bytes": 1 << 30, "threads": 2}, resume=None,
                        reference=None, streams="job", save_seconds=None)
        finished, _ = cls.worker.wait_for("finished")
        assert finished["state"] == "succeeded", finished
        return finished

    def result(self, task, **fields):
        reply = self.helper.ask(task, **fields)
        self.assertIsNone(reply["failure"], reply)
        return reply["result"]

    def failure(self, task, **fields):
        reply = self.helper.ask(task, **fields)
        self.assertIsNone(reply["result"], reply)
        return reply["failure"]

    def pixels(self, name):
        out = self.path(name + ".exr")
        self.result("encode_exr", film=self.path(name + ".film"), statistics=None, precision="float", out=out)
        return read_image(out)

    def pair(self):
        return {"image": {"film": self.whole["film"]}, "reference": {"film": self.reference["film"]}}

    def test_figures_are_those_of_the_pixels(self):
        names = ["rmse", "relative_mse", "mae", "bias", "indirect:rmse", "flip_ldr", "percentiles"]
        found = self.result("measure", metrics=names, **self.pair())
        image, reference = self.pixels("whole"), self.pixels("reference")
        x, r = (rgb(channels).astype("f8") for channels in (image, reference))
        weight = r * r + 0.01 * r.mean() ** 2
        metrics = found["metrics"]
        self.assertAlmostEqual(metrics["rmse"], numpy.sqrt(((x - r) ** 2).mean()), delta=1e-6)
        self.assertAlmostEqual(metrics["relative_mse"] / ((x - r) ** 2 / weight).mean(), 1, delta=1e-5)
        self.assertAlmostEqual(metrics["mae"], abs(x - r).mean(), delta=1e-6)
        numpy.testing.assert_allclose(metrics["bias"], (x - r).mean(axis=(0, 1)), atol=1e-7)
        indirect = rgb(image, "indirect.").astype("f8") - rgb(reference, "indirect.")
        self.assertAlmostEqual(metrics["indirect:rmse"], numpy.sqrt((indirect ** 2).mean()), delta=1e-6)
        errors = numpy.sqrt(((x - r) ** 2 / weight).mean(axis=2))
        self.assertAlmostEqual(metrics["percentiles"]["100"], errors.max(), delta=1e-6)
        self.assertTrue(0 < metrics["flip_ldr"] < 1)
        self.assertEqual(set(metrics), set(names))
        self.assertGreater(found["reference_error"]["rmse"], 0)  # of 64 passes: known to be there

    def test_the_difference_is_that_of_the_images_bit_for_bit(self):
        self.result("encode_difference", out=self.path("d.exr"), **self.pair())
        difference = read_image(self.path("d.exr"))
        image, reference = self.pixels("whole"), self.pixels("reference")
        self.assertEqual(set(difference), {*"RGB"} | {f"{layer}.{c}" for layer in ("emitted", "direct", "indirect")
                                                      for c in "RGB"})
        for name, values in difference.items():
            numpy.testing.assert_array_equal(values, image[name] - reference[name], name)
        # An image that was written out is measured like the film it is of.
        uploaded = {"image": {"image": self.path("whole.exr")}, "reference": {"image": self.path("reference.exr")}}
        names = ["rmse", "flip_hdr", "direct:smape"]
        self.assertEqual(self.result("measure", metrics=names, **uploaded)["metrics"],
                         self.result("measure", metrics=names, **self.pair())["metrics"])

    def test_maps_are_pictures_of_the_same_size(self):
        out = self.path("map.png")
        same = {"image": {"film": self.whole["film"]}, "reference": {"film": self.whole["film"]}, "layer": "beauty"}
        for task, extra in (("encode_flip", {"range": "hdr"}), ("encode_error_map", {})):
            with self.subTest(task):
                self.result(task, out=out, **same, **extra)
                flat = rgb(read_image(out, "uint8"))
                self.assertEqual(flat.shape, (HEIGHT, WIDTH, 3))
                self.assertEqual(len(numpy.unique(flat.reshape(-1, 3), axis=0)), 1, "equal images: one colour")
                self.result(task, out=out, **{**self.pair(), "layer": "indirect"}, **extra)
                shown = rgb(read_image(out, "uint8")).astype("f8")
                self.assertGreater(shown.mean(), flat.mean())  # that colour is the darkest

    def merge(self, names):
        return dict(films=[self.path(name + ".film") for name in names], job_request=self.body(0, PASSES),
                    scene_id="cornell-box", out=self.path("joined.film"))

    def test_any_cut_is_the_whole(self):
        cuts = {1: [0, 16], 2: [0, 5, 16], 3: [0, 7, 8, 16], 7: [0, 1, 4, 6, 9, 11, 15, 16], 16: list(range(17))}
        for count, bounds in cuts.items():
            with self.subTest(count):
                names = []
                for first, end in zip(bounds, bounds[1:]):
                    names.append(f"part_{first}_{end}")
                    self.render(names[-1], first, end - first)
                joined = self.result("merge_films", **self.merge(names[::-1]))
                self.assertEqual(joined["pixel_hash"], self.whole["statistics"]["pixel_hash"])
                self.assertEqual(joined["passes_done"], PASSES)
                self.assertEqual(joined["statistics"]["counts"], self.whole["statistics"]["counts"])
                self.assertEqual(set(joined["statistics"]), set(self.whole["statistics"]))
                for name, values in self.pixels("joined").items():
                    numpy.testing.assert_array_equal(values, self.pixels("whole")[name])

    def test_what_does_not_belong_together_is_refused_by_name(self):
        self.render("first", 0, 2)
        self.render("other_scene", 2, 2, scene="cornell-box-glass")
        self.render("other_seed", 2, 2, seed=2)
        self.render("overlap", 1, 2)
        for other, named in (("other_scene", "scene"), ("other_seed", "settings"), ("overlap", "pass 1")):
            with self.subTest(other):
                failure = self.failure("merge_films", **self.merge(["first", other]))
                self.assertEqual((failure["code"], failure["errors"][0]["pointer"]), ("conflict", "/films/1"))
                self.assertIn(named, failure["detail"])
        with open(self.path("overlap.film"), "rb") as file:
            data = bytearray(file.read())
        data[len(data) // 2] ^= 1
        with open(self.path("damaged.film"), "wb") as file:
            file.write(data)
        self.assertIn("damaged", self.failure("merge_films", **self.merge(["damaged", "first"]))["detail"])
        self.assertFalse(os.path.exists(self.path("joined.film.part")))


if __name__ == "__main__":
    unittest.main()
