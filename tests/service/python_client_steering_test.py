"""The Python client steers a queue: priorities of waiting jobs, and what a comparison would take before it is queued."""

import time
import unittest

from python_client_case import Case, fixture, photond

setUpModule, tearDownModule = fixture.start, fixture.stop


class Steering(Case):
    def test_priorities_change_while_a_job_waits(self):
        first, low, high = self.long_job(), self.long_job(), self.long_job()
        self.assertEqual(high.reprioritise(50).request["priority"], 50)
        self.assertEqual(self.daemon.job(high.id)["request"]["priority"], 50)
        with self.assertRaises(photond.Invalid):
            low.reprioritise(101)
        first.cancel().wait(check=False)
        while high.refresh().state == "queued":
            time.sleep(0.02)
        self.assertEqual(low.refresh().state, "queued")
        low.cancel()
        high.cancel().wait(check=False)
        with self.assertRaises(photond.WrongState):
            high.reprioritise(1)

    def test_what_it_would_take(self):
        entries = ["path_tracing", photond.entry("photon_mapping", sweep={"photons": [500, 2000]})]
        options = {"width": 32, "height": 32, "seconds": 2, "reference": "path_tracing:4", "seeds": [1, 2]}
        before = self.client.count_jobs()
        estimate = self.client.estimate_comparison("cornell-box", entries, **options)
        self.assertEqual((estimate.data["jobs"], len(estimate.data["entries"])), (6, 3))
        self.assertEqual(self.client.count_jobs(), before)
        with self.assertRaises(photond.Invalid) as raised:
            self.client.estimate_comparison("cornell-box", ["path_trcing"], **options)
        self.assertEqual(raised.exception.faults[0].pointer, "/entries/0/method/name")
        self.assertEqual(raised.exception.faults[0].code, "unknown_name")


if __name__ == "__main__":
    unittest.main()
