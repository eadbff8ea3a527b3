"""Pictures beside a job: its clock does not notice them, and who asks again gets them. Counts, order and states are asserted;
how much of a job's passes pictures cost is printed, and asserted in the long form alone, on an idle machine."""

import os
import signal
import statistics
import threading
import time
import unittest

from photond_daemon import UNDER_SANITIZER, DaemonTestCase, processor_ticks, small_job, wait_until_at_rest

IDLE_CLASS = 5  # SCHED_IDLE
ENDLESS = 100_000_000  # passes


def preview(number, size=16, passes=1):
    return f"/v1/scenes/cornell-box/preview.png?width={size + number}&height={size}&passes={passes}"


class PicturesBesideAJob(DaemonTestCase):
    """The job's worker is halted in the middle of it. To the daemon that job renders, whose clock must not notice; pictures then
    do not have to share the processors with it. The long form measures what a job that does render notices.
    """

    daemon_arguments = ("--heartbeat-timeout", 86_400)  # a worker that is halted is none that hangs

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.reference = cls.daemon.run_job(small_job(size=64, passes=2, seed=2))["id"]
        cls.daemon.request("GET", f"/v1/jobs/{cls.reference}/image.exr")  # the helper has loaded its library then
        cls.measured = cls.daemon.run_job(small_job(size=64, passes=2, reference=f"job:{cls.reference}"))["id"]

    def setUp(self):
        self.job = self.daemon.submit(small_job(size=64, passes=ENDLESS))["id"]
        self.daemon.wait_for_passes(self.job)
        self.worker = self.daemon.workers()["cpu"]
        os.kill(self.worker, signal.SIGSTOP)

    def tearDown(self):
        os.kill(self.worker, signal.SIGCONT)
        self.daemon.request("DELETE", f"/v1/jobs/{self.job}")
        self.daemon.wait_for_job(self.job)

    def status(self):
        return self.daemon.request("GET", "/v1/status").json

    def fetched(self, path):
        """The reply that is no "ask again". Who draws is of the lowest class: other tests come first."""
        def answered():
            reply = self.daemon.request("GET", path)
            if reply.status != 503:
                return reply
            self.assertEqual(reply.json["code"], "unavailable")
            self.assertEqual(reply.headers["retry-after"], "5")
            return None
        return self.daemon.wait_until(answered, f"{path} is drawn", job=self.job, look_every_s=0.5)

    def test_they_are_drawn_by_a_process_of_the_lowest_class(self):
        pid = self.status()["pictures"]["pid"]
        self.assertEqual(os.sched_getscheduler(pid), IDLE_CLASS)
        for worker in self.status()["workers"]:
            self.assertNotEqual(worker["pid"], pid)
            self.assertNotEqual(os.sched_getscheduler(worker["pid"]), IDLE_CLASS)

        [helper] = [worker["pid"] for worker in self.status()["workers"] if worker["device"] == "none"]
        if not UNDER_SANITIZER:  # where the helper looks at the built-in scenes for minutes after a start
            wait_until_at_rest(lambda: [helper])
        before = processor_ticks(helper), processor_ticks(pid)
        reply = self.fetched(preview(0, 128, 16))
        self.assertEqual((reply.status, reply.body[:4]), (200, b"\x89PNG"))
        after = processor_ticks(helper), processor_ticks(pid)
        if not UNDER_SANITIZER:
            self.assertGreater(after[1] - before[1], 3 * (after[0] - before[0]),
                               "the helper draws nothing beside a job")
        self.assertEqual(self.daemon.request("GET", preview(0, 128, 16)).body, reply.body, "it is kept")

    def test_a_bad_one_fails_with_its_own_words(self):
        reply = self.fetched("/v1/scenes/cornell-box/preview.png?eye=1,2,3&target=1,2,3")
        self.assertEqual(reply.status, 422)

    def test_the_line_is_short_and_answers_come_soon(self):
        before = self.daemon.job(self.job)["passes_done"]
        replies = []

        def ask(number):
            begun = time.monotonic()
            reply = self.daemon.request("GET", preview(number))
            replies.append((number, reply.status, time.monotonic() - begun))

        threads = [threading.Thread(target=ask, args=(number,)) for number in range(24)]
        for thread in threads:
            thread.start()
        waiting = 0
        while any(thread.is_alive() for thread in threads):
            waiting = max(waiting, self.status()["pictures"]["waiting"])
            time.sleep(0.05)
        self.assertEqual({status for _, status, _ in replies} - {200, 503}, set())
        self.assertGreaterEqual(sum(status == 503 for _, status, _ in replies), 24 - 16, replies)
        self.assertLessEqual(waiting, 16)
        self.assertGreater(waiting, 0)
        # The line moves on between two answers: they agree when none was drawn in between.
        self.daemon.wait_until(lambda: f"photond_pictures_waiting {self.status()['pictures']['waiting']}\n"
                               in self.daemon.request("GET", "/metrics").text, "the metrics say as the status does")
        os.kill(self.worker, signal.SIGCONT)
        self.daemon.wait_for_passes(self.job, before + 1)
        os.kill(self.worker, signal.SIGSTOP)
        print(sorted(seconds for *_, seconds in replies))
        number = max(number for number, status, _ in replies if status == 503)
        self.assertEqual(self.fetched(preview(number)).status, 200)

    def test_maps_of_errors_are_drawn_beside_it_too(self):
        for path in (f"/v1/jobs/{self.measured}/flip.png", f"/v1/jobs/{self.measured}/error.png",
                     f"/v1/flip?image=job:{self.measured}&reference=job:{self.reference}"):
            with self.subTest(path):
                reply = self.fetched(path)
                self.assertEqual(reply.status, 200, reply)
        image = self.daemon.request("GET", f"/v1/jobs/{self.measured}/image.exr")
        self.assertEqual(image.status, 200, "what somebody asked for is there at once")


class PicturesOfASlowPass(DaemonTestCase):
    """A preview of a job that runs is of the film so far, whatever the pass at hand takes."""

    daemon_arguments = ("--threads", 1, "--heartbeat-timeout", 86_400)  # a worker that is halted is none that hangs
    asks_again = {"Prefer": "handling=strict, respond-async"}

    def setUp(self):
        self.job = self.daemon.submit(small_job(size=384, passes=ENDLESS))["id"]
        self.daemon.wait_for_passes(self.job)
        self.path = f"/v1/jobs/{self.job}/preview.png?max_size=64"
        self.addCleanup(self.daemon.wait_for_job, self.job)
        self.addCleanup(self.daemon.request, "DELETE", f"/v1/jobs/{self.job}")

    def passes(self):
        return self.daemon.job(self.job)["passes_done"]

    def test_who_asks_again_is_answered_within_the_pass(self):
        self.assertEqual(self.daemon.request("GET", self.path).status, 200)

        def answered_within_a_pass():
            before = self.passes()
            begun = time.monotonic()
            reply = self.daemon.request("GET", self.path, headers=self.asks_again)
            print(f"answered {reply.status} after {time.monotonic() - begun:.3f} s")
            self.assertEqual(reply.status, 200, "an older picture is one too")
            return self.passes() == before

        for _ in range(3):  # a pass may end meanwhile
            self.daemon.wait_until(answered_within_a_pass, "an answer does not wait for the pass", job=self.job)

    def test_what_was_asked_for_is_there_after_the_pass(self):
        reply = self.daemon.request("GET", self.path, headers=self.asks_again)
        if reply.status != 200:  # the pass ended meanwhile
            self.assertEqual((reply.status, reply.headers["retry-after"], reply.body), (202, "1", b""))
        seen = {}

        def followed_for_four_passes():
            passes = self.passes()
            reply = self.daemon.request("GET", self.path, headers=self.asks_again)
            if reply.status == 200:
                seen.setdefault(reply.headers["etag"], passes)
            return len(seen) > 3

        self.daemon.wait_until(followed_for_four_passes, "a new picture after each pass", job=self.job)
        print("new pictures after the passes", list(seen.values()))

    def test_a_scene_is_drawn_meanwhile(self):
        reply = self.daemon.request("GET", preview(3, 64), headers=self.asks_again)
        self.assertEqual((reply.status, reply.headers["retry-after"], reply.body), (202, "1", b""))
        worker = self.daemon.workers()["cpu"]
        os.kill(worker, signal.SIGSTOP)  # the pass at hand takes as long as the picture
        self.addCleanup(os.kill, worker, signal.SIGCONT)
        self.daemon.wait_until(lambda: self.daemon.request("GET", preview(3, 64), headers=self.asks_again).status == 200,
                               "the picture that was asked for is drawn", job=self.job)


class PicturesAlone(DaemonTestCase):
    def test_they_are_drawn_at_once(self):
        for number in range(3):
            self.assertEqual(self.daemon.request("GET", preview(number)).status, 200)
        self.assertEqual(self.daemon.request("GET", "/v1/status").json["pictures"]["waiting"], 0)


@unittest.skipUnless("PHOTOND_LONG" in os.environ, "takes an idle machine")
class LongPictures(DaemonTestCase):
    """A hundred previews during a job of ten seconds change its passes by 5 % at the most."""

    def passes(self):
        return self.daemon.run_job(small_job(size=128, passes=None, stop={"seconds": 10}))["passes_done"]

    def test_a_job_does_not_notice_a_hundred_previews(self):
        ratios = []
        for turn in range(4):
            threads = [threading.Thread(target=self.daemon.request, args=("GET", preview(100 * turn + k, 100, 8)))
                       for k in range(100)]
            alone = self.passes()
            job = threading.Thread(target=lambda: ratios.append(self.passes() / alone))
            job.start()
            time.sleep(0.3)
            for thread in threads:
                thread.start()
                time.sleep(0.09)
            for thread in threads + [job]:
                thread.join()
        print("passes beside a hundred previews:", ratios)
        self.assertGreaterEqual(statistics.mean(ratios), 0.95)


if __name__ == "__main__":
    unittest.main()
