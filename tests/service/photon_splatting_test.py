"""Photon splatting from the request to its files: layers, statistics, what is skipped, how it describes itself, and what is
refused."""

import struct
import unittest

from photond_daemon import DaemonTestCase, small_job


def splat_job(scene="cornell-box", size=24, passes=2, layers=(), **parameters):
    job = small_job(scene, size, passes, "photon_splatting", layers=list(layers))
    job["method"]["parameters"] = {"photons": 500, **parameters}
    return job


class PhotonSplattingTest(DaemonTestCase):
    def finished(self, body):
        job = self.daemon.wait_for_job(self.daemon.submit(body)["id"])
        self.assertEqual(job["state"], "succeeded", job)
        return job

    def layer(self, job, name):
        reply = self.daemon.request("GET", f"/v1/jobs/{job['id']}/pixels?layer={name}")
        self.assertEqual(reply.status, 200, reply)
        return struct.unpack(f"<{len(reply.body) // 4}f", reply.body)

    def test_a_job_from_submission_to_its_files(self):
        body = splat_job("cornell-box-glass", layers=["overlap", "depth"], bounces=2, stratify=True, grid_cells=32,
                         representative="random", splats_per_cell=2, filter="gaussian", blur="3")
        job = self.finished(body)
        statistics = job["statistics"]
        counts = statistics["counts"]
        self.assertGreaterEqual(counts["photons_emitted"], 2 * 500)
        self.assertGreater(counts["splats"], 0)
        self.assertGreaterEqual(counts["splat_contributions"], counts["splats"])
        self.assertEqual((statistics["nan_count"], statistics["infinity_count"]), (0, 0))
        stages = {stage["name"] for stage in statistics["stages"]}
        self.assertLessEqual({"photon_tracing", "stratify", "splat_find", "splat_depth", "splat", "repay", "filter",
                              "combine"}, stages)
        structures = statistics["memory"]["structures"]
        self.assertLessEqual({"photons", "stratification", "splat_batch", "visible_points", "shaft_visibility"},
                             set(structures))

        overlap, indirect, depth = (self.layer(job, name) for name in ("overlap", "indirect", "depth"))
        self.assertEqual(len(overlap), 24 * 24)
        self.assertTrue(all(count >= 0 for count in overlap))
        self.assertGreater(max(overlap), 1)
        self.assertTrue(all(count == 0 for count, distance in zip(overlap, depth) if distance == 0))
        self.assertTrue(all(value >= 0 for value in indirect))
        self.assertGreater(sum(indirect), 0)
        exr = self.daemon.request("GET", job["links"]["image"]).body
        self.assertIn(b"\0overlap.Y\0", exr)

        # The same bits again, and others for other numbers.
        self.assertEqual(self.finished(body)["statistics"]["pixel_hash"], statistics["pixel_hash"])
        self.assertNotEqual(self.finished({**body, "seed": 2})["statistics"]["pixel_hash"], statistics["pixel_hash"])

    def test_what_is_not_needed_is_skipped(self):
        statistics = self.finished(splat_job())["statistics"]
        skipped = {part["what"]: part for part in statistics["skipped"]}
        self.assertLessEqual({"depth maps of beams", "absorption"}, set(skipped))
        statistics = self.finished(splat_job(weighting="normalised", indirect_exposure=0.5))["statistics"]
        skipped = {part["what"]: part for part in statistics["skipped"]}
        self.assertGreater(skipped["shaft visibility"]["bytes_saved"], 0)
        self.assertNotIn("shaft_visibility", statistics["memory"]["structures"])
        self.assertIn("normalise", {stage["name"] for stage in statistics["stages"]})
        dark = self.finished(splat_job(bounces=0))
        self.assertIn("splats", {part["what"] for part in dark["statistics"]["skipped"]})
        self.assertEqual(sum(self.layer(dark, "indirect")), 0)

    def test_the_method_describes_itself(self):
        methods = {method["name"]: method for method in self.daemon.request("GET", "/v1/methods").json["items"]}
        method = methods["photon_splatting"]
        self.assertEqual((method["family"], method["devices"], method["mergeable"], method["artefacts"]),
                         ("photon splatting", ["cpu", "gpu"], True, []))
        self.assertCountEqual(
            method["layers"], [name for name in methods["path_tracing"]["layers"] if name != "caustic"] + ["overlap"])
        properties = method["parameters"]["properties"]
        self.assertLessEqual({"photons", "bounces", "weighting", "estimator", "stratify", "representative", "visibility",
                              "repay", "alpha", "splat_size", "splat_size_relative"}, set(properties))
        self.assertEqual(properties["estimator"]["enum"], ["connect", "kernel"])
        self.assertEqual(properties["weighting"]["enum"], ["normalised", "radiometric"])
        self.assertEqual(properties["injection"]["enum"], ["paths", "reflective_shadow_map"])
        self.assertEqual(properties["bounces"]["default"], 254)
        self.assertEqual(properties["splat_size"]["x-unit"], "m")

    def test_memory_is_estimated(self):
        # Few pixels and photons: what does not depend on them is most of it; their own figures are a unit test's.
        for parameters in ({}, {"stratify": True}, {"weighting": "normalised"}):
            body = splat_job(size=64, passes=1, **parameters)
            estimate = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=body)
            self.assertEqual(estimate.status, 200, estimate)
            counted = self.finished(body)["statistics"]["memory"]["accounted_bytes"]
            self.assertLess(estimate.json["memory_bytes"] / counted, 1.5, parameters)
            self.assertGreater(estimate.json["memory_bytes"] / counted, 1 / 1.5, parameters)

    def test_malformed_parameters(self):
        for parameters, at in (({"splat_size": 0.1, "splat_size_relative": 0.1}, "splat_size_relative"),
                               ({"injection": "reflective_shadow_map", "bounces": 2}, "bounces"),
                               ({"indirect_exposure": 2}, "indirect_exposure"), ({"bounces": 255}, "bounces"),
                               ({"photons": 0}, "photons"), ({"rays_per_photon": 0}, "rays_per_photon"),
                               ({"grid_cells": 1025}, "grid_cells"), ({"shadow_resolution": 3}, "shadow_resolution"),
                               ({"estimator": "conect"}, "estimator"), ({"blur": "4"}, "blur"), ({"blur": 3}, "blur"),
                               ({"alpha": 1}, "alpha"), ({"splat_size": 0}, "splat_size"), ({"ambient": -1}, "ambient"),
                               ({"stratify": "yes"}, "stratify"), ({"splat_sise": 0.1}, "splat_sise")):
            for path in ("/v1/jobs", "/v1/jobs?dry_run=true"):
                reply = self.daemon.request("POST", path, json_body=splat_job(**parameters))
                self.assertEqual(reply.status, 422, (parameters, reply))
                self.assertEqual([error["pointer"] for error in reply.json["errors"]], [f"/method/parameters/{at}"], reply)

    def test_layers_that_the_method_does_not_have(self):
        for layer in ("caustic", "photon_count"):
            reply = self.daemon.request("POST", "/v1/jobs", json_body=splat_job(layers=["depth", layer]))
            self.assertEqual((reply.status, reply.json["code"]), (422, "unsupported"), reply)
            self.assertEqual([error["pointer"] for error in reply.json["errors"]], ["/layers/1"])


if __name__ == "__main__":
    unittest.main()
