"""Helpers that do not answer keep nobody else from an answer: uploads wait apart from pictures, and what needs no helper
waits for none. A helper is stopped (SIGSTOP) where a hostile file would hold it. Order and states are asserted; times are
printed, and asserted in the long form alone, on an idle machine."""

import contextlib
import os
import signal
import struct
import tempfile
import threading
import time
import unittest

import numpy
import OpenImageIO as oiio

from image_files import encoded
from photond_daemon import DaemonTestCase, small_job


def exr_of_attributes(count):
    """A whole small EXR with so many attributes more."""
    whole = encoded(numpy.ones((4, 4, 3), numpy.float32), ["R", "G", "B"])
    more = b"".join(b"a%d\0int\0" % number + struct.pack("<II", 4, number) for number in range(count))
    return whole[:8] + more + whole[8:]  # offsets are wrong then: the number is found before them


class HelpersTest(DaemonTestCase):
    def helper(self, name):
        [helper] = [helper for helper in self.daemon.request("GET", "/v1/status").json["helpers"]
                    if helper["name"] == name]
        return helper

    @contextlib.contextmanager
    def stopped(self, name):
        pid = self.helper(name)["pid"]
        os.kill(pid, signal.SIGSTOP)
        try:
            yield
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)

    def in_background(self, *requests):
        """Begins requests; returns their threads and where the answers will be."""
        answers = [None] * len(requests)

        def ask(number):
            answers[number] = self.daemon.request(**requests[number])

        threads = [threading.Thread(target=ask, args=(number,)) for number in range(len(requests))]
        for thread in threads:
            thread.start()
        return threads, answers

    def upload(self, number):
        return {"method": "POST", "path": "/v1/images", "headers": {"Content-Type": "image/x-exr"},
                "body": encoded(numpy.full((4, 4, 3), number, numpy.float32), ["R", "G", "B"])}

    def slowest(self, *paths):
        longest = 0
        for path in paths:
            begun = time.monotonic()
            self.assertEqual(self.daemon.request("GET", path).status, 200, path)
            longest = max(longest, time.monotonic() - begun)
        return longest

    def test_nine_uploads_that_take_long_keep_nobody_waiting(self):
        job = self.daemon.run_job(small_job())["id"]
        known = self.daemon.request(**self.upload(100)).json["id"]
        with self.stopped("bulk"):
            threads, answers = self.in_background(*(self.upload(number) for number in range(9)))
            self.daemon.wait_until(lambda: self.helper("bulk")["state"] == "busy", "the helper is busy")
            longest = self.slowest(f"/v1/jobs/{job}", f"/v1/jobs/{job}/image.exr", f"/v1/jobs/{job}/film",
                                   f"/v1/jobs/{job}/preview.png", f"/v1/images/{known}", f"/v1/images/{known}/pixels",
                                   "/v1/scenes/cornell-box/thumbnail.png", "/readyz", "/v1/comparisons")
            self.assertTrue(all(thread.is_alive() for thread in threads), "an upload is answered by a stopped process")
        print(f"the slowest answer beside nine uploads: {longest * 1e3:.0f} ms")
        if "PHOTOND_LONG" in os.environ:
            self.assertLess(longest, 0.3)
        for thread in threads:
            thread.join()
        self.assertEqual([answer.status for answer in answers], [201] * 9)

    def test_what_needs_no_helper_waits_for_none(self):
        job = self.daemon.run_job(small_job(seed=5))["id"]
        with self.stopped("answers"):
            threads, answers = self.in_background(
                *({"method": "GET", "path": f"/v1/jobs/{job}/preview.png?exposure={stop}"} for stop in range(9)))
            self.daemon.wait_until(lambda: self.helper("answers")["state"] == "busy", "the helper is busy")
            self.slowest(f"/v1/jobs/{job}", f"/v1/jobs/{job}/film", f"/v1/jobs/{job}/statistics.json",
                         f"/v1/jobs/{job}/log.txt", "/v1/jobs", "/v1/comparisons", "/v1/status")
            self.assertEqual(self.daemon.request(**self.upload(50)).status, 201, "uploads have a helper of their own")
            self.daemon.wait_until(lambda: self.daemon.request("GET", "/readyz").status == 503, "it is not ready")
            reply = self.daemon.request("GET", "/readyz")
            self.assertIn("the helper that makes images and pictures has not answered for", reply.json["detail"])
            self.assertTrue(all(thread.is_alive() for thread in threads), "a picture by a stopped process")
        for thread in threads:
            thread.join()
        self.assertEqual([answer.status for answer in answers], [200] * 9)
        self.daemon.wait_ready()

    def test_what_turns_out_to_need_a_helper_leaves_the_quick_threads(self):
        job = self.daemon.run_job(small_job(seed=6))["id"]
        unknown = [f"hard-case/{name}" for name in ("corner-90", "no-light", "grazing-view")]  # nobody looks at them beforehand
        with self.stopped("answers"):
            threads, answers = self.in_background(
                *({"method": "POST", "path": path, "json_body": {**small_job(), "scene": scene}}
                  for path in ("/v1/jobs", "/v1/jobs?dry_run=true") for scene in unknown for _ in range(4)),
                {"method": "GET", "path": "/v1/scenes?family=hard-cases"},
                {"method": "GET", "path": "/v1/scenes/" + unknown[0].replace("/", "%2F")})
            self.daemon.wait_until(lambda: self.helper("answers")["state"] == "busy", "the helper is busy")
            self.slowest(f"/v1/jobs/{job}", f"/v1/jobs/{job}/log.txt", "/v1/status", "/v1/methods")
            self.assertEqual(answers, [None] * len(answers), "answered by a stopped process")
        for thread in threads:
            thread.join()
        self.assertEqual([answer.status for answer in answers], [202] * 12 + [200] * 14)
        self.assertEqual(len({answer.json["id"] for answer in answers[:12]}), 12)

    def test_a_header_of_a_hundred_thousand_attributes_is_refused_unread(self):
        reply = self.daemon.request("POST", "/v1/images", body=exr_of_attributes(100_000),
                                    headers={"Content-Type": "image/x-exr"})
        self.assertEqual((reply.status, reply.json["code"]), (422, "bad_image"))
        self.assertEqual(reply.json["detail"], "its header has more than 1000 attributes")
        self.assertEqual(self.helper("bulk")["restarts"], 0)

    @unittest.skipUnless("PHOTOND_LONG" in os.environ, "takes minutes of processor time")
    def test_pixels_that_take_long_to_decode_are_refused(self):
        side, rows, channels = 8192, 256, ["R", "G", "B", *(f"more.{number}" for number in range(5))]
        spec = oiio.ImageSpec(side, side, len(channels), "float")
        spec.channelnames = channels
        spec.attribute("compression", "zip")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "zeros.exr")  # 2 MB, of 2 GB
            image = oiio.ImageOutput.create(path)
            assert image.open(path, spec)
            for y in range(0, side, rows):
                assert image.write_scanlines(y, y + rows, 0, numpy.zeros((rows, side, len(channels)), numpy.float32))
            assert image.close()
            with open(path, "rb") as file:
                reply = self.daemon.request("POST", "/v1/images", body=file.read(),
                                            headers={"Content-Type": "image/x-exr"})
        self.assertEqual((reply.status, reply.json["code"]), (422, "bad_image"))
        self.assertIn("not done within 5.0 s of processor time", reply.json["detail"])


if __name__ == "__main__":
    unittest.main()
