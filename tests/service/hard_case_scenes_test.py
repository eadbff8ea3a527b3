"""The hard cases as scenes of the API: listed when asked for, known by a name with a slash, rendered like any other."""

import subprocess
import unittest
import urllib.parse

from jsonschema import Draft202012Validator
from photond_daemon import BIN, Daemon

FAMILY = "/v1/scenes?family=hard-cases"
JOB = {"image": {"width": 8, "height": 8}, "method": {"name": "path_tracing", "parameters": {"indirect_bounces": 1}},
       "stop": {"passes": 2}}


class HardCaseScenesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.page = cls.daemon.request("GET", FAMILY).json
        cls.scenes = {scene["name"]: scene for scene in cls.page["items"]}

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def request(self, *arguments, **more):
        return self.daemon.request(*arguments, **more)

    def test_the_list_has_them_only_when_asked(self):
        plain = self.request("GET", "/v1/scenes").json
        self.assertIn("cornell-box", [scene["name"] for scene in plain["items"]])
        self.assertFalse([scene["name"] for scene in plain["items"] if scene["name"].startswith("hard-case/")])
        self.assertIsNone(plain["tests"])
        self.assertEqual({scene["known_answer"] for scene in plain["items"]}, {None})
        self.assertGreater(len(self.scenes), 40)
        self.assertTrue(all(name.startswith("hard-case/") for name in self.scenes))
        self.assertTrue(all(scene["builtin"] for scene in self.scenes.values()))
        unknown = self.request("GET", "/v1/scenes?family=soft-cases")
        self.assertEqual((unknown.status, unknown.json["code"]), (422, "unknown_name"), unknown)
        self.assertIn("hard-cases", unknown.json["detail"])

    def test_pages_join_to_the_whole(self):
        names, cursor = [], ""
        while cursor is not None:
            page = self.request("GET", f"{FAMILY}&limit=30{cursor and '&cursor=' + cursor}").json
            names += [scene["name"] for scene in page["items"]]
            cursor = page["next_cursor"]
        self.assertEqual(names, list(self.scenes))

    def test_answers_are_as_the_document_says(self):
        document = self.request("GET", "/v1/openapi.json").json
        Draft202012Validator({"$ref": "#/components/schemas/ScenePage",
                              "components": document["components"]}).validate(self.page)
        rows = set()
        for scene in self.scenes.values():
            answer = scene["known_answer"]
            rows.add(answer["case"])
            self.assertTrue(answer["checks"], scene["name"])
            for check in answer["checks"]:
                self.assertEqual(check["value"] is not None, check["relation"] in ("equals", "at_most"))
                self.assertEqual(check["scene"] in self.scenes, check["relation"] == "same_as")
        for test in self.page["tests"]:
            rows.add(test["known_answer"]["case"])
            self.assertEqual(test["known_answer"]["checks"], [])
            self.assertNotIn(test["name"], self.scenes)
        self.assertIn("a million passes of a constant", rows)
        self.assertGreaterEqual(len(rows), 22)

    def test_a_name_with_a_slash_is_one_part_of_a_path(self):
        for name, scene in list(self.scenes.items())[:3]:
            path = "/v1/scenes/" + urllib.parse.quote(name, safe="")
            self.assertEqual(self.request("GET", path).json, scene)
            self.assertEqual(self.request("GET", path + "/thumbnail.png").body[:4], b"\x89PNG")
            self.assertEqual(self.request("DELETE", path).status, 409)
        for path in ("hard-case%2Fno-such", "hard-case/corner-90", "hard-case%2F..%2Fcorner-90", "%2Fcorner-90",
                     "hard-case%2F", "hard-case%2Fcorner-90%2Fx", "..%2f..%2fx"):
            self.assertEqual(self.request("GET", "/v1/scenes/" + path).status, 404, path)
        self.assertEqual(self.request("GET", "/v1/jobs/hard-case%2Fcorner-90").status, 404)

    def test_jobs_take_them(self):
        job = self.daemon.wait_for_job(self.daemon.submit({**JOB, "scene": "hard-case/corner-90"})["id"])
        self.assertEqual((job["state"], job["request"]["scene"]), ("succeeded", "hard-case/corner-90"))
        listed = self.request("GET", "/v1/jobs?scene=hard-case%2Fcorner-90").json["items"]
        self.assertEqual([item["id"] for item in listed], [job["id"]])
        estimate = self.request("POST", "/v1/jobs?dry_run=true", json_body={**JOB, "scene": "hard-case/huge"})
        self.assertEqual(estimate.status, 200, estimate)
        wrong = self.request("POST", "/v1/jobs", json_body={**JOB, "scene": "hard-case/corner-9"})
        self.assertEqual(wrong.status, 422)
        self.assertIn("corner-90", wrong.json["detail"])

    def test_the_command_line_takes_them(self):
        def photonctl(*arguments):
            return subprocess.run([BIN / "photonctl", "--server", f"http://127.0.0.1:{self.daemon.port}", *arguments],
                                  capture_output=True, text=True, check=False)
        shown = photonctl("scenes", "show", "hard-case/corner-90")
        self.assertEqual(shown.returncode, 0, shown)
        self.assertIn("hard-case/corner-90", shown.stdout)
        submitted = photonctl("render", "hard-case/corner-90", "--width", "8", "--height", "8", "--passes", "1", "--no-wait")
        self.assertEqual(submitted.returncode, 0, submitted)


if __name__ == "__main__":
    unittest.main()
