"""`photonctl compare --preset progressive`, small: methods beside each other, and rules, alphas and kernels of radii."""

import json
import unittest

from photonctl_case import OK, Case, cli

PRESET = ["compare", "--preset", "progressive"]
METHODS = ("photon mapping", "photon map seen directly", "reverse", "progressive", "stochastic", "probabilistic")
RADII = ("rule", "tested by sectors", "global", "kernel")
SMALL = ["--width", 24, "--height", 18, "--passes", 2]


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


class PresetTest(Case):
    def report_of(self, part, labels, *more):
        """`labels` are the entries that trace photons: how many is not what is tested."""
        few = [word for label in labels for word in ("--sweep", f"{label}:photons=2000")]
        result = cli.run(*PRESET, "--part", part, *SMALL, *few, *more, "-o", "progressive.html",
                         "--json-report", "progressive.json")
        self.assertEqual(result.returncode, OK, result.stderr)
        [file] = cli.folder.glob("progressive*.json")
        report = json.loads(file.read_text())
        file.unlink()
        return report

    def test_all_methods_stand_beside_each_other(self):
        report = self.report_of("progressive/torus", METHODS, "--reference-passes", 2)
        self.assertEqual(report["request"]["scene"], "progressive/torus")
        self.assertEqual({row["label"] for row in report["table"]},
                         {"path tracing", *METHODS})
        self.assertEqual(report["request"]["reference"]["method"]["name"], "probabilistic_progressive_photon_mapping")
        for row in report["table"]:
            self.assertIsNotNone(row["error"]["relative_mse"], row["label"])

    def test_radii_by_rule_alpha_and_kernel(self):
        report = self.report_of("cornell-box-glass-radii", RADII, "--reference", "path_tracing:4")
        swept = {}
        for row in report["table"]:
            swept.setdefault(row["label"], set()).update(
                str(row["parameters"][name]) for name in ("radius_rule", "alpha", "kernel") if name in row["parameters"])
        self.assertLessEqual({"global", "trained", "local", "tested"}, swept["rule"])
        self.assertEqual(len([row for row in report["table"] if row["label"] == "global"]), 5)
        self.assertLessEqual({"constant", "gaussian", "epanechnikov"}, swept["kernel"])


if __name__ == "__main__":
    unittest.main()
