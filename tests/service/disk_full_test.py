"""A full disk, as it is met: the reserve that is never used answers 507 before anything is written; on a file system that
really is full, jobs fail with no_space, nothing half written is left, and all goes on when there is room again.

The second part needs a small file system: a tmpfs in mount and user namespaces of its own, into which this program
starts itself again. Where the kernel does not allow that, those tests are skipped.
"""

import contextlib
import errno
import io
import os
import pathlib
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

import tiny_scene
from photond_daemon import PATIENCE, Daemon, small_job

INSIDE = "PHOTOND_TEST_HAS_NAMESPACES"
MIB = 1 << 20
SECONDS = 3 * PATIENCE  # of a job that ends after the disk is full
HDR = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + bytes([128, 128, 128, 129]) * 2
ALL_LAYERS = ["caustic", "albedo", "normal", "position", "depth", "standard_error"]


class DiskCase(unittest.TestCase):
    def assert_no_space(self, reply):
        self.assertEqual((reply.status, reply.headers["content-type"]), (507, "application/problem+json"), reply)
        self.assertEqual((reply.json["code"], reply.json["status"]), ("no_space", 507), reply)

    def uploads(self, daemon, seed):
        """The answers to every kind of upload."""
        form_type, form = tiny_scene.form(tiny_scene.gltf_files(seed + 2))
        for path, media_type, body in (("/v1/scenes", "model/gltf-binary", tiny_scene.glb(seed)),
                                       ("/v1/scenes", "application/zip", tiny_scene.zipped(tiny_scene.gltf_files(seed + 1))),
                                       ("/v1/scenes", form_type, form),
                                       ("/v1/images", "image/vnd.radiance", HDR)):
            yield daemon.request("POST", path, body=body, headers={"Content-Type": media_type})

    @staticmethod
    def files(daemon, *folders):
        data = pathlib.Path(daemon.data_dir)
        return sorted(str(path.relative_to(data)) for folder in folders for path in (data / folder).rglob("*"))


class ReserveTest(DiskCase):
    def test_nothing_is_taken_that_would_touch_the_reserve(self):
        with tempfile.TemporaryDirectory(prefix="photond-test-") as around:
            folder = around + "/data"  # the log is written beside it
            with Daemon(data_dir=folder) as daemon:
                daemon.wait_ready()
                done = daemon.wait_for_job(daemon.submit(small_job(size=16))["id"])
                self.assertEqual(done["state"], "succeeded", done)
            with Daemon("--disk-reserve", 1 << 60, data_dir=folder) as daemon:
                daemon.wait_ready()
                before = self.files(daemon, "spool", "scenes", "images", "films", "cache")
                for reply in self.uploads(daemon, 40):
                    self.assert_no_space(reply)
                    self.assertIn(str(1 << 60), reply.json["detail"])
                self.assert_no_space(daemon.request("POST", "/v1/jobs", json_body=small_job()))
                # An image that would have to be encoded first is a file too.
                self.assert_no_space(daemon.request("GET", f"/v1/jobs/{done['id']}/image.exr"))
                self.assertEqual(self.files(daemon, "spool", "scenes", "images", "films", "cache"), before)
                # What needs no disk is answered as ever.
                for path in ("/healthz", "/readyz", "/v1/status", "/v1/scenes", "/v1/jobs", f"/v1/jobs/{done['id']}"):
                    self.assertEqual(daemon.request("GET", path).status, 200, path)
                self.assertEqual(daemon.request("POST", "/v1/jobs?dry_run=true", json_body=small_job()).status, 200)
                self.assertEqual(len(daemon.request("GET", "/v1/jobs").json["items"]), 1)
            with Daemon(data_dir=folder) as daemon:
                daemon.wait_ready()
                for reply in self.uploads(daemon, 40):
                    self.assertEqual(reply.status, 201, reply)
                self.assertEqual(daemon.request("GET", f"/v1/jobs/{done['id']}/image.exr").status, 200)


@unittest.skipUnless(os.environ.get(INSIDE), "no namespaces of our own here: no small file system can be mounted")
class FullDiskTest(DiskCase):
    SIZE = 64 * MIB
    LEFT = 4 * MIB  # enough for the store and small films; the large job's takes 33 MB

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="photond-test-")
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={self.SIZE}", "tmpfs", self.folder], check=True)
        self.addCleanup(os.rmdir, self.folder)
        self.addCleanup(subprocess.run, ["umount", self.folder], check=True)
        self.data = pathlib.Path(self.folder) / "data"
        self.filler = pathlib.Path(self.folder) / "filler"
        self.daemon = Daemon("--disk-reserve", 0, "--threads", 1, "--save-seconds", 0, data_dir=self.data, start=False)
        self.daemon.log_path = pathlib.Path(self.folder + ".log")  # not on the disk that will be full
        self.addCleanup(self.daemon.log_path.unlink)
        self.addCleanup(self.daemon.close)
        self.daemon.start()
        self.daemon.wait_ready()

    def fill(self, left):
        """Leaves that many bytes of the disk, to the page."""
        with open(self.filler, "ab") as file:
            while True:
                disk = os.statvfs(self.folder)
                excess = disk.f_bavail * disk.f_frsize - left
                if excess <= 0:
                    return
                try:
                    os.posix_fallocate(file.fileno(), file.seek(0, io.SEEK_END), excess)
                except OSError as error:  # the daemon has taken some of it meanwhile
                    if error.errno != errno.ENOSPC:
                        raise

    def large_job(self, **stop):
        return {**small_job(size=256, layers=ALL_LAYERS), "stop": stop}

    @contextlib.contextmanager
    def rendering(self, job, seconds=0):
        """Within it the job has begun, and its worker is halted: it neither ends nor computes. It goes on once it has lasted
        for so many seconds, so that a job of as many ends then.
        """
        begun = time.monotonic()
        self.daemon.wait_for_passes(job)
        worker = self.daemon.workers()["cpu"]
        os.kill(worker, signal.SIGSTOP)
        try:
            yield
            time.sleep(max(0, begun + seconds - time.monotonic()))
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(worker, signal.SIGCONT)

    def check_store(self):
        self.assertEqual(self.daemon.stop(), 0)
        store = sqlite3.connect(self.data / "store.sqlite")
        self.assertEqual(store.execute("PRAGMA integrity_check").fetchall(), [("ok",)])
        store.close()

    def test_a_film_that_does_not_fit_fails_its_job_and_no_other(self):
        job = self.daemon.submit(self.large_job(seconds=SECONDS))["id"]
        with self.rendering(job, SECONDS):
            self.fill(self.LEFT)
        failed = self.daemon.wait_for_job(job)
        self.assertEqual((failed["state"], failed["failure"]["code"], failed["failure"]["status"]),
                         ("failed", "no_space", 507), failed)
        self.assertEqual(len(failed["attempts"]), 1, "its own fault: not tried again")
        self.assertEqual(self.files(self.daemon, "films", "spool"), [])
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job}/image.exr").status, 404)
        self.assert_no_space(self.daemon.request("POST", "/v1/jobs", json_body=self.large_job(passes=1)))
        self.assert_no_space(self.daemon.request("POST", "/v1/scenes", body=bytes(2 * self.LEFT),
                                                 headers={"Content-Type": "model/gltf-binary"}))
        small = self.daemon.wait_for_job(self.daemon.submit(small_job(size=16))["id"])
        self.assertEqual(small["state"], "succeeded", small)
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{small['id']}/image.exr").status, 200)
        # Room again: no restart is needed.
        self.filler.unlink()
        self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{job}/retry").status, 202)
        self.assertEqual(self.daemon.wait_for_job(job)["state"], "succeeded")
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{job}/image.exr").status, 200)
        workers = self.daemon.request("GET", "/v1/status").json["workers"]
        self.assertEqual([worker["restarts"] for worker in workers], [0, 0])
        self.check_store()

    def test_a_photon_map_that_does_not_fit(self):
        def photon_job(photons, **stop):
            parameters = {"photons": photons, "gather": "direct", "keep_photon_map": True}
            return {**small_job(size=16), "method": {"name": "photon_mapping", "parameters": parameters}, "stop": stop}

        job = self.daemon.submit(photon_job(200_000, seconds=SECONDS))["id"]  # 64 bytes each: some 11 MB
        with self.rendering(job, SECONDS):
            self.fill(self.LEFT)
        failed = self.daemon.wait_for_job(job)
        self.assertEqual((failed["state"], failed["failure"]["code"]), ("failed", "no_space"), failed)
        self.assertIsNone(failed["links"]["photon_map"])
        self.assertEqual(self.files(self.daemon, "films"), [], "neither the map nor the film that would have fitted")
        # The next one is refused beforehand, unless it keeps no map.
        self.assert_no_space(self.daemon.request("POST", "/v1/jobs", json_body=photon_job(200_000, passes=1)))
        body = photon_job(200_000, passes=1)
        body["method"]["parameters"]["keep_photon_map"] = False
        self.assertEqual(self.daemon.wait_for_job(self.daemon.submit(body)["id"])["state"], "succeeded")
        self.filler.unlink()
        self.daemon.request("POST", f"/v1/jobs/{job}/retry")
        kept = self.daemon.wait_for_job(job)
        self.assertEqual(kept["state"], "succeeded", kept)
        self.assertEqual(self.daemon.request("GET", kept["links"]["photon_map"]).status, 200)
        # Its second name in the cache takes no second room, so that it is served even from a full disk.
        self.fill(0)
        self.assertEqual(self.daemon.request("GET", kept["links"]["photon_map"]).status, 200)
        self.filler.unlink()
        self.check_store()

    def test_answers_that_need_room_say_so(self):
        job = self.daemon.run_job(self.large_job(passes=1))["id"]
        image = self.daemon.request("POST", "/v1/images", body=HDR, headers={"Content-Type": "image/vnd.radiance"})
        self.fill(0)
        needs_room = [f"/v1/jobs/{job}/{name}" for name in ("image.exr", "preview.png", "pixels?layer=depth", "curve.csv",
                                                            "statistics.json")]
        needs_room += ["/v1/scenes/cornell-box/thumbnail.png", "/v1/scenes/cornell-box/preview.png",
                       "/v1/scenes/cornell-box/baked", f"/v1/images/{image.json['id']}/pixels"]
        for path in needs_room:
            with self.subTest(path):
                self.assert_no_space(self.daemon.request("GET", path))
        for path in (f"/v1/jobs/{job}/film", f"/v1/images/{image.json['id']}/file"):
            self.assertEqual(self.daemon.request("GET", path).status, 200, path)
        self.filler.unlink()
        for path in needs_room:
            with self.subTest(path):
                self.assertEqual(self.daemon.request("GET", path).status, 200, path)
        self.assertNotIn("defect", self.daemon.log())

    def test_a_start_on_a_full_disk(self):
        """What was running cannot even be recorded: reads are served, and all goes on when there is room."""
        done = self.daemon.wait_for_job(self.daemon.submit(small_job(size=16))["id"])
        image = self.daemon.request("GET", f"/v1/jobs/{done['id']}/pixels").body
        job = self.daemon.submit(small_job(size=64, passes=100_000_000))["id"]
        self.daemon.wait_for_passes(job)
        self.daemon.kill()
        self.fill(0)
        self.daemon.start()
        self.daemon.wait_ready()
        for path in ("/v1/jobs", f"/v1/jobs/{done['id']}", f"/v1/jobs/{job}", f"/v1/jobs/{done['id']}/film", "/metrics"):
            self.assertEqual(self.daemon.request("GET", path).status, 200, path)
        self.assertEqual(self.daemon.job(done["id"]), done)
        self.assert_no_space(self.daemon.request("POST", "/v1/jobs", json_body=self.large_job(passes=1)))
        self.assertIn("no room to record what was running", self.daemon.log())
        self.filler.unlink()
        self.daemon.wait_for_job_that(lambda job: job["attempts"][0]["outcome"] == "lost", "to have lost its attempt", job)
        self.assertTrue(self.daemon.request("GET", "/v1/status").json["store"]["recovered"])
        self.daemon.request("DELETE", f"/v1/jobs/{job}")
        self.daemon.wait_for_job(job)
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{done['id']}/pixels").body, image)
        self.assertEqual(self.daemon.wait_for_job(self.daemon.submit(small_job(size=16))["id"])["state"], "succeeded")
        self.check_store()

    def test_not_a_byte_left(self):
        """Not even the store can be written: what a job came to is kept in memory until it can."""
        kept = self.daemon.wait_for_job(self.daemon.submit(small_job(size=16), "kept")["id"])
        job = self.daemon.submit(self.large_job(seconds=SECONDS))["id"]
        with self.rendering(job, SECONDS):
            self.fill(0)
        for reply in self.uploads(self.daemon, 50):
            self.assert_no_space(reply)
        # The first may still find room within the log's last page.
        replies = [self.daemon.request("POST", "/v1/jobs", json_body=small_job(size=16, seed=i)) for i in range(1, 21)]
        self.assert_no_space(replies[-1])
        accepted = [reply.json["id"] for reply in replies if reply.status == 202]
        for reply in replies:
            if reply.status != 202:
                self.assert_no_space(reply)
        self.daemon.wait_until(lambda: f"job {job}: its end cannot be recorded yet" in self.daemon.log(),
                               "the daemon says that it cannot record the end", job=job)
        self.assertEqual(self.daemon.job(job)["state"], "running")
        for path in ("/healthz", "/readyz", "/v1/jobs", f"/v1/jobs/{kept['id']}", f"/v1/jobs/{job}", "/metrics"):
            self.assertEqual(self.daemon.request("GET", path).status, 200, path)
        self.filler.unlink()
        failed = self.daemon.wait_for_job(job)
        self.assertEqual((failed["state"], failed["failure"]["code"]), ("failed", "no_space"), failed)
        for other in accepted:
            self.assertEqual(self.daemon.wait_for_job(other)["state"], "succeeded")
        self.assertEqual(self.daemon.submit(small_job(size=16), "kept")["id"], kept["id"])
        again = self.daemon.wait_for_job(self.daemon.submit(small_job(size=16))["id"])
        self.assertEqual(again["statistics"]["pixel_hash"], kept["statistics"]["pixel_hash"])
        ids = [item["id"] for item in self.daemon.request("GET", "/v1/jobs?limit=1000").json["items"]]
        self.assertEqual(sorted(ids), sorted({kept["id"], job, *accepted, again["id"]}))
        for reply in self.uploads(self.daemon, 50):
            self.assertEqual(reply.status, 201, reply)
        self.assertEqual(self.files(self.daemon, "spool"), [])
        self.check_store()


del DiskCase  # a base, not a test case
if __name__ == "__main__":
    if INSIDE not in os.environ and subprocess.run(["unshare", "--map-root-user", "--mount", "true"], check=False,
                                                   stderr=subprocess.DEVNULL).returncode == 0:
        os.execvpe("unshare", ["unshare", "--map-root-user", "--mount", sys.executable, *sys.argv],
                   {**os.environ, INSIDE: "1"})
    unittest.main()
