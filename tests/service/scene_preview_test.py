"""Quick pictures of a scene by any camera: the right view, soon once the scene is warm, and no more memory than that."""

import os
import sqlite3
import tempfile
import unittest

import numpy

import tiny_scene
from image_files import decoded_png
from photond_daemon import Daemon, processor_ticks, small_job


def view_query(view):
    points = "&".join(f"{name}={','.join(map(repr, view[name]))}" for name in ("eye", "target", "up"))
    return f"?{points}&yfov={view['yfov']!r}"


def filmic_exposure(beauty):
    """Stops that bring the log-average luminance of blocks of 8 pixels to middle grey."""
    height, width, _ = beauty.shape
    blocks = beauty.reshape(height // 8, 8, width // 8, 8, 3).mean((1, 3)) @ [0.2126, 0.7152, 0.0722]
    return float(numpy.log2(0.18 / numpy.exp(numpy.log(blocks[blocks > 1e-6]).mean())))


def roughness(picture):
    """How much a pixel differs from the mean of its four neighbours, root mean square, of 255."""
    grey = picture @ [0.2126, 0.7152, 0.0722]
    about = (grey[:-2, 1:-1] + grey[2:, 1:-1] + grey[1:-1, :-2] + grey[1:-1, 2:]) / 4
    return float(numpy.sqrt(((grey[1:-1, 1:-1] - about) ** 2).mean()))


class ScenePreviewTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        reply = cls.daemon.request("POST", "/v1/scenes?name=tiny", tiny_scene.glb(),
                                   {"Content-Type": "model/gltf-binary"})
        assert reply.status == 201, reply
        reply = cls.daemon.request("POST", "/v1/scenes?name=dark", tiny_scene.dark_glb(),
                                   {"Content-Type": "model/gltf-binary"})
        assert reply.status == 201, reply

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def scene(self, name):
        return self.daemon.request("GET", f"/v1/scenes/{name}").json

    def get(self, scene, query=""):
        return self.daemon.request("GET", f"/v1/scenes/{scene}/preview.png{query}")

    def picture(self, scene, query=""):
        reply = self.get(scene, query)
        self.assertEqual(reply.status, 200, reply)
        self.assertEqual(reply.headers["content-type"], "image/png")
        self.assertEqual(reply.headers["cache-control"], "no-store")
        return decoded_png(reply.body)

    def test_every_scene_says_where_an_orbit_begins(self):
        names = [item["name"] for item in self.daemon.request("GET", "/v1/scenes?limit=1000").json["items"]]
        self.assertIn("tiny", names)
        for name in names:
            with self.subTest(name):
                scene = self.scene(name)
                view = scene["default_view"]
                if scene["cameras"]:
                    self.assertEqual(view, scene["cameras"][0]["look_at"])
                for one in [view] + [camera["look_at"] for camera in scene["cameras"]]:
                    self.assertEqual(sorted(one), ["eye", "target", "up", "yfov"])
                    self.assertGreater(numpy.linalg.norm(numpy.subtract(one["target"], one["eye"])), 0)
                    job = small_job(name, camera={"look_at": one})
                    self.assertEqual(self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).status, 200)

    def test_a_camera_says_the_shape_of_the_image_that_its_file_asks_for(self):
        document, binary = tiny_scene.triangle(seed=3)
        document["cameras"] = [
            {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01, "aspectRatio": 2.35}},
            {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0.01, "zfar": 10}},
            {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}]
        document["nodes"] += [{"camera": 1, "name": "plan", "translation": [0.3, 0.3, 2]},
                              {"camera": 2, "name": "any", "translation": [0.3, 0.3, 2]}]
        document["scenes"] = [{"nodes": [0, 1, 2, 3]}]
        scene = self.daemon.request("POST", "/v1/scenes?name=shapes", tiny_scene.packed(document, binary),
                                    {"Content-Type": "model/gltf-binary"}).json
        self.assertEqual({camera["name"]: camera["aspect"] for camera in scene["cameras"]},
                         {"front": 2.35, "plan": 1.5, "any": None})
        self.assertEqual([camera["aspect"] for camera in self.scene("cornell-box")["cameras"]], [None])

    def test_the_target_is_as_deep_as_the_middle_of_the_bounds(self):
        scene = self.scene("cornell-box")
        view, bounds = scene["cameras"][0]["look_at"], scene["bounds"]
        axis = numpy.subtract(view["target"], view["eye"])
        middle = numpy.add(bounds["min"], bounds["max"]) / 2
        distance = numpy.linalg.norm(axis)
        self.assertAlmostEqual(distance, numpy.dot(middle - view["eye"], axis / distance), 4)
        self.assertEqual(view["yfov"], scene["cameras"][0]["yfov"])
        # Its camera is at the middle: any depth but none.
        self.assertGreater(numpy.linalg.norm(numpy.subtract(*(self.scene("furnace")["default_view"][k]
                                                              for k in ("target", "eye")))), 0.1)

    def test_a_view_shows_what_its_camera_shows(self):
        self.assertEqual(self.picture("cornell-box", "?passes=1").shape, (240, 320, 3))
        small = "&width=96&height=72&passes=1"  # which is there however slow the machine: time cuts off passes
        camera = self.picture("cornell-box", "?camera=camera" + small)
        self.assertEqual(self.get("cornell-box", "?camera=camera" + small).body,
                         self.get("cornell-box", "?" + small[1:]).body)
        view = self.scene("cornell-box")["default_view"]
        same = self.picture("cornell-box", view_query(view) + small)
        self.assertLess(numpy.abs(camera - same).mean(), 1)
        # Its left wall is red and its right wall green.
        left, right = camera[30:42, 14:18].mean((0, 1)), camera[30:42, -18:-14].mean((0, 1))
        self.assertGreater(left[0], 1.5 * left[1])
        self.assertGreater(right[1], 1.5 * right[0])
        turned = {**view, "up": [-x for x in view["up"]]}
        upside_down = self.picture("cornell-box", view_query(turned) + small)
        self.assertLess(numpy.abs(camera[::-1, ::-1] - upside_down).mean(), 0.5 * numpy.abs(camera - upside_down).mean())

    def traced(self, scene, passes, size, exposure=None):
        """A job's picture by as many paths as a preview of those passes has, unfiltered, and the exposure of its film."""
        request = small_job(scene, passes=passes, image={"width": size[0], "height": size[1]})
        request["method"]["parameters"] = {"indirect_bounces": 3}
        job = self.daemon.request("POST", "/v1/jobs", json_body=request).json
        self.daemon.wait_for_job(job["id"])
        pixels = self.daemon.request("GET", f"/v1/jobs/{job['id']}/pixels?precision=float").body
        if exposure is None:
            exposure = filmic_exposure(numpy.frombuffer(pixels, numpy.float32).reshape(size[1], size[0], 3))
        reply = self.daemon.request("GET", f"/v1/jobs/{job['id']}/preview.png?curve=filmic&exposure={exposure}")
        return decoded_png(reply.body), exposure

    def test_a_preview_is_nearer_to_the_truth_than_its_few_paths(self):
        width, height, passes = 160, 120, 2
        for scene, passes_of_truth in (("cornell-box", 96), ("cornell-box-glass", 200), ("keyhole", 96)):
            with self.subTest(scene):
                truth, exposure = self.traced(scene, passes_of_truth, (width, height))
                few, _ = self.traced(scene, passes, (width, height), exposure)
                preview = self.picture(scene, f"?width={width}&height={height}&passes={passes}")
                wrong = [float(numpy.sqrt(((picture - truth) ** 2).mean())) for picture in (few, preview)]
                rough = [roughness(picture) for picture in (few, preview, truth)]
                print(f"{scene}: error {wrong[0]:.1f} before the filter, {wrong[1]:.1f} after; "
                      f"roughness {rough[0]:.1f}, {rough[1]:.1f}, of the truth {rough[2]:.1f}")
                self.assertLess(wrong[1], 0.75 * wrong[0])
                self.assertLess(rough[1], 0.5 * rough[0])

    def test_previews_and_thumbnails_of_a_dim_room_are_without_noise(self):
        few, _ = self.traced("interior", 2, (96, 72))
        for picture in (self.picture("interior", "?width=96&height=72&passes=2"),
                        decoded_png(self.daemon.request("GET", "/v1/scenes/interior/thumbnail.png").body)):
            print(f"interior: roughness {roughness(few):.1f} before the filter, {roughness(picture):.1f} after")
            self.assertLess(roughness(picture), 0.35 * roughness(few))

    def test_a_job_shown_by_a_previews_exposure_is_as_bright(self):
        reply = self.get("cornell-box", "?width=64&height=48&passes=4")
        exposure = float(reply.headers["x-exposure-stops"])
        shown, _ = self.traced("cornell-box", 64, (64, 48), exposure)
        self.assertNotEqual(exposure, 0)
        self.assertLess(abs(shown.mean() - decoded_png(reply.body).mean()), 6)

    def test_a_job_is_not_filtered(self):
        few, exposure = self.traced("cornell-box", 1, (64, 48))
        many, _ = self.traced("cornell-box", 64, (64, 48), exposure)
        self.assertGreater(roughness(few), 2 * roughness(many))

    def test_a_scene_without_light_has_a_white_sky(self):
        dark = self.scene("dark")
        self.assertEqual(dark["lights"], {"area": 0, "punctual": 0, "environment": False})
        picture = self.picture("dark", "?width=65&height=65&passes=16")
        red, sky = picture[38:46, 20:28].mean((0, 1)), picture[0].mean(0)
        self.assertGreater(red[0], 2 * red[1])
        self.assertGreater(sky.min(), 100)
        thumbnail = self.daemon.request("GET", "/v1/scenes/dark/thumbnail.png")
        self.assertGreater(decoded_png(thumbnail.body)[0].min(), 100)

    def test_a_scene_without_cameras_has_a_framed_view(self):
        dark = self.scene("dark")
        self.assertEqual(dark["cameras"], [])
        view = dark["default_view"]
        self.assertTrue(numpy.allclose(view["target"], [0.5, 0.5, 0], atol=1e-5), view)
        same = self.picture("dark", view_query(view) + "&passes=16")
        self.assertLess(numpy.abs(same - self.picture("dark", "?passes=16")).mean(), 1)

    def test_sizes(self):
        self.assertEqual(self.picture("cornell-box", "?width=16&height=100&passes=1").shape, (100, 16, 3))
        self.assertEqual(self.picture("tiny", "?width=512&height=512&passes=1").shape, (512, 512, 3))

    def test_bad_requests_name_every_fault(self):
        for query, pointers in (("?camera=camra", ["/camera"]), ("?width=15&height=513&passes=17",
                                                                 ["/width", "/height", "/passes"]),
                                ("?passes=0", ["/passes"]), ("?eye=1,2&target=0,0,0", ["/eye"]),
                                ("?eye=1,2,x&up=1,2,3,4&yfov=wide", ["/eye", "/up", "/yfov"]),
                                ("?eye=1,2,3", ["/target"]), ("?up=0,1,0", ["/eye", "/target"]),
                                ("?eye=1,2,3&target=1,2,3", ["/target"]),
                                ("?eye=0,0,3&target=0,0,0&up=0,0,1", ["/up"]),
                                ("?eye=0,0,3&target=0,0,0&yfov=4", ["/yfov"]),
                                ("?camera=camera&eye=0,0,3&target=0,0,0", ["/camera"]), ("?pases=2", ["/pases"])):
            with self.subTest(query):
                reply = self.get("cornell-box", query)
                self.assertEqual(reply.status, 422, reply)
                self.assertEqual([error["pointer"] for error in reply.json["errors"]], pointers, reply)
        self.assertEqual(self.get("none").status, 404)

    def test_a_warm_scene_is_shown_soon_and_takes_one_scenes_memory(self):
        view = self.scene("interior")["default_view"]
        self.daemon.request("GET", "/v1/scenes?limit=1000")  # the helper has looked at all of them then
        [helper] = [worker["pid"] for worker in self.daemon.request("GET", "/v1/status").json["workers"]
                    if worker["device"] == "none"]

        def ticks_of(scene, moved_m=None):
            """What a picture takes of a processor, by the default camera or by one that has moved."""
            eye = [view["eye"][0] + (moved_m or 0), *view["eye"][1:]]
            query = "?" if moved_m is None else view_query({**view, "eye": eye}) + "&"
            before = processor_ticks(helper)
            self.assertEqual(self.get(scene, query + "passes=1&width=64&height=48").status, 200)
            return processor_ticks(helper) - before

        cold = []
        for _ in range(3):  # each takes the other's place
            ticks_of("cornell-box")
            cold.append(ticks_of("interior"))
        warm = [ticks_of("interior", 0.01 * k) for k in range(9)]
        print("ticks of cold and warm pictures:", cold, warm)
        self.assertLess(sum(warm) / len(warm), 0.5 * sum(cold) / len(cold))

    def test_nothing_is_left_on_the_disk(self):
        def files():
            return sum(len(names) for _, _, names in os.walk(self.daemon.data_dir))
        self.get("tiny")
        before = files()
        for k in range(3):
            self.picture("tiny", f"?width={64 + k}")
        self.assertEqual(files(), before)


class OldScenes(unittest.TestCase):
    def test_scenes_of_an_earlier_version_are_looked_at_again(self):
        with tempfile.TemporaryDirectory() as data:
            with Daemon(data_dir=data) as daemon:
                daemon.wait_ready()
                scene = daemon.request("POST", "/v1/scenes?name=tiny", tiny_scene.glb(),
                                       {"Content-Type": "model/gltf-binary"}).json
            [database] = [file for file in os.listdir(data) if file.endswith((".db", ".sqlite", ".sqlite3"))]
            store = sqlite3.connect(os.path.join(data, database))
            with store:
                store.execute("UPDATE scenes SET summary = json_remove(summary, '$.default_view')")
            store.close()
            with Daemon(data_dir=data) as daemon:
                daemon.wait_ready()
                [listed] = [item for item in daemon.request("GET", "/v1/scenes").json["items"]
                            if item["id"] == scene["id"]]
                self.assertIsNone(listed["default_view"])
                self.assertEqual(daemon.request("GET", f"/v1/scenes/{scene['id']}").json, scene)
                [listed] = [item for item in daemon.request("GET", "/v1/scenes").json["items"]
                            if item["id"] == scene["id"]]
                self.assertEqual(listed, scene)


if __name__ == "__main__":
    unittest.main()
