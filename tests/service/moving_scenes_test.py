"""Jobs at moments of a scene's animations: what a scene says of them, how a job names one, and that a frame follows from its
moment alone, whatever the worker showed before.
"""

import json
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import tiny_scene
from photond_daemon import DaemonTestCase, small_job


def moving_triangle():
    """The lit triangle, which the animation "slide" moves and "hold" leaves where it is."""
    document, binary = tiny_scene.triangle(7)
    first = len(document["accessors"])
    for data, kind, count in ((struct.pack("<2f", 0, 2), "SCALAR", 2), (struct.pack("<6f", 0, 0, 0, 0.5, 0, 0), "VEC3", 2),
                              (struct.pack("<6f", *[0] * 6), "VEC3", 2)):
        binary += bytes(-len(binary) % 4)
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126, "count": count,
                                      "type": kind})
        binary += data
    document["buffers"][0]["byteLength"] = len(binary)
    document["animations"] = [
        {"name": name, "samplers": [{"input": first, "output": output}],
         "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}
        for name, output in (("slide", first + 1), ("hold", first + 2))]
    return tiny_scene.packed(document, binary)


class MovingScenesTest(DaemonTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        answer = cls.daemon.request("POST", "/v1/scenes?name=slider", body=moving_triangle(),
                                    headers={"Content-Type": "model/gltf-binary"})
        assert answer.status == 201, answer
        cls.scene = answer.json

    def picture(self, scene="slider", **moment):
        job = self.daemon.run_job(small_job(scene=scene, passes=2, **moment))
        self.assertEqual(job["state"], "succeeded", job)
        return job["statistics"]["pixel_hash"]

    def refusal(self, **moment):
        answer = self.daemon.request("POST", "/v1/jobs", json_body=small_job(**{"scene": "slider", **moment}))
        self.assertEqual(answer.status, 422, answer)
        return answer.json

    def test_a_scene_lists_its_animations_and_what_they_move(self):
        self.assertEqual(self.scene["animations"], 2)
        slide, hold = self.scene["motion"]
        self.assertEqual((slide["index"], slide["name"], slide["duration_seconds"]), (0, "slide", 2))
        self.assertEqual(slide["moves"], {"meshes": 1, "triangles": 1, "cameras": 0, "lights": 0, "materials": 0})
        self.assertEqual(hold["name"], "hold")
        box = self.daemon.request("GET", "/v1/scenes/moving%2Fcornell-box").json
        self.assertEqual(box["motion"][0]["moves"]["cameras"], 1)
        self.assertEqual(self.daemon.request("GET", "/v1/scenes/cornell-box").json["motion"], [])
        family = self.daemon.request("GET", "/v1/scenes?family=moving").json["items"]
        self.assertEqual(len(family), 6)

    def test_a_job_shows_its_moment(self):
        rest, start = self.picture(), self.picture(animation="slide", time=0)
        moved = self.picture(animation="slide", time=1)
        self.assertEqual(rest, start)
        self.assertNotEqual(moved, rest)
        self.assertEqual(self.picture(animation=0, time=1), moved, "by its index")
        self.assertEqual(self.picture(time=1), moved, "a time alone is of the first")
        self.assertEqual(self.picture(animation="hold", time=1), rest)
        self.assertEqual(self.picture(animation="slide", time=2), self.picture(animation="slide", time=99))
        self.assertEqual(self.picture(animation="slide", time=-1), rest)
        self.assertEqual(self.picture(), rest, "at rest again")

    def test_a_request_says_what_it_shows(self):
        job = self.daemon.submit(small_job(scene="slider", time=1.5))
        self.assertEqual((job["request"]["animation"], job["request"]["time"]), (0, 1.5))
        again = self.daemon.submit(job["request"])
        self.assertEqual(again["request"], job["request"])
        still = self.daemon.submit(small_job(scene="slider"))
        self.assertEqual((still["request"]["animation"], still["request"]["time"]), (None, 0))

    def test_what_is_not_there_is_refused_with_its_place(self):
        for moment, detail in (({"animation": "slid"}, 'did you mean "slide"?'),
                               ({"animation": 2}, "2 is the index of none"),
                               ({"scene": "cornell-box", "time": 1}, "the scene has no animations"),
                               ({"animation": -1}, "outside"), ({"animation": {}}, ""), ({"time": "soon"}, "")):
            with self.subTest(moment=moment):
                problem = self.refusal(**moment)
                places = [fault["pointer"] for fault in problem["errors"]]
                self.assertEqual(places, ["/time" if moment.get("time") == "soon" else "/animation"], problem)
                self.assertIn(detail, json.dumps(problem["errors"], ensure_ascii=False).replace('\\"', '"'))

    def test_a_figure_walks_below_a_lamp_that_were_added_to_a_scene(self):
        tool = Path(__file__).resolve().parents[1] / "benchmarks" / "moving_sponza.py"
        with tempfile.TemporaryDirectory() as folder:
            before, after = Path(folder) / "before.glb", Path(folder) / "after.glb"
            before.write_bytes(tiny_scene.glb(3))
            subprocess.run([sys.executable, tool, before, after], check=True)
            body = after.read_bytes()
        answer = self.daemon.request("POST", "/v1/scenes?name=walk", body=body, headers={"Content-Type": "model/gltf-binary"})
        self.assertEqual((answer.status, answer.json["warnings"]), (201, []), answer)
        [walk] = answer.json["motion"]
        self.assertAlmostEqual(walk["duration_seconds"], 3.7, places=5)
        self.assertEqual((walk["moves"]["meshes"], walk["moves"]["lights"]), (4, 1))  # shirt, skin, trousers, rod
        view = {"camera": {"name": "CameraWalk"}, "animation": 0}
        pictures = {self.picture("walk", time=time, **view) for time in (0, 0.25, 1)}
        self.assertEqual(len(pictures), 3)

    def test_an_open_shutter_shows_many_moments(self):
        still = self.picture(animation="slide", time=0.5)
        blurred = self.picture(animation="slide", time=0.5, shutter=1)
        self.assertNotEqual(blurred, still)
        self.assertEqual(self.picture(animation="slide", time=0.5, shutter=1), blurred)
        self.assertEqual(self.picture(animation="hold", time=0.5, shutter=1), self.picture())
        self.assertEqual(self.picture(animation="slide", time=0.5), still)

    def test_passes_that_build_on_those_before_show_one_moment(self):
        answer = self.daemon.request("POST", "/v1/jobs", json_body=small_job(
            scene="slider", method="progressive_photon_mapping", animation=0, shutter=1))
        self.assertEqual((answer.status, answer.json["errors"][0]["pointer"]), (422, "/shutter"), answer)

    def test_comparisons_take_a_moment(self):
        body = {"scene": "slider", "animation": "slide", "time": 1, "image": {"width": 16, "height": 16},
                "stop": {"passes": 1}, "entries": [{"method": {"name": "path_tracing"}}],
                "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 4}}}
        comparison = self.daemon.request("POST", "/v1/comparisons", json_body=body)
        self.assertEqual(comparison.status, 202, comparison)
        job = self.daemon.wait_for_job(comparison.json["jobs"][0]["id"])
        self.assertEqual((job["state"], job["request"]["animation"], job["request"]["time"]), ("succeeded", "slide", 1))


if __name__ == "__main__":
    unittest.main()
