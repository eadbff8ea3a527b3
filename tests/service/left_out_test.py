"""What an image leaves out, and who is measured against a reference that lacks light it has: dry runs, jobs, comparisons,
reports and photonctl say it.
"""

import struct
import subprocess
import unittest

import tiny_scene
from photond_daemon import BIN, Daemon, small_job
from python_client_case import photond

CAUSTICS = ["delta_light_caustics", "delta_light_after_caustics"]


def quad(a, b, c, d):
    return [*a, *b, *c, *a, *c, *d]


def spot_on_a_mirror():
    """A glTF: a spot lights a tilted mirror, which lights a wall."""
    document, _ = tiny_scene.triangle()
    shapes = [quad((-2, 0, -2), (2, 0, -2), (2, 3, -2), (-2, 3, -2)),
              quad((-0.6, 1, 0.5), (0.6, 1, 0.5), (0.6, 0.5, -0.5), (-0.6, 0.5, -0.5))]
    binary = b"".join(struct.pack("<18f", *shape) for shape in shapes)
    document.update({
        "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular"],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 10, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 1.3}}]}},
        "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [{"mesh": 0}, {"mesh": 1}, {"camera": 0, "translation": [0, 1.5, 5]},
                  {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 2.8, 0],
                   "rotation": [-0.7071068, 0, 0, 0.7071068]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0},
                       "extensions": {"KHR_materials_specular": {"specularFactor": 0}}},
                      {"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i}, "material": i}]} for i in range(2)],
        "accessors": [{"bufferView": i, "componentType": 5126, "count": 6, "type": "VEC3",
                       "min": [min(shape[k::3]) for k in range(3)], "max": [max(shape[k::3]) for k in range(3)]}
                      for i, shape in enumerate(shapes)],
        "bufferViews": [{"buffer": 0, "byteOffset": 72 * i, "byteLength": 72} for i in range(2)],
        "buffers": [{"byteLength": 144}]})
    return tiny_scene.packed(document, binary)


def kinds(left_out):
    return [kind["kind"] for kind in left_out]


class LeftOutTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon("--threads", 1)
        cls.daemon.wait_ready()
        scene = cls.daemon.request("POST", "/v1/scenes", body=spot_on_a_mirror(),
                                   headers={"Content-Type": "model/gltf-binary"})
        assert scene.status == 201, scene
        cls.scene = scene.json

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def url(self):
        return f"http://{self.daemon.address}:{self.daemon.port}"

    def method(self, name, **parameters):
        return {"name": name, "parameters": parameters}

    def compare(self, reference, **query):
        body = {"scene": self.scene["id"], "image": {"width": 16, "height": 16}, "stop": {"passes": 4},
                "metrics": ["relative_mse", "direct:mse"], "reference": {"method": reference, "stop": {"passes": 8}},
                "entries": [{"label": "paths", "method": self.method("path_tracing")},
                            {"label": "photons", "method": self.method("photon_mapping", photons=2000)}]}
        answer = self.daemon.request("POST", "/v1/comparisons?dry_run=true", json_body=body)
        self.assertEqual(answer.status, 200, answer)
        made = self.daemon.request("POST", "/v1/comparisons", json_body=body)
        self.assertEqual(made.status, 202, made)
        path = f"/v1/comparisons/{made.json['id']}"
        self.daemon.wait_for_state(path, ("succeeded",))
        return answer.json, self.daemon.request("GET", path).json, self.daemon.request("GET", path + "/report.html").text

    def test_a_dry_run_and_the_job_say_the_same(self):
        self.assertIsNone(self.scene["least_glossy_alpha"])
        for name, parameters, expected in (("path_tracing", {}, CAUSTICS), ("photon_mapping", {"photons": 500}, []),
                                           ("path_tracing", {"indirect_bounces": 1}, ["further_bounces", CAUSTICS[0]]),
                                           ("path_tracing", {"indirect_bounces": 0}, ["further_bounces"])):
            job = small_job(scene=self.scene["id"], size=8)
            job["method"] = self.method(name, **parameters)
            estimate = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).json
            self.assertEqual(kinds(estimate["left_out"]), expected, (name, parameters))
            done = self.daemon.run_job(job)
            self.assertEqual(done["statistics"]["left_out"], estimate["left_out"])
            self.assertEqual([kind["most_bounces"] for kind in estimate["left_out"] if kind["kind"] == "further_bounces"],
                             [parameters["indirect_bounces"]] if parameters.get("indirect_bounces") is not None else [])

    def test_a_row_with_light_that_the_reference_lacks_is_marked(self):
        estimate, compared, report = self.compare(self.method("path_tracing"))
        paths, photons = compared["table"]
        self.assertEqual((kinds(paths["left_out"]), paths["mark"]), (CAUSTICS, None))
        self.assertEqual(photons["left_out"], [])
        self.assertTrue(photons["mark"].startswith("the reference lacks light of points, spots and suns"), photons["mark"])
        self.assertEqual(kinds(compared["reference"]["left_out"]), CAUSTICS)
        self.assertGreater(photons["error"]["relative_mse"]["value"], paths["error"]["relative_mse"]["value"])
        self.assertEqual([entry["mark"] for entry in estimate["entries"]], [None, photons["mark"]])
        self.assertIn("photons: " + photons["mark"], estimate["warnings"])
        for verdict in compared["verdicts"]:
            self.assertEqual("photons has light that the reference lacks" in verdict["text"],
                             verdict["metric"] == "relative_mse", verdict["text"])
        for headline in compared["headlines"]:
            self.assertEqual("by a reference that lacks light which photons has" in headline["text"],
                             headline["metric"] == "relative_mse", headline["text"])
        self.assertIn("photons: the reference lacks light of points", report)
        printed = subprocess.run([BIN / "photonctl", "--server", self.url(), "comparisons", "show", compared["id"]],
                                 capture_output=True, text=True, check=True).stdout
        self.assertIn("! photons: the reference lacks", printed)
        client = photond.Client(self.url())
        self.assertEqual(client.comparison(compared["id"]).marks, {"photons": photons["mark"]})
        self.assertIn(f"photons: {photons['mark']}.", str(client.comparison(compared["id"])))

    def test_a_reference_that_has_it_marks_nobody(self):
        _, compared, report = self.compare(self.method("photon_mapping", photons=2000))
        self.assertEqual([row["mark"] for row in compared["table"]], [None, None])
        self.assertEqual([kinds(row["left_out"]) for row in compared["table"]], [CAUSTICS, []])
        self.assertNotIn("reference lacks", report)
        self.assertIn("What is left out", report)

    def test_a_job_that_is_named_as_the_reference_says_it_too(self):
        judge = self.daemon.run_job(small_job(scene=self.scene["id"], size=16, passes=8))
        body = {"scene": self.scene["id"], "image": {"width": 16, "height": 16}, "stop": {"passes": 2},
                "reference": f"job:{judge['id']}",
                "entries": [{"label": "photons", "method": self.method("photon_mapping", photons=500)}]}
        made = self.daemon.request("POST", "/v1/comparisons", json_body=body)
        path = f"/v1/comparisons/{made.json['id']}"
        self.daemon.wait_for_state(path, ("succeeded",))
        self.assertTrue(self.daemon.request("GET", path).json["table"][0]["mark"])

    def test_a_merged_job_leaves_out_what_its_parts_do(self):
        parts = [self.daemon.run_job(small_job(scene=self.scene["id"], size=8, first_pass=first)) for first in (0, 1)]
        merged = self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": [part["id"] for part in parts]})
        self.assertEqual(merged.status, 201, merged)
        self.assertEqual(kinds(merged.json["statistics"]["left_out"]), CAUSTICS)

    def test_photonctl_prints_it(self):
        run = [BIN / "photonctl", "--server", self.url(), "render", self.scene["id"], "--width", "8", "--height", "8",
               "--passes", "1", "-m", "path_tracing"]
        for more in ([], ["--dry-run"]):
            printed = subprocess.run([*run, *more], capture_output=True, text=True, check=True).stdout
            self.assertRegex(printed, "left out:? +light of points, spots and suns that mirrors or smooth glass send", more)


if __name__ == "__main__":
    unittest.main()
