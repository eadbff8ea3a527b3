"""photond-gpu-bench: what its lists say is what it measures, on the CPU and on lavapipe."""

import json
import os
import subprocess
import tempfile
import unittest

PROGRAM = os.path.join(os.environ["PHOTOND_BIN"], "photond-gpu-bench")
BOX = {"scene": "cornell-box", "width": 16, "height": 16, "devices": ["cpu"]}
LIGHTS = {"method": "svo_many_lights", "parameters": {"vpls": 64, "visibility": "svo", "voxel_resolution": 16}}


class GpuBench(unittest.TestCase):
    def bench(self, entries, *options, code=0):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "list.json")
            with open(file, "w", encoding="utf-8") as out:
                json.dump(entries, out)
            run = subprocess.run([PROGRAM, "--list", file, "--scenes", folder, *options], capture_output=True, text=True,
                                 check=False)
            self.assertEqual(run.returncode, code, run.stderr)
            return json.loads(run.stdout)["entries"] if run.stdout else run.stderr

    def cpu(self, *entries, code=0):
        return self.bench(entries, "--device", "cpu", code=code)

    def test_an_entry_stands_for_every_combination(self):
        axes = [[{"name": "few", "parameters": {"photons": 100}}, {"name": "many", "parameters": {"photons": 200}}],
                [{"name": "small"}, {"name": "large", "width": 32}]]
        entries = self.cpu({**BOX, "name": "mapping", "method": "photon_mapping", "passes": 1, "vary": axes})
        self.assertEqual([(e["name"], e["parameters"]["photons"], e["width"]) for e in entries],
                         [("mapping, few, small", 100, 16), ("mapping, few, large", 100, 32),
                          ("mapping, many, small", 200, 16), ("mapping, many, large", 200, 32)])

    def test_stages_stand_beside_what_was_published(self):
        published = {"indirect": 100.0, "rsm+indirect": 100.0, "repay": 1.0, "frame": 100.0}
        [entry] = self.cpu({**BOX, **LIGHTS, "name": "lights", "passes": 3, "published_ms": published})
        rows = entry["cpu"]["published"]
        self.assertEqual(set(rows), set(published))
        for row in rows.values():
            if row["ms"] > 0:
                self.assertAlmostEqual(row["times_as_fast"], row["published_ms"] / row["ms"])
        self.assertGreater(rows["indirect"]["ms"], 0)
        self.assertGreater(rows["rsm+indirect"]["ms"], rows["indirect"]["ms"])
        self.assertGreater(rows["frame"]["ms"], rows["indirect"]["ms"])
        self.assertGreater(entry["cpu"]["wall_ms_of_a_pass_alone"], 0)

    def test_a_curve_is_read_at_every_target(self):
        wanted = {"targets": [1.0, 0.2], "metric": "direct:smape", "reference": {"passes": 256}}
        [entry] = self.cpu({**BOX, "name": "paths", "method": "path_tracing", "time_to_error": wanted})
        first, second = entry["cpu"]["reached"]
        self.assertEqual((first["target"], second["target"]), (1.0, 0.2))
        self.assertLessEqual(first["seconds"], second["seconds"])
        self.assertLessEqual(second["seconds_of_passes"], second["seconds"])
        self.assertLessEqual(entry["cpu"]["curve"][-1]["error"], 0.2)

    def test_settings_come_by_rising_error(self):
        wanted = {"milliseconds": 5, "metrics": ["direct:smape", "flip_ldr"], "reference": {"passes": 64}, "repeats": 2,
                  "settings": [{"name": "wrong", "method": "path_tracing", "parameters": {"bouncs": 1}},
                               {"name": "blind", "method": "path_tracing", "parameters": {"indirect_bounces": 1}},
                               {"name": "paths", "method": "path_tracing"}]}
        [entry] = self.cpu({**BOX, "name": "5 ms", "quality": wanted})
        rows = entry["cpu"]["settings"]
        self.assertIn("bouncs", rows[2]["error"])
        errors = [row["errors"]["direct:smape"] for row in rows[:2]]
        self.assertLessEqual(errors[0]["mean"], errors[1]["mean"])
        for row, error in zip(rows, errors):
            self.assertEqual(len(error["each"]), 2)
            self.assertAlmostEqual(row["ms"], row["passes"] * row["ms_a_pass"])
            self.assertTrue(row["passes"] == 1 or row["ms"] <= 5)

    def test_an_entry_that_fails_says_why_and_the_next_follows(self):
        paths = {"method": "path_tracing", "passes": 1}
        entries = self.cpu({**BOX, **paths, "name": "a", "camera": "nobody's"}, {**BOX, **paths, "name": "b"},
                           {**BOX, **paths, "name": "c", "scene": "not_there.baked"}, code=1)
        self.assertIn("nobody's", entries[0]["error"])
        self.assertIn("cpu", entries[1])
        self.assertIn("not_there.baked", entries[2]["error"])

    def test_lists_are_read_strictly(self):
        paths = {**BOX, "name": "paths", "method": "path_tracing"}
        for wrong, said in (({"pases": 1, "passes": 1}, '"pases"'), ({}, "one of passes"), ({"passes": "all"}, "number"),
                            ({"passes": 1, "voxels": {"resolution": 16}}, "one of passes"),
                            ({"time_to_error": {"targets": [], "reference": {"passes": 1}}}, "target"),
                            ({"time_to_error": {"targets": [1], "metric": "bias", "reference": {"passes": 1}}}, "bias")):
            said_so = self.cpu({**paths, **wrong}, code=2)
            self.assertIn("paths: ", said_so)
            self.assertIn(said, said_so)

    def test_voxels_and_lights_on_a_gpu(self):
        entries = self.bench(
            [{"name": "octree", "scene": "cornell-box", "published_ms": {"voxelise+svo_build": 1.0},
              "voxels": {"resolution": 32, "builds": 2}},
             {**BOX, **LIGHTS, "name": "lights", "passes": 2, "devices": ["gpu"], "published_ms": {"frame": 1.0}}])
        octree, lights = (entry["gpu"] for entry in entries)
        self.assertGreater(octree["voxels"], 1000)
        self.assertAlmostEqual(octree["bytes_a_voxel"], octree["bytes"] / octree["voxels"])
        self.assertGreater(octree["published"]["voxelise+svo_build"]["ms"], 0)
        self.assertGreater(lights["stages"]["indirect"]["gpu_ms_median"], 0)
        # Of two passes the median is the mean: a frame has the voxels, and not what brings the image to the host.
        voxels_ms = sum(stage.get("gpu_ms", 0) for stage in lights["begin_stages"].values())
        self.assertGreater(voxels_ms, 0)
        readback_ms = lights["stages"]["readback"]["gpu_ms"]
        frame_ms = lights["ms_a_pass_median"] - readback_ms + voxels_ms
        self.assertAlmostEqual(lights["published"]["frame"]["ms"], frame_ms, delta=1e-6 * frame_ms)


if __name__ == "__main__":
    unittest.main()
