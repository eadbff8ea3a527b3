"""Methods that run on GPUs alone: what the daemon says of them where there is none."""

import unittest

from photond_daemon import DaemonTestCase, small_job

BASELINES = ("imperfect_shadow_maps", "reflective_shadow_maps")
ONE_BOUNCE = (*BASELINES, "visibility_filtering")
METHODS = (*ONE_BOUNCE, "image_space_photon_mapping", "light_propagation_volumes",
           "voxel_cone_tracing")


class GpuOnlyMethodsTest(DaemonTestCase):
    def test_they_describe_themselves(self):
        methods = {method["name"]: method for method in self.daemon.request("GET", "/v1/methods").json["items"]}
        for name in METHODS:
            method = methods[name]
            self.assertEqual((method["devices"], method["deterministic"], method["artefacts"]),
                             (["gpu"], {"gpu": True}, []))
            self.assertNotIn("caustic", method["layers"])
        for name in ONE_BOUNCE:
            method = methods[name]
            self.assertEqual(method["family"], "many lights")
            bounces = method["parameters"]["properties"]["bounces"]
            self.assertEqual((bounces["default"], bounces["minimum"], bounces["maximum"]), (1, 0, 1))
        self.assertEqual(methods["reflective_shadow_maps"]["parameters"]["properties"]["pattern"]["enum"],
                         ["flux", "paper"])

    def test_a_processor_is_refused(self):
        for name in METHODS:
            job = small_job("cornell-box", 16, 1, name)
            for place in ("/v1/jobs", "/v1/jobs?dry_run=true"):
                reply = self.daemon.request("POST", place, json_body=job)
                self.assertEqual((reply.status, reply.json["code"]), (422, "unsupported"), reply)
                self.assertIn(f'the method "{name}" does not run on a cpu', reply.text.replace("\\", ""))
                self.assertIn("/method/device", reply.text)
            # A reference is a job too.
            job = small_job("cornell-box", 16, 1)
            job["reference"] = {"method": {"name": name}, "stop": {"passes": 1}}
            reply = self.daemon.request("POST", "/v1/jobs", json_body=job)
            self.assertEqual((reply.status, reply.json["code"]), (422, "unsupported"), reply)

    def test_more_bounces_than_one_are_refused_by_name(self):
        for name in ONE_BOUNCE:
            job = small_job("cornell-box", 16, 1, name)
            job["method"].update({"device": "gpu", "parameters": {"bounces": 2}})
            reply = self.daemon.request("POST", "/v1/jobs", json_body=job)
            self.assertEqual((reply.status, reply.json["code"]), (422, "out_of_range"), reply)
            self.assertIn("/method/parameters/bounces", reply.text)


if __name__ == "__main__":
    unittest.main()
