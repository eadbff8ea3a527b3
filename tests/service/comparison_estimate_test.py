"""What a comparison will take, asked before it is queued."""

import unittest

from photond_daemon import Daemon, small_job

REFERENCE = {"method": {"name": "path_tracing"}, "stop": {"passes": 8}}
COMPARISON = {
    "scene": "cornell-box", "image": {"width": 16, "height": 16}, "reference": REFERENCE,
    "entries": [{"label": "paths", "method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": [1, 2]}},
                {"label": "photons", "method": {"name": "photon_mapping",
                                                "parameters": {"photons": 500, "gather_rays": 1}}}],
    "stop": {"passes": 4}, "metrics": ["relative_mse"], "seeds": [1, 2, 3],
}


class ComparisonEstimateTest(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon("--max-queue", 12)
        self.addCleanup(self.daemon.close)
        self.daemon.wait_ready()

    def estimate(self, status=200, **changes):
        reply = self.daemon.request("POST", "/v1/comparisons?dry_run=true", json_body={**COMPARISON, **changes})
        self.assertEqual(reply.status, status, reply)
        return reply.json

    def estimated_job(self, method, **more):
        job = small_job(size=16, **{"passes": 4, **more})
        job["method"] = method
        return self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=job).json

    def test_nothing_is_known_before_anything_was_rendered_and_nothing_is_queued(self):
        told = self.estimate()
        self.assertEqual((told["jobs"], told["seconds"], told["reference_seconds"]), (9, None, None))
        self.assertEqual([(entry["label"], entry["parameters"], entry["seconds"]) for entry in told["entries"]],
                         [("paths", {"indirect_bounces": 1}, None), ("paths", {"indirect_bounces": 2}, None),
                          ("photons", {}, None)])
        for entry in told["entries"]:
            self.assertGreater(entry["memory_bytes"], 16 * 16 * 3 * 16)
            self.assertLessEqual(entry["memory_bytes"], told["memory_bytes"])
        self.assertEqual(self.daemon.request("GET", "/v1/jobs").json["items"], [])
        self.assertEqual(self.daemon.request("GET", "/v1/comparisons").json["items"], [])

    def test_a_time_is_an_upper_bound_for_each_job(self):
        told = self.estimate(stop={"seconds": 2})
        self.assertEqual((told["seconds"], [entry["seconds"] for entry in told["entries"]]), (18, [6, 6, 6]))

    def test_it_adds_up_what_its_jobs_are_estimated_to_take(self):
        photons = COMPARISON["entries"][1]["method"]
        self.daemon.run_job(small_job(size=32, passes=64))
        self.daemon.run_job({**small_job(size=32, passes=16), "method": photons})
        told = self.estimate()
        one = self.estimated_job(photons, reference=REFERENCE)
        entry = told["entries"][2]
        self.assertAlmostEqual(entry["seconds"], 3 * one["seconds"], places=9)
        self.assertEqual(entry["memory_bytes"], one["memory_bytes"])
        # One device: one job after another.
        self.assertAlmostEqual(told["seconds"], sum(entry["seconds"] for entry in told["entries"]), places=9)
        reference = self.estimated_job(REFERENCE["method"], passes=8)
        self.assertAlmostEqual(told["reference_seconds"], reference["seconds"], places=9)
        self.assertEqual(told["memory_bytes"], max([entry["memory_bytes"] for entry in told["entries"]]
                                                   + [reference["memory_bytes"]]))
        # A reference that is there takes no more time.
        reply = self.daemon.request("POST", "/v1/comparisons", json_body=COMPARISON)
        self.assertEqual((reply.status, len(reply.json["jobs"])), (202, told["jobs"]), reply)
        for job in reply.json["jobs"]:
            self.assertEqual(self.daemon.wait_for_job(job["id"])["state"], "succeeded")
        self.assertEqual(self.estimate()["reference_seconds"], 0)

    def test_it_refuses_what_the_comparison_would_be_refused_for(self):
        for changes in ({"scene": "cornel-box"}, {"camera": {"name": "left"}}, {"reference": "job:J999"},
                        {"entries": [{"method": {"name": "path_tracing", "device": "gpu:7"}}]},
                        {"entries": [{"method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": [1, "x"]}}]},
                        {"image": {"width": 16384, "height": 16384}}, {"stop": {}}, {"seeds": [1, 1]},
                        {"seeds": list(range(1, 8))}):
            with self.subTest(changes=changes):
                body = {**COMPARISON, **changes}
                asked = self.daemon.request("POST", "/v1/comparisons?dry_run=true", json_body=body)
                queued = self.daemon.request("POST", "/v1/comparisons", json_body=body)
                self.assertGreaterEqual(asked.status, 400, asked)
                self.assertEqual((asked.status, asked.json), (queued.status, queued.json))
        self.assertEqual(self.daemon.request("POST", "/v1/comparisons?dry_run=1", json_body=COMPARISON).status, 422)


if __name__ == "__main__":
    unittest.main()
