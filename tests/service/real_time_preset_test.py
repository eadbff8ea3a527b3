"""`photonctl compare --preset real-time`: what it asks the daemon for is every method that runs on a GPU, and is taken."""

import unittest

from gpu_daemon import needs_gpu
from photonctl_case import OK, Case, cli


def setUpModule():
    cli.start("--devices", "cpu,gpu")


def tearDownModule():
    cli.stop()


@needs_gpu
class PresetTest(Case):
    def test_every_method_of_the_gpu_is_there(self):
        result = cli.run("compare", "--preset", "real-time", "--builtin", "--part", "conference", "--width", 24, "--height", 16,
                         "--passes", 1, "--reference-passes", 2, "--no-wait")
        self.assertEqual(result.returncode, OK, result.stderr)
        [comparison] = cli.daemon.request("GET", "/v1/comparisons").json["items"]
        comparison = cli.daemon.request("GET", f"/v1/comparisons/{comparison['id']}").json
        cli.daemon.request("POST", f"/v1/comparisons/{comparison['id']}/cancel")
        self.assertEqual(comparison["request"]["scene"], "real-time/conference")
        used = {entry["method"]["name"] for entry in comparison["request"]["entries"]}
        methods = cli.daemon.request("GET", "/v1/methods").json["items"]
        on_gpu = {method["name"] for method in methods if "gpu" in method["devices"]}
        self.assertEqual(on_gpu - used, {"image_based_lighting"}, "no scene of these has an environment")


if __name__ == "__main__":
    unittest.main()
