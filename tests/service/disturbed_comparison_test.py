"""A comparison beside foreign busy loops: its disturbed jobs are named and repeated, twice at most, and which of them counts
follows from what they had of their cores. How much that was is printed; that the verdict is the idle machine's, or too close
to call, is asserted in the long form, on an idle machine."""

import os
import unittest

from busy_loops import BusyLoops
from photond_daemon import OVER, Daemon, DaemonTestCase, Ended, small_job

MOST_RUNS = 3


def comparison(seconds=0.25, size=64, seeds=(1,), **more):
    return {"scene": "cornell-box", "image": {"width": size, "height": size},
            "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 64}},
            "entries": [{"label": "paths", "method": {"name": "path_tracing"}},
                        {"label": "photons", "method": {"name": "photon_mapping", "parameters": {"gather": "direct"}}}],
            "stop": {"seconds": seconds}, "seeds": list(seeds), **more}


def get(daemon, comparison_id):
    return daemon.request("GET", f"/v1/comparisons/{comparison_id}").json


def submit(daemon, body):
    reply = daemon.request("POST", "/v1/comparisons", json_body=body)
    assert reply.status == 202, reply
    return reply.json["id"]


def wait_until_over(daemon, comparison_id):
    return daemon.wait_for_state(f"/v1/comparisons/{comparison_id}")


def wait_for_repeats(daemon, comparison_id, repeats=1):
    """The comparison once so many jobs were repeated; raises Ended when it is over with fewer."""
    def found_repeated():
        found = get(daemon, comparison_id)
        if found["repeats"] >= repeats:
            return found
        if found["state"] in OVER:
            raise Ended(f"{comparison_id} is {found['state']} after {found['repeats']} repeats: {found['jobs']}")
        return None
    return daemon.wait_until(found_repeated, f"{repeats} jobs are repeated", look_every_s=0.02)


def share_of(daemon, run):
    """1 where it was not disturbed."""
    return (daemon.job(run["id"])["statistics"]["shared"] or {"share": 1})["share"]


class Checks(unittest.TestCase):
    def assert_told(self, daemon, found):
        """That it says of its jobs what their statistics say, and counts the right ones."""
        self.assertEqual(found["state"], "succeeded", found)
        self.assertEqual(found["repeats"], sum(len(job["runs"]) - 1 for job in found["jobs"]))
        for job in found["jobs"]:
            shares = [share_of(daemon, run) for run in job["runs"]]
            print(job["label"], shares)
            self.assertLessEqual(len(shares), MOST_RUNS)
            self.assertEqual(job["id"], job["runs"][shares.index(max(shares))]["id"])
            self.assertTrue(all(share < 1 for share in shares[:-1]), "only what was disturbed is repeated")
            self.assertTrue(shares[-1] == 1 or len(shares) == MOST_RUNS, "and as long as it was")
            self.assertEqual([run["warning"] is None for run in job["runs"]], [share == 1 for share in shares])
            said = [text for text in found["warnings"] if text.startswith(f"{job['label']}, seed {job['seed']}: ")]
            self.assertEqual(len(said), int(min(shares) < 1), found["warnings"])
        self.assertEqual([row["disturbed"] for row in found["table"]],
                         [int(job["warning"] is not None) for job in found["jobs"]])
        self.assertEqual([row["jobs"] for row in found["table"]], [[job["id"]] for job in found["jobs"]])
        page = daemon.request("GET", found["links"]["report_html"]).text
        for text in found["warnings"]:
            self.assertIn(text, page)


class DisturbedComparisonTest(DaemonTestCase, Checks):
    daemon_arguments = ("--repeats", 2)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if cls.daemon.run_job(small_job())["statistics"]["cores"]["run_delay_seconds"] is None:
            cls.tearDownClass()
            raise unittest.SkipTest("this kernel does not say how long threads wait")

    def test_is_repeated_twice_at_most(self):
        with BusyLoops():
            found = wait_until_over(self.daemon, submit(self.daemon, comparison()))
        self.assert_told(self.daemon, found)
        self.assertEqual([len(job["runs"]) for job in found["jobs"]], [MOST_RUNS, MOST_RUNS])
        for job in found["jobs"]:
            self.assertIn(f"{job['id']} lost ", "".join(found["warnings"]))
            requests = [self.daemon.job(run["id"])["request"] for run in job["runs"]]
            self.assertEqual(requests, requests[:1] * MOST_RUNS)
            log = self.daemon.request("GET", f"/v1/jobs/{job['runs'][0]['id']}/log.txt").text
            self.assertIn(f"disturbed: repeated as {job['runs'][1]['id']}", log)
        self.assertTrue(all(", the least of 3 runs; run it again" in text for text in found["warnings"]))
        for verdict in found["verdicts"]:
            self.assertEqual(verdict["disturbed"], [0, 1])
            self.assertIn("lost processor time to other processes", verdict["text"])

    def test_an_undisturbed_repeat_counts(self):
        with BusyLoops():
            comparison_id = submit(self.daemon, comparison())
            wait_for_repeats(self.daemon, comparison_id)
        self.assert_told(self.daemon, wait_until_over(self.daemon, comparison_id))

    def test_is_repeated_on_request(self):
        found = wait_until_over(self.daemon, submit(self.daemon, comparison(seconds=None, stop={"passes": 2})))
        job = found["jobs"][0]
        repeat = self.daemon.request("POST", f"/v1/jobs/{job['id']}/repeat")
        self.assertEqual(repeat.status, 202, repeat)
        self.assertEqual(repeat.json["comparison"], found["id"])
        again = self.daemon.wait_for_job(repeat.json["id"])
        self.assertEqual(again["statistics"]["pixel_hash"], self.daemon.job(job["id"])["statistics"]["pixel_hash"])
        found = wait_until_over(self.daemon, found["id"])
        self.assertIn(again["id"], [run["id"] for run in found["jobs"][0]["runs"]])
        alone = self.daemon.run_job(small_job(labels={"a": "b"}))
        repeat = self.daemon.request("POST", f"/v1/jobs/{alone['id']}/repeat").json
        self.assertNotEqual(repeat["id"], alone["id"])
        self.assertEqual(repeat["request"], alone["request"])
        self.assertIsNone(repeat["comparison"])
        endless = self.daemon.submit(small_job(passes=100_000_000))
        refused = self.daemon.request("POST", f"/v1/jobs/{endless['id']}/repeat")
        self.assertEqual(refused.status, 409, refused)
        self.daemon.request("DELETE", f"/v1/jobs/{endless['id']}")
        self.daemon.wait_for_job(endless["id"])


class RestartTest(Checks):
    def test_a_repeat_survives_the_daemon(self):
        with Daemon("--repeats", 2) as daemon:
            daemon.wait_ready()
            if daemon.run_job(small_job())["statistics"]["cores"]["run_delay_seconds"] is None:
                self.skipTest("this kernel does not say how long threads wait")
            with BusyLoops():
                comparison_id = submit(daemon, comparison())
                before = wait_for_repeats(daemon, comparison_id)
                daemon.kill()
            daemon.start()
            daemon.wait_ready()
            found = wait_until_over(daemon, comparison_id)
            self.assertGreaterEqual(found["repeats"], before["repeats"])
            self.assertEqual(found["state"], "succeeded")
            for old, new in zip(before["jobs"], found["jobs"]):
                self.assertEqual(new["runs"][0]["id"], old["runs"][0]["id"])


@unittest.skipUnless("PHOTOND_LONG" in os.environ, "takes an idle machine")
class LongVerdictTest(Checks):
    def test_it_is_the_idle_machines_or_too_close_to_call(self):
        body = comparison(seconds=3, size=128, seeds=(1, 2, 3))
        with Daemon("--repeats", 2) as daemon:
            daemon.wait_ready()
            idle = wait_until_over(daemon, submit(daemon, body))
            self.assertEqual(idle["repeats"], 0, "the machine is not idle")
            with BusyLoops():
                comparison_id = submit(daemon, body)
                wait_for_repeats(daemon, comparison_id, 3)
            beside = wait_until_over(daemon, comparison_id)
        first = {verdict["error"]: verdict for verdict in idle["verdicts"]}
        print(idle["headlines"][0]["text"], "|", beside["headlines"][0]["text"], "|", beside["warnings"])
        self.assertGreater(beside["repeats"], 2)
        self.assertTrue(beside["warnings"])
        for verdict in beside["verdicts"]:
            same = first.get(verdict["error"])
            if same and not verdict["close"] and not same["close"]:
                self.assertEqual(verdict["arrived"][0]["row"], same["arrived"][0]["row"], verdict["text"])


if __name__ == "__main__":
    unittest.main()
