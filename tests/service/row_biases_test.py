"""Bias and noise of a comparison's rows apart, and where the bias is: measured once all seeds have succeeded, kept over a
restart, and shown by the table, as a map and as a picture.
"""

import struct
import unittest
import zlib

from photond_daemon import OVER, Daemon, DaemonTestCase, small_job, wait_until_at_rest

SIZE = 48  # blocks of 32 pixels, cut at the right and at the bottom
BLURRED = {"name": "photon_mapping", "parameters": {"gather": "direct", "boundary": "none", "photons": 2000, "radius": 0.5}}


def comparison(seeds=(1, 2, 3), **more):
    return {"scene": "cornell-box", "image": {"width": SIZE, "height": SIZE},
            "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 128}},
            "entries": [{"method": {"name": "path_tracing"}}, {"label": "blurred", "method": BLURRED},
                        {"method": {"name": "photon_splatting", "parameters": {"photons": 64}}}],
            "stop": {"passes": 4}, "seeds": list(seeds), "metrics": ["relative_mse", "rmse", "mae"], **more}


def png_pixels(png):
    """Width, height and rows of 8-bit RGB without filters undone: enough to see what colours there are."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, color = struct.unpack(">IIBB", png[16:26])
    data, at = b"", 8
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at:at + 8])
        if kind == b"IDAT":
            data += png[at + 8:at + 8 + length]
        at += 12 + length
    return width, height, depth, color, zlib.decompress(data)


def is_measured(found, metrics=("mse", "relative_mse")):
    """Whether the bias of every row and metric is there: all is measured in the background, each by itself."""
    return all(row["bias"] and set(metrics) <= row["bias"].keys() for row in found["table"])


class RowBiases(DaemonTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.found = cls.run_comparison(comparison(seeds=range(1, 6)), is_measured)

    @classmethod
    def run_comparison(cls, body, is_complete=lambda found: True):
        identity = cls.daemon.request("POST", "/v1/comparisons", json_body=body).json["id"]

        def over():
            found = cls.daemon.request("GET", f"/v1/comparisons/{identity}").json
            return found["state"] in OVER and (found["state"] != "succeeded" or is_complete(found)) and found
        found = cls.daemon.wait_until(over, "the comparison is complete")
        assert found["state"] == "succeeded", found
        return found

    def get(self, path):
        """The reply that is no "ask again": the machine's other jobs come first."""
        return self.daemon.wait_until(lambda: (reply := self.daemon.request("GET", path)).status != 503 and reply,
                                      f"{path} is made", look_every_s=0.2)

    def rows(self, found=None):
        return f"/v1/comparisons/{(found or self.found)['id']}/rows"

    def test_the_table_has_bias_and_noise_of_mean_squares(self):
        for row in self.found["table"]:
            self.assertEqual(row["bias"].keys(), {"relative_mse", "mse"}, row["label"])
            for parts in row["bias"].values():
                self.assertLess(parts["low"], parts["squared_bias"])
                self.assertLess(parts["squared_bias"], parts["high"])
                self.assertLess(parts["variance_low"], parts["variance"])
                self.assertLess(parts["variance"], parts["variance_high"])
            # The mean over the seeds of the error is both together, to the bit: it is the same sum in another order.
            error = row["error"]["relative_mse"]["value"]
            both = row["bias"]["relative_mse"]["squared_bias"] + row["bias"]["relative_mse"]["variance"]
            self.assertAlmostEqual(both / error, 1, places=3)
        exact, blurred, splats = (row["bias"]["relative_mse"] for row in self.found["table"])
        self.assertGreater(blurred["low"], 0)
        self.assertTrue(exact["low"] < 0 < exact["high"], exact)
        self.assertIn("no bias is seen", exact["text"])
        self.assertEqual([parts["floor"] for parts in (exact, blurred, splats)], [True, True, False])
        self.assertIn("more passes reach no relative_mse below the squared bias", blurred["text"])

    def test_the_map_says_where(self):
        for index, row in enumerate(self.found["table"]):
            found = self.get(f"{self.rows()}/{index}/bias.json").json
            self.assertEqual((found["row"], found["layer"], found["seeds"]), (index, "beauty", 5))
            self.assertEqual((found["block"], found["width"], found["height"], found["level"]), (32, 2, 2, 0.01))
            self.assertEqual(len(found["blocks"]), 4)
            self.assertEqual(sum(block["found"] for block in found["blocks"]), found["found"])
            self.assertIn("differ", found["text"])
        self.assertEqual(found["label"].split(",")[0], row["label"])

    def test_the_picture_shows_it(self):
        reply = self.get(f"{self.rows()}/1/bias.png")
        self.assertEqual((reply.status, reply.headers["content-type"]), (200, "image/png"))
        width, height, depth, color, data = png_pixels(reply.body)
        self.assertEqual((width, height, depth, color), (SIZE, SIZE, 8, 2))
        self.assertGreater(len(set(data)), 2)

    def test_of_other_layers_on_request(self):
        found = self.run_comparison(comparison(seeds=(1, 2), metrics=["direct:relative_mse"]),
                                    lambda found: is_measured(found, ["direct:relative_mse"]))
        self.assertIsNone(found["table"][0]["bias"]["direct:relative_mse"]["variance_low"])
        self.assertEqual(self.get(f"{self.rows(found)}/0/bias.json?layer=direct").json["layer"], "direct")
        self.assertEqual(self.get(f"{self.rows(found)}/0/bias.json?layer=indirect").json["layer"], "indirect")
        reply = self.get(f"{self.rows(found)}/0/bias.json?layer=caustic")
        self.assertEqual(reply.status, 404)
        self.assertIn("have a layer 'caustic'", reply.json["detail"])
        reply = self.get(f"{self.rows(found)}/0/bias.json?layer=depth")
        self.assertEqual((reply.status, reply.json["errors"][0]["pointer"]), (422, "/layer"))

    def test_where_there_is_none_it_says_why(self):
        single = self.run_comparison(comparison(seeds=(1,)))
        self.assertEqual([row["bias"] for row in single["table"]], [None] * 3)
        reply = self.get(f"{self.rows(single)}/0/bias.json")
        self.assertEqual(reply.status, 404)
        self.assertIn("one seed", reply.json["detail"])
        for path in (f"{self.rows()}/3/bias.json", f"{self.rows()}/x/bias.png", "/v1/comparisons/C999/rows/0/bias.json"):
            self.assertEqual(self.get(path).status, 404, path)
        job = self.daemon.run_job(small_job(size=SIZE, passes=2, seed=9))["id"]
        named = self.run_comparison(comparison(seeds=(1, 2), reference=f"job:{job}"))
        self.assertIsNone(named["table"][0]["bias"])
        self.assertIn("not two films", self.get(f"{self.rows(named)}/0/bias.png").json["detail"])


class BesideAJob(DaemonTestCase):
    def test_it_is_measured_in_the_background(self):
        identity = self.daemon.request("POST", "/v1/comparisons", json_body=comparison(seeds=(1, 2))).json["id"]
        endless = self.daemon.submit(small_job(size=64, passes=100_000_000))["id"]
        found = self.daemon.wait_until(
            lambda: (now := self.daemon.request("GET", f"/v1/comparisons/{identity}").json)["table"][-1]["bias"] and now,
            "its bias is measured", look_every_s=0.1)
        self.assertEqual((found["state"], self.daemon.job(endless)["state"]), ("succeeded", "running"))
        self.daemon.request("DELETE", f"/v1/jobs/{endless}")


class MeasuredAgain(DaemonTestCase):
    def test_what_could_not_be_kept_is_measured_later(self):
        # Processes kept in reserve, of which nobody tells, open the folder as they start.
        wait_until_at_rest(self.daemon.children)
        cache, away = self.daemon.data_dir / "cache", self.daemon.data_dir / "away"
        cache.rename(away)
        body = comparison(seeds=(1, 2), metrics=["relative_mse", "direct:relative_mse"])
        path = "/v1/comparisons/" + self.daemon.request("POST", "/v1/comparisons", json_body=body).json["id"]
        found = self.daemon.wait_for_state(path)
        # Six figures, each by itself: no layer waits for another's.
        self.daemon.wait_until(lambda: self.daemon.log().count("are not measured now: cannot write") >= 6,
                               "each figure has failed")
        self.assertEqual([row["bias"] for row in found["table"]], [None] * 3)
        away.rename(cache)

        def measured():
            table = self.daemon.request("GET", path).json["table"]
            return all(row["bias"] and len(row["bias"]) == 2 for row in table) and table

        for row in self.daemon.wait_until(measured, "all of it is measured"):
            self.assertEqual(row["bias"].keys(), set(body["metrics"]))


class KeptOverARestart(unittest.TestCase):
    def test_what_was_measured_is_not_measured_again(self):
        with Daemon() as daemon:
            identity = daemon.request("POST", "/v1/comparisons", json_body=comparison(seeds=(1, 2))).json["id"]
            path = f"/v1/comparisons/{identity}"
            found = daemon.wait_for_state(path)
            found = daemon.wait_until(lambda: is_measured(now := daemon.request("GET", path).json) and now,
                                      "it is measured", look_every_s=0.05)
            before = found["table"], daemon.request("GET", f"{path}/rows/1/bias.json").body
            for film in (daemon.data_dir / "films").iterdir():
                film.write_bytes(b"")  # nothing can be measured any more
            daemon.stop()
            daemon.start()

            def now():
                return daemon.request("GET", path).json["table"], daemon.request("GET", f"{path}/rows/1/bias.json").body

            self.assertEqual(before, now())
            for film in found["reference"]["jobs"]:
                self.assertLess(daemon.request("DELETE", f"/v1/jobs/{film}?purge=true").status, 300)
                daemon.wait_until(lambda: daemon.request("GET", f"/v1/jobs/{film}").status == 404, f"{film} is removed")
            self.assertEqual(before, now())
            self.assertEqual(daemon.request("GET", path).json["reference"]["form"], "two_films")
            reply = daemon.request("GET", f"{path}/rows/1/bias.json?layer=direct")
            self.assertEqual(reply.status, 404)
            self.assertIn("a film of its reference is lost", reply.json["detail"])


if __name__ == "__main__":
    unittest.main()
