"""Progressive photon mapping over HTTP: films whose passes build on those before go on to the same bits and are not
merged; those whose passes stand alone are; layers have pictures.
"""

import os
import signal
import unittest

from photond_daemon import DaemonTestCase

FIXED = "progressive_photon_mapping"
STOCHASTIC = "stochastic_progressive_photon_mapping"
PROBABILISTIC = "probabilistic_progressive_photon_mapping"
PASSES = 12


def progressive_job(method, passes=PASSES, layers=(), **more):
    first_pass = more.pop("first_pass", 0)
    return {"scene": "cornell-box-glass", "image": {"width": 16, "height": 16}, "layers": list(layers),
            "method": {"name": method, "parameters": {"photons": 300, **more}},
            "first_pass": first_pass, "stop": {"passes": passes}}


def hash_of(job):
    return job["statistics"]["pixel_hash"]


class ProgressiveTest(DaemonTestCase):
    daemon_arguments = ("--save-seconds", 0.1)

    def finished(self, body):
        job = self.daemon.wait_for_job(self.daemon.submit(body)["id"])
        self.assertEqual(job["state"], "succeeded", job["failure"])
        return job

    def extended(self, job, passes):
        reply = self.daemon.request("POST", f"/v1/jobs/{job['id']}/extend", json_body={"stop": {"passes": passes}})
        self.assertEqual(reply.status, 202, reply)
        return self.daemon.wait_for_job(job["id"])

    def merged(self, jobs):
        return self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": [job["id"] for job in jobs]})

    def refused(self, body):
        reply = self.daemon.request("POST", "/v1/jobs", json_body=body)
        self.assertEqual(reply.status, 422, reply)
        return reply.json["errors"][0]

    def test_extended_it_is_the_longer_job_by_every_rule(self):
        for method, rules in ((FIXED, ("local", "global")), (STOCHASTIC, ("local", "tested", "trained")),
                              (PROBABILISTIC, ("global", "trained"))):
            for rule in rules:
                with self.subTest(method=method, rule=rule):
                    whole = self.finished(progressive_job(method, radius_rule=rule))
                    job = self.extended(self.finished(progressive_job(method, passes=5, radius_rule=rule)), PASSES)
                    self.assertEqual((job["passes_done"], job["statistics"]["resumed_passes"]), (PASSES, 5))
                    self.assertEqual(hash_of(job), hash_of(whole))
                    # A film that is looked at again without a pass keeps what the next pass needs.
                    again = self.extended(self.extended(self.finished(
                        progressive_job(method, passes=5, radius_rule=rule)), 7), PASSES)
                    self.assertEqual(hash_of(again), hash_of(whole))

    def test_a_killed_job_goes_on_to_the_same_bits(self):
        body = progressive_job(STOCHASTIC, passes=400)
        whole = self.finished(body)
        job = self.daemon.submit(body)
        self.daemon.wait_until((self.daemon.data_dir / "films" / f"{job['id']}-1.film").exists, "a film is saved", job=job["id"])
        self.assertEqual(self.daemon.wait_for_passes(job["id"])["state"], "running", "too fast to be hit: make it longer")
        os.kill(self.daemon.workers()["cpu"], signal.SIGKILL)
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual([attempt["outcome"] for attempt in job["attempts"]], ["lost", "succeeded"])
        self.assertGreater(job["statistics"]["resumed_passes"], 0)
        self.assertEqual(hash_of(job), hash_of(whole))

    def test_only_passes_that_stand_alone_are_merged(self):
        for method, rule, alone in ((STOCHASTIC, "local", False), (STOCHASTIC, "tested", False),
                                    (FIXED, "local", False), (STOCHASTIC, "trained", True), (FIXED, "global", True),
                                    (PROBABILISTIC, "trained", True)):
            with self.subTest(method=method, rule=rule):
                whole = self.finished(progressive_job(method, passes=4, radius_rule=rule))
                self.assertEqual(whole["statistics"]["mergeable"], alone)
                if alone:
                    parts = [self.finished(progressive_job(method, passes=2, first_pass=first, radius_rule=rule))
                             for first in (0, 2)]
                    merged = self.merged(parts)
                    self.assertEqual(merged.status, 201, merged)
                    self.assertEqual(hash_of(merged.json), hash_of(whole))
                    continue
                other = self.finished(progressive_job(method, passes=2, radius_rule=rule))
                reply = self.merged([whole, other])
                self.assertEqual((reply.status, reply.json["code"]), (422, "unsupported"), reply)
                self.assertIn("their passes build on those before", reply.json["detail"])
                fault = self.refused(progressive_job(method, passes=2, first_pass=2, radius_rule=rule))
                self.assertEqual(fault["pointer"], "/first_pass")

    def test_one_film_is_merged_with_its_state(self):
        whole = self.finished(progressive_job(STOCHASTIC))
        copy = self.merged([self.finished(progressive_job(STOCHASTIC, passes=5))])
        self.assertEqual(copy.status, 201, copy)
        self.assertEqual(hash_of(self.extended(copy.json, PASSES)), hash_of(whole))

    def test_layers_have_pictures(self):
        layers = ["photon_count", "radius", "bias_estimate"]
        job = self.finished(progressive_job(PROBABILISTIC, layers=layers))
        for layer in layers:
            reply = self.daemon.request("GET", f"/v1/jobs/{job['id']}/preview.png?layer={layer}")
            self.assertEqual((reply.status, reply.body[1:4]), (200, b"PNG"), (layer, reply))
        plain = self.daemon.request("GET", f"/v1/jobs/{job['id']}/preview.png?layer=albedo")
        self.assertEqual(plain.status, 422, plain)

    def test_what_a_rule_does_not_allow_is_refused(self):
        for method, parameters, pointer in (
                (PROBABILISTIC, {"radius_rule": "local"}, "/method/parameters/radius_rule"),
                (PROBABILISTIC, {"radius_rule": "trained", "radius": 0.1}, "/method/parameters/radius"),
                (STOCHASTIC, {"radius": 0.1, "radius_relative": 0.1}, "/method/parameters/radius_relative"),
                (FIXED, {"eye_samples": 0}, "/method/parameters/eye_samples"),
                (STOCHASTIC, {"alpha": 1}, "/method/parameters/alpha"),
                (STOCHASTIC, {"eye_samples": 4}, "/method/parameters/eye_samples")):
            with self.subTest(method=method, parameters=parameters):
                self.assertEqual(self.refused(progressive_job(method, **parameters))["pointer"], pointer)

    def test_the_methods_describe_themselves(self):
        methods = {method["name"]: method for method in self.daemon.request("GET", "/v1/methods").json["items"]}
        for name, mergeable in ((FIXED, False), (STOCHASTIC, False), (PROBABILISTIC, True)):
            method = methods[name]
            self.assertEqual((method["family"], method["mergeable"]), ("photon mapping", mergeable))
            self.assertLessEqual({"photon_count", "radius", "bias_estimate"}, set(method["layers"]))
            self.assertIn("radius_rule", method["parameters"]["properties"])
        estimate = self.daemon.request("POST", "/v1/jobs?dry_run=true", json_body=progressive_job(STOCHASTIC))
        self.assertEqual(estimate.status, 200, estimate)
        self.assertGreater(estimate.json["memory_bytes"], 1 << 20)


if __name__ == "__main__":
    unittest.main()
