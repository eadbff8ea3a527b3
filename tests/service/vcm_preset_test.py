"""`photonctl compare --preset vcm`, small: bidirectional methods beside what they are made of."""

import json
import unittest

from photonctl_case import OK, Case, cli


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


class PresetTest(Case):
    def test_methods_stand_beside_each_other(self):
        result = cli.run("compare", "--preset", "vcm", "--part", "small-vcm/ceiling", "--width", 24, "--height", 24,
                         "--passes", 2, "--reference-passes", 2, "-o", "vcm.html", "--json-report", "vcm.json")
        self.assertEqual(result.returncode, OK, result.stderr)
        [file] = cli.folder.glob("vcm*.json")
        report = json.loads(file.read_text())
        self.assertEqual(report["request"]["scene"], "small-vcm/ceiling")
        self.assertEqual(report["request"]["reference"]["method"]["name"], "bidirectional_path_tracing")
        self.assertEqual({row["label"] for row in report["table"]},
                         {"path tracing", "bidirectional", "stochastic progressive", "vertex connection and merging",
                          "all techniques", "recursive weights", "own paths"})
        for row in report["table"]:
            self.assertIsNotNone(row["error"]["relative_mse"], row["label"])


if __name__ == "__main__":
    unittest.main()
