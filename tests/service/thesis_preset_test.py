"""`photonctl compare --preset photon-splatting-thesis`, small: the thesis' experiment by one command, its figures as scenes,
and the heat map of overlapping splats.
"""

import json
import unittest

import numpy
import OpenImageIO as oiio

from photonctl_case import OK, REFUSED, USAGE, Case, cli, json_lines

PRESET = ["compare", "--preset", "photon-splatting-thesis"]
SMALL = ["--width", 48, "--height", 27, "--passes", 1, "--reference-passes", 2]
ENTRIES = ("photon mapping", "photon mapping (many bounces)", "small splats", "large splats", "stratified", "ours")
METRICS = ["indirect:relative_mse", "indirect:fitted_relative_mse", "indirect:rmse", "indirect:fitted_rmse", "rmse_8bit"]


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


class PresetTest(Case):
    """All of it, run once on both scenes."""

    @classmethod
    def setUpClass(cls):
        result = cli.run(*PRESET, *SMALL, "-o", "thesis.html", "--json-report", "thesis.json")
        cls.output, cls.messages, cls.code = result.stdout, result.stderr, result.returncode
        cls.reports = {scene: json.loads((cli.folder / f"thesis-{scene}.json").read_text())
                       for scene in ("cornell-box-spot", "interior")} if cls.code == OK else {}

    def setUp(self):
        self.assertEqual(self.code, OK, self.messages)

    def test_each_scene_has_a_report_of_every_entry(self):
        for scene, report in self.reports.items():
            request = report["request"]
            self.assertEqual(request["scene"], scene)
            self.assertEqual({entry["label"] for entry in request["entries"]}, set(ENTRIES))
            self.assertEqual(request["metrics"], METRICS)
            self.assertEqual((request["image"]["width"], request["image"]["height"]), (48, 27))
            self.assertEqual(request["stop"], {**request["stop"], "passes": 1})
            self.assertEqual(request["reference"]["method"]["parameters"]["indirect_bounces"], 1)
            self.assertEqual(request["reference"]["stop"]["passes"], 2)
            page = (cli.folder / f"thesis-{scene}.html").read_text()
            self.assertIn("Memory by structure", page)
            self.assertIn("<th>global_map</th>", page)

    def test_splats_keep_to_the_thesis(self):
        entries = {entry["label"]: entry["method"]["parameters"]
                   for entry in self.reports["interior"]["request"]["entries"]}
        self.assertAlmostEqual(entries["large splats"]["splat_size_relative"], 3 * entries["small splats"]["splat_size_relative"],
                               places=6)
        self.assertEqual({entries[label]["weighting"] for label in ("small splats", "large splats", "stratified")}, {"normalised"})
        self.assertEqual(entries["photon mapping"]["indirect_bounces"], 1)
        self.assertNotIn(entries["photon mapping (many bounces)"].get("indirect_bounces"), (0, 1))

    def test_what_the_fit_can_do_it_does(self):
        """An exposure never makes an image worse, and normalised splats need one."""
        rows = self.reports["cornell-box-spot"]["table"]
        for row in rows:
            # The references' noise is in what is fitted, and not in the other.
            raw = row["error"]["indirect:rmse"]
            fitted = row["error"]["indirect:fitted_rmse"]["value"]
            self.assertLessEqual(fitted ** 2, (raw["value"] ** 2 + raw["reference"] ** 2) * (1 + 1e-5), row["label"])
        splats = next(row for row in rows if row["label"] == "small splats" and row["parameters"]["photons"] == 25000)
        self.assertLess(splats["error"]["indirect:fitted_relative_mse"]["value"],
                        splats["error"]["indirect:relative_mse"]["value"])

    def test_table_1_stands_beside_ours(self):
        for published in ("1.71 MB", "0.85 MB", "0.08 MB", "576 MB"):
            self.assertEqual(self.output.count(published), 2, self.output)  # one a scene
        self.assertRegex(self.output, r"(?m)^ +photon mapping, .*photons 50000.*1\.71 MB +[\d.]+ [kM]B +global_map$")
        self.assertRegex(self.output, r"(?m)^ +stratified.*grid_cells \d+.* +[\d.]+ [kM]B +photons \+ stratification$")
        self.assertRegex(self.output, r"(?m)^ +each +.*pass_image [\d.]+ [kM]B")


class OptionsTest(Case):
    def test_presets_are_listed(self):
        for name in ("help", "photon-spalting"):
            result = self.run_for(USAGE, "compare", "--preset", name)
            self.assertIn("photon-splatting-thesis: Graphs 1-4", result.stderr)

    def test_one_scene_of_the_callers_and_its_own_metrics(self):
        [comparison] = json_lines(self.run_ok(*PRESET, "furnace", "--width", 8, "--height", 6, "--passes", 1,
                                              "--reference-passes", 1, "--metrics", "indirect:fitted_rmse", "--json"))
        self.assertEqual(comparison["request"]["scene"], "furnace")
        self.assertEqual(comparison["request"]["metrics"], ["indirect:fitted_rmse"])

    def test_what_cannot_be_meant_is_refused(self):
        for wrong in (["compare", "furnace", "--reference-passes", 3, "--entry", "path_tracing", "--passes", 1],
                      [*PRESET, "--reference", "path_tracing:3", "--reference-passes", 3], [*PRESET, "-o", "report.pdf"]):
            self.run_for(USAGE, *wrong)


class FiguresTest(Case):
    """The scenes of the figures, and splats counted."""

    SCENES = ["photon-splatting/plate", "photon-splatting/skimming-ray", "photon-splatting/chairs"]

    def test_scenes_are_a_family(self):
        page = cli.daemon.request("GET", "/v1/scenes?family=photon-splatting").json
        self.assertEqual([scene["name"] for scene in page["items"]], self.SCENES)
        self.assertIsNone(page["tests"])
        for name in self.SCENES:
            self.run_ok("render", name, "--width", 16, "--height", 9, "--passes", 1, "--method", "photon_splatting",
                        "--photons", 500)

    def test_overlap_is_a_heat_map(self):
        self.run_ok("render", "cornell-box-spot", "--width", 32, "--height", 24, "--passes", 2, "--method", "photon_splatting",
                    "--photons", 4000, "--weighting", "normalised", "--splat-size-relative", 0.3, "--layers", "overlap",
                    "--preview-layer", "overlap", "-o", "overlap.png", "-o", "overlap.exr")
        file = oiio.ImageInput.open(str(cli.folder / "overlap.exr"))
        splats = numpy.asarray(file.read_image("float"))[:, :, file.spec().channelindex("overlap.Y")]
        file.close()
        file = oiio.ImageInput.open(str(cli.folder / "overlap.png"))
        shown = numpy.asarray(file.read_image("uint8")).astype(float)
        file.close()
        self.assertGreater(splats.max(), 20)
        for channel, values in enumerate(([0, 0, 255, 255], [0, 255, 0, 255], [255, 0, 0, 255])):
            expected = numpy.interp(splats, [0, 200, 400, 600], values)
            self.assertLessEqual(numpy.abs(shown[:, :, channel] - expected).max(), 0.501)

    def test_layers_without_a_preview_are_refused(self):
        self.run_ok("render", "furnace", "--width", 8, "--height", 6, "--passes", 1, "--layers", "depth", "--label",
                    "for=layers")
        job = cli.daemon.request("GET", "/v1/jobs?label=for%3Dlayers").json["items"][0]["id"]
        for layer in ("depth", "overlap", "heat"):  # not shown, not there, unknown
            self.run_for(REFUSED, "jobs", "fetch", job, "--preview", "no.png", "--preview-layer", layer)
        self.run_ok("jobs", "fetch", job, "--preview", "indirect.png", "--preview-layer", "indirect")


if __name__ == "__main__":
    unittest.main()
