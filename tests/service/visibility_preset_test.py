"""`photonctl compare --preset visibility-filtering-paper`, small: a column of Table 1."""

import json
import unittest

from gpu_daemon import needs_gpu
from photonctl_case import OK, Case, cli


def setUpModule():
    cli.start("--devices", "cpu,gpu")


def tearDownModule():
    cli.stop()


@needs_gpu
class PresetTest(Case):
    def report_of(self, part):
        result = cli.run("compare", "--preset", "visibility-filtering-paper", "--builtin", "--part", part, "--width", 32,
                         "--height", 32, "--passes", 2, "--reference-passes", 2, "-o", f"{part}.html", "--json-report",
                         f"{part}.json")
        self.assertEqual(result.returncode, OK, result.stderr)
        [file] = cli.folder.glob(f"{part}*.json")
        return {row["label"]: row for row in json.loads(file.read_text())["table"]}, result.stdout

    def test_a_column_of_table_1_stands_beside_the_paper(self):
        rows, output = self.report_of("box-64")
        self.assertEqual(set(rows), {"paper", "by the number of lists", "sets of bits", "without the filter", "octree",
                                     "shadow rays", "counts", "ours", "path tracing"})
        self.assertIn("89.6", output)  # ms of the paper's marching
        for label, row in rows.items():
            self.assertIsNotNone(row["error"]["indirect:relative_mse"], label)


if __name__ == "__main__":
    unittest.main()
