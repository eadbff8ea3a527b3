"""The worker program from outside: renders, snapshots, cancels, stops, judges uploads and encodes, and survives what is
thrown at it."""

import io
import json
import os
import struct
import tempfile
import unittest
import zipfile

import numpy
import OpenImageIO as oiio

from worker_process import WorkerProcess


def read_exr(path):
    """Channels by name as (height, width) arrays of float32, and the image's attributes."""
    image = oiio.ImageInput.open(path)
    assert image, oiio.geterror()
    spec = image.spec()
    pixels = numpy.asarray(image.read_image("float")).reshape(spec.height, spec.width, spec.nchannels)
    image.close()
    return ({name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)},
            {attribute.name: attribute.value for attribute in spec.extra_attribs})


def triangle_glb(change=None):
    """A .glb of one triangle; `change` may edit the JSON before it is packed."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}]}
    if change:
        change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(positions), 0x004E4942) + positions
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


class WorkerTest(unittest.TestCase):
    kind = "cpu"

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.worker = WorkerProcess(self.kind, *self.folders())
        self.addCleanup(self.worker.close)
        self.hello, _ = self.worker.wait_for("hello")

    def folders(self):
        """That the worker may write in."""
        return [self.folder.name]

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, data):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "wb") as file:
            file.write(data)
        return self.path(name)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def order(self, job="J1", scene="cornell-box", film="J1.film", **request):
        body = {"scene": scene, "image": {"width": 32, "height": 32}, "method": {"name": "path_tracing"},
                "stop": {"passes": 4}}
        body.update(request)
        source = scene if isinstance(scene, dict) else {"id": scene, "builtin": scene, "root": None, "file": None}
        if isinstance(scene, dict):
            body["scene"] = "uploaded"
        return dict(type="render", job=job, attempt=1, request=body, scene=source, environment=None,
                    film=self.path(film), limits={"memory_bytes": 1 << 30, "threads": 2})

    def render(self, **changes):
        self.worker.send(**self.order(**changes))
        return self.worker.wait_for("finished")


class RenderWorker(WorkerTest):
    def test_says_who_it_is(self):
        self.assertEqual(self.hello["pid"], self.worker.process.pid)
        device = self.hello["device"]
        self.assertEqual((device["id"], device["kind"], device["state"]), ("cpu", "cpu", "ready"))
        self.assertGreater(device["memory_bytes"], 1 << 28)

    def test_beats_while_it_renders(self):
        self.worker.send(**self.order(stop={"seconds": 3600}))
        beat, _ = self.worker.wait_for("heartbeat")
        self.assertGreater(beat["resident_bytes"], 1 << 20)
        self.worker.wait_for("heartbeat")
        self.worker.send(type="cancel", job="J1")
        self.assertEqual(self.worker.wait_for("finished")[0]["state"], "cancelled")

    def test_renders_a_job(self):
        finished, before = self.render()
        self.assertEqual(finished["state"], "succeeded", finished)
        self.assertEqual(before[0]["type"], "started")
        self.assertEqual(finished["passes_done"], 4)
        self.assertEqual(finished["film"], self.path("J1.film"))
        self.assertTrue(os.path.exists(self.path("J1.film")))
        self.assertFalse(os.path.exists(self.path("J1.film.part")))
        statistics = finished["statistics"]
        self.assertEqual(statistics["counts"]["passes"], 4)
        self.assertEqual(len(statistics["pixel_hash"]), 64)
        self.assertTrue(finished["log"])
        again, _ = self.render(job="J2", film="J2.film")
        self.assertEqual(again["statistics"]["pixel_hash"], statistics["pixel_hash"])
        self.assertEqual(again["statistics"]["job_hash"], statistics["job_hash"])

    def test_snapshot_then_cancel(self):
        self.worker.send(**self.order(stop={"seconds": 3600}))
        self.worker.wait_for("progress")
        self.worker.send(type="snapshot", job="J1", path=self.path("so_far.film"))
        saved, _ = self.worker.wait_for("film_saved")
        self.assertEqual(saved["path"], self.path("so_far.film"))
        self.assertGreater(saved["passes_done"], 0)
        self.assertTrue(os.path.exists(saved["path"]))
        self.worker.send(type="cancel", job="another")  # is not this job's
        self.worker.send(type="snapshot", job="J1", path=self.path("later.film"))
        later, _ = self.worker.wait_for("film_saved")
        self.assertGreater(later["passes_done"], saved["passes_done"])
        self.worker.send(type="cancel", job="J1")
        finished, _ = self.worker.wait_for("finished")
        self.assertEqual(finished["state"], "cancelled")
        self.assertGreaterEqual(finished["passes_done"], later["passes_done"])
        self.assertTrue(os.path.exists(finished["film"]))
        self.assertFalse(finished["stopping"])
        self.assertEqual(self.render(job="J2", film="J2.film")[0]["state"], "succeeded")

    def test_progress_is_at_most_four_a_second(self):
        self.worker.send(**self.order(stop={"seconds": 0.6}))
        finished, before = self.worker.wait_for("finished")
        progress = [m for m in before if m["type"] == "progress"]
        self.assertGreaterEqual(finished["seconds"], 0.6)
        self.assertTrue(progress)
        # The first comes at once, the others 0.25 s apart; the film and its saving are off the clock but not for long.
        self.assertLessEqual(len(progress), 2 + 4 * (finished["seconds"] + 2))
        self.assertEqual(sorted(m["passes_done"] for m in progress), [m["passes_done"] for m in progress])
        self.assertTrue(all(0 <= m["progress"] <= 1 for m in progress))

    def test_stop_saves_and_ends(self):
        self.worker.send(**self.order(stop={"seconds": 3600}))
        self.worker.wait_for("progress")
        self.worker.send(type="stop")
        finished, before = self.worker.wait_for("finished")
        self.assertEqual((finished["state"], finished["stopping"]), ("cancelled", True))
        self.assertIn("film_saved", [m["type"] for m in before])
        self.assertTrue(os.path.exists(finished["film"]))
        self.assertEqual(self.worker.process.wait(), 0)

    def test_ends_when_the_socket_closes_in_the_middle_of_a_job(self):
        self.worker.send(**self.order(stop={"seconds": 3600}, image={"width": 1024, "height": 1024}))
        self.worker.wait_for("started")
        self.worker.socket.close()
        self.assertEqual(self.worker.process.wait(), 0)

    def test_a_message_that_is_none_ends_it(self):
        self.worker.socket.sendall(b"\x00\xff not json\n")
        self.assertEqual(self.worker.process.wait(), 0)

    def test_bad_scenes_fail_the_job_and_not_the_worker(self):
        bad = {
            "empty": b"", "noise": bytes(range(256)) * 20, "truncated": triangle_glb()[:-20],
            "index": triangle_glb(lambda d: d["nodes"][0].update(mesh=7)),
            "range": triangle_glb(lambda d: d["accessors"][0].update(count=1 << 40)),
            "required": triangle_glb(lambda d: d.update(extensionsRequired=["X_no_such"], extensionsUsed=["X_no_such"])),
            "uri": triangle_glb(lambda d: d["buffers"].append({"byteLength": 36, "uri": "../../../etc/passwd"})
                                or d["bufferViews"][0].update(buffer=1)),
            "deep": triangle_glb(lambda d: d.update(extras=json.loads("[" * 200 + "]" * 200)))}
        for name, data in bad.items():
            with self.subTest(name):
                file = self.write(f"{name}/scene.glb", data)
                scene = {"id": name, "builtin": None, "root": os.path.dirname(file), "file": file}
                finished, _ = self.render(scene=scene)
                self.assertEqual(finished["state"], "failed")
                self.assertIn(finished["failure"]["code"], ("bad_scene", "unsupported", "out_of_range"), finished)
                self.assertTrue(finished["failure"]["detail"])
                self.assertIsNone(finished["film"])
        self.assertEqual(self.render()[0]["state"], "succeeded")

    def test_a_scene_from_a_file(self):
        file = self.write("good/scene.glb", triangle_glb())
        scene = {"id": "good", "builtin": None, "root": os.path.dirname(file), "file": file}
        finished, _ = self.render(scene=scene, layers=["depth"])
        self.assertEqual(finished["state"], "succeeded", finished)
        self.assertTrue(any("1 triangles" in line for line in finished["log"]), finished["log"])

    def test_bad_requests_name_the_place(self):
        finished, _ = self.render(method={"name": "path_tracing", "parameters": {"indirect_bounces": "many"}})
        self.assertEqual(finished["state"], "failed")
        self.assertEqual(finished["failure"]["errors"][0]["pointer"], "/method/parameters/indirect_bounces")
        finished, _ = self.render(image={"width": 16000, "height": 16000})
        self.assertEqual(finished["failure"]["code"], "out_of_memory")
        self.assertIn(str(1 << 30), finished["failure"]["detail"])
        finished, _ = self.render(camera={"name": "nobody"})
        self.assertEqual(finished["failure"]["errors"][0]["pointer"], "/camera/name")


    def saved_or_finished(self):
        """The next film_saved or finished, and the passes of the curve's points told before it."""
        points = []
        while True:
            message = self.worker.receive()
            self.assertIsNotNone(message)
            if message["type"] == "curve":
                points += [point["passes"] for point in message["points"]]
            if message["type"] in ("film_saved", "finished"):
                return message, points

    def test_goes_on_where_a_killed_worker_saved_its_film(self):
        stop = {"passes": 1500}
        whole, _ = self.render(stop=stop, film="whole.film")
        order = dict(self.order(stop=stop), resume=None, save_seconds=0)
        saved_passes, saved_points = [], []
        while len(saved_passes) < 3:  # killed once its film is saved, and again in the attempts that go on from it
            self.worker.send(**order)
            message, points = self.saved_or_finished()
            if message["type"] == "finished":
                break
            self.assertEqual(message["path"], order["film"])
            self.worker.process.kill()
            self.worker.process.wait()
            self.worker.socket.close()
            saved_passes.append(message["passes_done"])
            saved_points = points
            order["resume"] = self.path(f"kept{len(saved_passes)}.film")
            os.rename(order["film"], order["resume"])
            self.worker = WorkerProcess(self.kind, *self.folders())
            self.addCleanup(self.worker.close)
            self.worker.wait_for("hello")
        self.assertTrue(saved_passes)
        self.assertEqual(sorted(set(saved_passes)), saved_passes)  # each attempt came further
        order["save_seconds"] = None
        self.worker.send(**order)
        finished, sent = self.saved_or_finished()
        self.assertEqual((finished["type"], finished["state"]), ("finished", "succeeded"), finished)
        self.assertEqual(finished["statistics"]["pixel_hash"], whole["statistics"]["pixel_hash"])
        self.assertGreaterEqual(finished["statistics"]["resumed_passes"], saved_passes[-1])
        self.assertEqual(finished["statistics"]["counts"], whole["statistics"]["counts"])
        self.assertEqual(sent, [point["passes"] for point in finished["curve"]])
        self.assertEqual(sent[:len(saved_points)], saved_points)
        self.assertTrue({1 << k for k in range(11)} | {1500} <= set(sent), sent)

    def test_measures_against_a_reference_and_stops_at_a_target(self):
        self.worker.send(**self.order(film="reference.film", stop={"passes": 64}), streams="reference")
        self.worker.wait_for("finished")
        target = {"metric": "relative_mse", "value": 0.05}
        self.worker.send(**self.order(reference="job:J9", stop={"passes": 64, "target": target}, metrics=["flip_ldr"]),
                         reference={"film": self.path("reference.film")})
        finished, before = self.worker.wait_for("finished")
        self.assertEqual(finished["state"], "succeeded", finished)
        self.assertEqual(finished["error_now"]["metric"], "relative_mse")
        self.assertEqual(finished["error_now"]["value"], finished["statistics"]["error"]["relative_mse"])
        self.assertTrue(finished["error_now"]["value"] <= 0.05 or finished["passes_done"] == 64)
        self.assertIn("curve", [m["type"] for m in before])
        for point in finished["curve"]:
            self.assertEqual(sorted(point), ["intervals", "metrics", "passes", "photons", "seconds"])
            self.assertIn("flip_ldr", point["metrics"])
        self.assertIsInstance(finished["curve"][-1]["metrics"]["flip_ldr"], float)


class Helper(WorkerTest):
    kind = "none"

    def folders(self):
        return [self.folder.name, self.films.name]

    @classmethod
    def setUpClass(cls):
        """One film for all tests of encoding, with values that half precision cannot hold left out."""
        cls.films = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.films.cleanup)
        worker = WorkerProcess("cpu", cls.films.name)
        try:
            worker.wait_for("hello")
            cls.film = os.path.join(cls.films.name, "film")
            worker.send(type="render", job="J", attempt=1,
                        request={"scene": "cornell-box", "image": {"width": 48, "height": 32},
                                 "method": {"name": "path_tracing"}, "stop": {"passes": 8},
                                 "layers": ["albedo", "normal", "depth", "standard_error"]},
                        scene={"id": "cornell-box", "builtin": "cornell-box"}, environment=None, film=cls.film,
                        limits={"memory_bytes": 1 << 30, "threads": 2})
            finished, _ = worker.wait_for("finished")
            assert finished["state"] == "succeeded", finished
            cls.statistics = finished["statistics"]
        finally:
            worker.close()

    def result(self, task, **fields):
        reply = self.worker.ask(task, **fields)
        self.assertIsNone(reply["failure"], reply)
        return reply["result"]

    def failure(self, task, **fields):
        reply = self.worker.ask(task, **fields)
        self.assertIsNone(reply["result"])
        self.assertTrue(reply["failure"]["detail"])
        return reply["failure"]

    def test_encodes_an_exr_that_another_program_reads(self):
        for precision in ("float", "half"):
            with self.subTest(precision):
                self.result("encode_exr", film=self.film, statistics=self.statistics, precision=precision,
                            out=self.path("a.exr"))
                channels, attributes = read_exr(self.path("a.exr"))
                expected = ["R", "G", "B", "depth.Z"]
                expected += [f"normal.{c}" for c in "XYZ"]
                expected += [f"{layer}.{c}" for layer in ("emitted", "direct", "indirect", "albedo", "standard_error")
                             for c in "RGB"]
                self.assertEqual(sorted(channels), sorted(expected))
                self.assertEqual(channels["R"].shape, (32, 48))
                for c in "RGB":
                    parts = channels[f"emitted.{c}"] + channels[f"direct.{c}"] + channels[f"indirect.{c}"]
                    numpy.testing.assert_allclose(channels[c], parts, rtol=1e-6 if precision == "float" else 3e-3,
                                                  atol=1e-5)
                self.assertGreater(channels["direct.G"].mean(), 0)
                self.assertGreater(channels["standard_error.G"].max(), 0)
                self.assertEqual(attributes["photond:pixel_hash"], self.statistics["pixel_hash"])
                self.assertEqual(attributes["photond:memory.accounted_bytes"],
                                 self.statistics["memory"]["accounted_bytes"])
                self.assertNotIn("DateTime", attributes)

    def test_pixels_are_the_exrs(self):
        self.result("encode_exr", film=self.film, statistics=None, precision="float", out=self.path("a.exr"))
        channels, _ = read_exr(self.path("a.exr"))
        answer = self.result("encode_pixels", film=self.film, layer="indirect", precision="float", out=self.path("p"))
        self.assertEqual((answer["width"], answer["height"], answer["channels"]), (48, 32, 3))
        pixels = numpy.fromfile(self.path("p"), "<f4").reshape(32, 48, 3)
        for i, c in enumerate("RGB"):
            numpy.testing.assert_array_equal(pixels[:, :, i], channels[f"indirect.{c}"])
        self.result("encode_pixels", film=self.film, layer="beauty", precision="half", out=self.path("p"))
        halves = numpy.fromfile(self.path("p"), "<f2").reshape(32, 48, 3)
        numpy.testing.assert_array_equal(halves[:, :, 1], channels["G"].astype("<f2"))
        self.assertEqual(self.failure("encode_pixels", film=self.film, layer="caustic", precision="half",
                                      out=self.path("p"))["code"], "unknown_name")

    def test_preview_follows_exposure(self):
        means = []
        for exposure in (0, 2):
            self.result("encode_preview", film=self.film, exposure=exposure, curve="srgb", out=self.path("p.png"))
            image = oiio.ImageInput.open(self.path("p.png"))
            self.assertEqual((image.spec().width, image.spec().height, image.spec().nchannels), (48, 32, 3))
            means.append(numpy.asarray(image.read_image("uint8")).mean())
            image.close()
        self.assertGreater(means[1], means[0])

    def test_damaged_films_are_refused(self):
        with open(self.film, "rb") as file:
            data = bytearray(file.read())
        data[len(data) // 2] ^= 1
        film = self.write("damaged/film", bytes(data))
        self.assertEqual(self.failure("encode_exr", film=film, statistics=None, precision="half",
                                      out=self.path("a.exr"))["code"], "result_damaged")
        self.assertFalse(os.path.exists(self.path("a.exr")))

    def test_judges_images(self):
        self.result("encode_exr", film=self.film, statistics=None, precision="half", out=self.path("a.exr"))
        answer = self.result("judge_image", path=self.path("a.exr"))
        layers = {layer["name"]: layer["channels"] for layer in answer.pop("layers")}
        self.assertEqual(answer, {"width": 48, "height": 32, "channels": 22})
        self.assertEqual(sum(layers.values()), 22)
        self.assertEqual({"beauty", "direct", "indirect", "emitted"} - set(layers), set())
        for data in (b"", b"\x89PNG\r\n\x1a\n", self.read("a.exr")[:500]):
            self.assertEqual(self.failure("judge_image", path=self.write("bad/i.exr", data))["code"], "bad_image")

    def test_judges_scenes(self):
        summary = self.result("judge_scene", builtin="cornell-box")
        self.assertEqual(summary["cameras"][0]["name"], "camera")
        self.assertTrue(summary["builtin"])
        self.assertGreater(summary["lights"]["area"], 0)
        file = self.write("s/scene.glb", triangle_glb())
        summary = self.result("judge_scene", root=os.path.dirname(file), file=file, name="mine")
        self.assertEqual((summary["name"], summary["triangles"], summary["vertices"]), ("mine", 1, 3))
        self.assertEqual(summary["bounds"], {"min": [0, 0, 0], "max": [1, 1, 0]})
        self.assertEqual(summary["bytes"], os.path.getsize(file))
        for field in ("materials", "textures", "animations", "needs", "warnings"):
            self.assertIn(field, summary)
        file = self.write("b/scene.glb", triangle_glb(lambda d: d["nodes"][0].update(mesh=7)))
        failure = self.failure("judge_scene", root=os.path.dirname(file), file=file, name="bad")
        self.assertEqual(failure["code"], "bad_scene")
        self.assertTrue(failure["errors"][0]["pointer"].startswith("/nodes/0"), failure)

    def test_thumbnail(self):
        self.result("thumbnail", scene={"id": "cornell-box", "builtin": "cornell-box"}, out=self.path("t.png"))
        file = self.write("s/scene.glb", triangle_glb())  # without a light: shown under a white sky
        self.result("thumbnail", scene={"id": "s", "builtin": None, "root": os.path.dirname(file), "file": file},
                    out=self.path("u.png"))
        for name in ("t.png", "u.png"):
            image = oiio.ImageInput.open(self.path(name))
            self.assertEqual((image.spec().width, image.spec().height), (256, 192))
            pixels = numpy.asarray(image.read_image("uint8"))
            image.close()
            self.assertGreater(pixels.max() - pixels.min(), 50, name)

    # --- ZIP archives

    def zipped(self, entries, **options):
        data = io.BytesIO()
        with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in entries:
                archive.writestr(name, content, **options)
        return self.write("upload.zip", data.getvalue())

    def root(self):
        return tempfile.mkdtemp(dir=self.folder.name)

    def test_unpacks_a_bundle(self):
        root = self.root()
        archive = self.zipped([("bundle/scene.gltf", b"{}"), ("bundle/data/a.bin", b"x" * 5000), ("bundle/old/b.glb", b"y")])
        answer = self.result("unpack", zip=archive, root=root)
        self.assertEqual(answer["file"], os.path.join(root, "bundle/scene.gltf"))
        with open(os.path.join(root, "bundle/data/a.bin"), "rb") as file:
            self.assertEqual(file.read(), b"x" * 5000)

    def test_refuses_names_that_leave_the_folder(self):
        for name in ("../evil", "a/../../evil", "/etc/evil", "a//b", "./a", "a/./b", "a\\b", "c:evil", "a\nb",
                     "..", "x" * 300, "a/" * 40 + "b"):
            with self.subTest(name):
                root = self.root()
                archive = self.zipped([("scene.glb", b"x"), (name, b"evil")])
                self.assertEqual(self.failure("unpack", zip=archive, root=root)["code"], "bad_scene")
                self.assertEqual(os.listdir(root), [])

    def test_refuses_what_is_no_plain_file(self):
        link = zipfile.ZipInfo("link.bin")
        link.create_system, link.external_attr = 3, 0o120777 << 16
        fifo = zipfile.ZipInfo("fifo.bin")
        fifo.create_system, fifo.external_attr = 3, 0o010644 << 16
        for entry in (link, fifo):
            archive = self.zipped([("scene.glb", b"x"), (entry, b"/etc/passwd")])
            self.assertEqual(self.failure("unpack", zip=archive, root=self.root())["code"], "bad_scene")

    def test_refuses_bombs_and_lies(self):
        bomb = self.zipped([("scene.glb", b"\0" * (64 << 20))])
        root = self.root()
        self.assertIn("ratio", self.failure("unpack", zip=bomb, root=root)["detail"])
        self.assertEqual(os.listdir(root), [])
        # An archive that states a smaller size than it holds: the size fields of header and directory are changed.
        honest = self.read(self.zipped([("scene.glb", os.urandom(100000))]))
        lying = honest.replace(struct.pack("<I", 100000), struct.pack("<I", 50000))
        self.assertNotEqual(honest, lying)
        self.failure("unpack", zip=self.write("lying.zip", lying), root=self.root())
        broken = bytearray(honest)
        broken[5000] ^= 0xff
        self.failure("unpack", zip=self.write("broken.zip", bytes(broken)), root=self.root())
        many = self.zipped([(f"f{i}", b"") for i in range(10001)])
        self.assertIn("entries", self.failure("unpack", zip=many, root=self.root())["detail"])

    def test_refuses_archives_without_exactly_one_scene(self):
        for entries in ([], [("a.txt", b"x")], [("a.gltf", b"x"), ("b.GLB", b"y")], [("a/s.glb", b"x"), ("b/s.glb", b"y")]):
            archive = self.zipped(entries)
            self.assertEqual(self.failure("unpack", zip=archive, root=self.root())["code"], "bad_scene")
        self.assertEqual(self.failure("unpack", zip=self.write("n.zip", b"no archive"), root=self.root())["code"],
                         "bad_scene")

    def test_two_entries_of_one_name(self):
        import warnings
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            archive = self.zipped([("scene.glb", b"x"), ("scene.glb", b"y")])
        self.assertEqual(self.failure("unpack", zip=archive, root=self.root())["code"], "bad_scene")

    def test_unknown_tasks_and_missing_fields(self):
        self.assertEqual(self.failure("dance")["code"], "unknown_name")
        self.assertEqual(self.failure("judge_image")["code"], "missing_field")
        self.worker.send(type="stop")
        self.assertEqual(self.worker.process.wait(), 0)


del WorkerTest  # a base, not a test case
if __name__ == "__main__":
    unittest.main()
