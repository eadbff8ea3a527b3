"""`photonctl compare --preset svo-thesis`, small: Table 5.1 and the claims of the thesis by one command, on scenes that stand
in for its own, and on files where they lie.
"""

import json
import re
import struct
import unittest

import tiny_scene
from photonctl_case import OK, USAGE, Case, cli, json_lines

PRESET = ["compare", "--preset", "svo-thesis"]
SMALL = ["--width", 32, "--height", 18, "--passes", 1, "--reference-passes", 2]
STAND_INS = {"cornell": "cornell-box-spot", "cornell-frames": "cornell-box-spot", "sponza": "interior",
             "sponza-bounces": "interior"}
PARTS = [*STAND_INS, "sponza-alternate", "sponza-balcony", "sponza-alcove"]
THESIS = {"visibility": "svo", "vpl_choice": "interleaved", "interleave": 4, "filter": 8, "direct": "shadow_maps",
          "repay": False, "narrow_lobes": False}
CAMERAS = ["CameraMain", "CameraAlternate", "CameraBalcony", "CameraAlcove"]


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


def scene_with_cameras(names):
    """A lit triangle seen from the same place by cameras of these names, as a .glb."""
    document, binary = tiny_scene.triangle()
    document["cameras"] = [{**document["cameras"][0], "name": name} for name in names]
    document["nodes"] = [document["nodes"][0]] + [{**document["nodes"][1], "name": name, "camera": i}
                                                  for i, name in enumerate(names)]
    document["scenes"][0]["nodes"] = list(range(len(document["nodes"])))
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def parameters_of(report):
    return {entry["label"]: entry["method"]["parameters"] for entry in report["request"]["entries"]}


def pixel_hash(job):
    return cli.daemon.request("GET", f"/v1/jobs/{job}").json["statistics"]["pixel_hash"]


class StandInsTest(Case):
    """All of it on the built-in scenes, run once."""

    @classmethod
    def setUpClass(cls):
        result = cli.run(*PRESET, "--builtin", *SMALL, "-o", "svo.html", "--json-report", "svo.json")
        cls.output, cls.messages, cls.code = result.stdout, result.stderr, result.returncode
        cls.reports = {part: json.loads((cli.folder / f"svo-{part}.json").read_text())
                       for part in STAND_INS} if cls.code == OK else {}

    def setUp(self):
        self.assertEqual(self.code, OK, self.messages)

    def test_each_part_has_a_report_of_its_scene(self):
        for part, scene in STAND_INS.items():
            request = self.reports[part]["request"]
            self.assertEqual(request["scene"], scene)
            self.assertEqual((request["image"]["width"], request["image"]["height"]), (32, 18))
            self.assertEqual(request["stop"]["passes"], 1)
            self.assertIn("indirect:relative_mse", request["metrics"])
            self.assertTrue((cli.folder / f"svo-{part}.html").exists())
            self.assertIn(f"{part}: {scene} stands in for ", self.messages)
        for part in set(PARTS) - set(STAND_INS):
            self.assertIn(f"{part}: nothing stands in for sponza_crytek.glb", self.messages)
            self.assertFalse((cli.folder / f"svo-{part}.html").exists())

    def test_the_thesis_keeps_to_its_settings(self):
        for part, report in self.reports.items():
            thesis = parameters_of(report)["thesis"]
            self.assertEqual({name: thesis[name] for name in THESIS}, THESIS)
            self.assertEqual(thesis["voxel_resolution"], 128 if part.startswith("cornell") else 256)
        for part in ("cornell", "sponza"):
            parameters = parameters_of(self.reports[part])
            self.assertEqual(set(parameters), {"thesis", "ours", "photon splatting", "photon mapping", "path tracing"})
            self.assertEqual((parameters["ours"]["visibility"], parameters["ours"]["vpl_choice"], parameters["ours"]["repay"]),
                             ("rays", "resampled", True))
            rows = [row["parameters"] for row in self.reports[part]["table"] if row["label"] == "thesis"]
            self.assertEqual(rows, [{"vpls": 512}, {"vpls": 1024}, {"vpls": 2048}])
            reference = self.reports[part]["request"]["reference"]
            self.assertEqual((reference["method"]["name"], reference["method"]["parameters"]["indirect_bounces"]),
                             ("path_tracing", 1))
            self.assertEqual(reference["stop"]["passes"], 2)

    def test_frames_are_compared_with_a_frame(self):
        report = self.reports["cornell-frames"]
        reference = cli.daemon.request("GET", f"/v1/jobs/{report['request']['reference'].removeprefix('job:')}").json["request"]
        parameters = reference["method"]["parameters"]
        self.assertEqual((parameters["vpls"], parameters["voxel_resolution"]), (2048, 128))
        self.assertEqual(reference["stop"]["passes"], 1)
        self.assertEqual(report["request"]["stop"]["passes"], 1)
        self.assertEqual([reference["seed"]], report["request"]["seeds"])
        self.assertEqual(parameters_of(report)["256^3 voxels"], {**parameters, "voxel_resolution": 256})

    def test_frames_differ_by_what_their_methods_differ_in(self):
        """With the reference's own settings nothing does: all have the same rays from the eye."""
        [comparison] = json_lines(self.run_ok(
            *PRESET, "--builtin", "--part", "cornell-frames", "--width", 16, "--height", 16, "--seconds", 3, "--seeds", 7,
            "--json", "--sweep", "thesis:vpls=2048"))
        pixels = {job["parameters"].get("vpls"): pixel_hash(job["id"]) for job in comparison["jobs"]}
        reference = pixel_hash(comparison["request"]["reference"].removeprefix("job:"))
        self.assertEqual(pixels[2048], reference)
        self.assertNotIn(reference, (pixels[512], pixels[1024], pixels[None]))
        self.assertEqual(comparison["request"]["stop"]["passes"], 1)

    def test_one_two_and_three_bounces(self):
        report = self.reports["sponza-bounces"]
        self.assertNotIn(report["request"]["reference"]["method"]["parameters"].get("indirect_bounces"), (0, 1, 2, 3))
        self.assertEqual([(row["label"], row["parameters"]) for row in report["table"]],
                         [(label, {"bounces": bounces}) for label in ("thesis", "ours") for bounces in (1, 2, 3)])
        self.assertEqual(parameters_of(report)["thesis"]["bounce_tracing"], "voxels")

    def test_table_5_1_stands_beside_ours(self):
        self.assertEqual(self.output.count("Table 5.1 of the thesis"), 2)  # both scenes
        number = r"[\d.e-]+"
        for stage, stages, there in (
                ("scene voxelization and SVO generation, once", r"voxelise \+ svo_build", ("0.57", "0.57", "0.58")),
                ("RSM rendering", "rsm", ("0.61", "0.62", "0.62")),
                ("VPL generation", "vpl_generation", ("0.02", "0.02", "0.02")),
                ("direct illumination", "direct", ("0.17", "0.17", "0.18")),
                ("indirect illumination", "indirect", ("19.5", "36.2", "73"))):
            figures = "".join(rf" +{re.escape(ms)} +{number}" for ms in there)
            self.assertRegex(self.output, rf"(?m)^ +{re.escape(stage)} +{stages}{figures}$")
        self.assertRegex(self.output, rf"(?m)^ +merge, filter +merge \+ filter(?: +- +{number}){{3}}$")


class StagesTest(Case):
    def test_times_are_those_of_a_pass(self):
        """What the table says of a row is what its job's statistics say, over its passes; what is built once, is not."""
        result = self.run_ok(*PRESET, "--builtin", "--part", "cornell", "--width", 24, "--height", 24, "--passes", 3,
                             "--reference-passes", 1)
        jobs = cli.daemon.request("GET", "/v1/jobs?limit=20").json["items"]
        of_vpls = {}
        for item in jobs:
            job = cli.daemon.request("GET", f"/v1/jobs/{item['id']}").json
            if job["request"]["image"]["width"] == 24 and job["request"]["method"]["name"] == "svo_many_lights" and \
                    job["request"]["method"]["parameters"]["filter"] == 8:
                of_vpls[job["request"]["method"]["parameters"]["vpls"]] = {
                    stage["name"]: stage["wall_seconds"] * 1000 for stage in job["statistics"]["stages"]}
        self.assertEqual(set(of_vpls), {512, 1024, 2048})
        for line, stage, passes in (("indirect illumination", "indirect", 3), ("scene voxelization", "svo_build", 1)):
            [cells] = re.findall(rf"(?m)^ +{line}.*{stage} +(.*)$", result.stdout)
            ours = [float(cell) for cell in cells.split()[1::2]]
            for vpls, measured in zip((512, 1024, 2048), ours):
                self.assertAlmostEqual(measured, of_vpls[vpls][stage] / passes, delta=0.006 * measured)


class FilesTest(Case):
    """Scenes that do not come with the program."""

    @classmethod
    def setUpClass(cls):
        cls.folder = cli.folder / "scenes"
        cls.folder.mkdir()
        (cls.folder / "sponza_crytek.glb").write_bytes(scene_with_cameras(CAMERAS))

    def test_each_camera_is_a_part(self):
        for part, camera in (("sponza", "CameraMain"), ("sponza-alcove", "CameraAlcove")):
            [comparison] = json_lines(self.run_ok(*PRESET, "--scene-folder", self.folder, "--part", part, *SMALL, "--json"))
            self.assertEqual(comparison["request"]["camera"]["name"], camera)
            scene = cli.daemon.request("GET", f"/v1/scenes/{comparison['request']['scene']}").json
            self.assertEqual(scene["name"], "sponza_crytek")

    def test_a_missing_file_is_named_before_anything_is_rendered(self):
        before = len(cli.daemon.request("GET", "/v1/jobs?limit=1000").json["items"])
        result = self.run_for(USAGE, *PRESET, *SMALL, "--scene-folder", self.folder)
        self.assertIn(f"cornell_dragon_buddha.glb: not in {self.folder}", result.stderr)
        self.assertNotIn("sponza_crytek.glb", result.stderr)
        self.assertIn("--builtin", result.stderr)
        result = self.run_for(USAGE, *PRESET, *SMALL)
        self.assertIn(f"cornell_dragon_buddha.glb and sponza_crytek.glb: not in {cli.folder}", result.stderr)
        self.assertEqual(len(cli.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]), before)

    def test_a_scene_of_the_callers(self):
        [comparison] = json_lines(self.run_ok(*PRESET, "furnace", "--part", "cornell-frames", "--width", 8, "--height", 6,
                                              "--json"))
        self.assertEqual(comparison["request"]["scene"], "furnace")
        self.assertEqual(comparison["request"]["stop"]["passes"], 1)


class OptionsTest(Case):
    def test_it_is_listed(self):
        self.assertIn("svo-thesis: Table 5.1", self.run_for(USAGE, "compare", "--preset", "help").stderr)

    def test_parts_are_listed(self):
        result = self.run_for(USAGE, *PRESET, "--part", "cornel")
        for part in PARTS:
            self.assertIn(part, result.stderr)

    def test_the_reference_renders_where_the_entries_do(self):
        [comparison] = json_lines(self.run_ok(*PRESET, "furnace", *SMALL, "--device", "cpu", "--json"))
        self.assertEqual(comparison["request"]["reference"]["method"]["device"], "cpu")

    def test_what_cannot_be_meant_is_refused(self):
        for wrong in (["compare", "furnace", "--builtin", "--entry", "path_tracing", "--passes", 1],
                      ["compare", "furnace", "--part", "cornell", "--entry", "path_tracing", "--passes", 1],
                      ["compare", "furnace", "--scene-folder", ".", "--entry", "path_tracing", "--passes", 1],
                      [*PRESET, "--builtin", "--scene-folder", "."], [*PRESET, "furnace", "--builtin"],
                      [*PRESET, "furnace", "--part", "cornell,sponza"],
                      [*PRESET, "--builtin", "--part", "sponza-alcove"]):
            self.run_for(USAGE, *wrong)


if __name__ == "__main__":
    unittest.main()
