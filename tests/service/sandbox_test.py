"""What bounds the files a worker may open: the kernel's Landlock of any version, or a mount namespace. Work is done
under each alike, and whoever asks is told which it is. What is forbidden is tried in
tests/unit/worker/forbidden_acts_test.cpp."""

import os
import pathlib
import subprocess
import unittest

import tiny_scene
from photond_daemon import BIN, Daemon, small_job


def processes(status):
    return [*status["workers"], *status["helpers"], status["pictures"]]


def access_of(daemon):
    """What bounds the files of its processes: the same of each, or an AssertionError."""
    def told():
        accesses = [process["file_access"] for process in processes(daemon.request("GET", "/v1/status").json)]
        return all(accesses) and accesses

    found = {(access["by"], access["version"]) for access in daemon.wait_until(told, "every process says what it has")}
    assert len(found) == 1, found
    return found.pop()


class SandboxTest(unittest.TestCase):
    def daemon(self, version):
        daemon = Daemon(environment={"PHOTOND_LANDLOCK_VERSION": version} if version else {})
        self.addCleanup(daemon.close)
        daemon.wait_ready()
        return daemon

    def do_everything(self, daemon):
        """Reads, writes and loads what the processes do: uploads, jobs that go on, films, images, pictures."""
        scene = daemon.request("POST", "/v1/scenes", body=tiny_scene.glb(),
                               headers={"Content-Type": "model/gltf-binary"})
        self.assertEqual(scene.status, 201, scene)
        job = daemon.run_job({**small_job(size=16, passes=2), "scene": scene.json["id"]})
        photons = daemon.run_job({**small_job(size=16, passes=2), "method": {"name": "photon_mapping", "parameters": {
            "photons": 1000, "gather": "direct", "keep_photon_map": True}}, "reference": {
                "method": {"name": "path_tracing"}, "stop": {"passes": 2}}})
        extended = daemon.request("POST", f"/v1/jobs/{job['id']}/extend", json_body={"stop": {"passes": 4}})
        self.assertEqual(extended.status, 202, extended)
        self.assertEqual(daemon.wait_for_job(job["id"])["passes_done"], 4)
        ours, other = f"/v1/jobs/{job['id']}", f"/v1/jobs/{photons['id']}"
        for path in (f"{ours}/image.exr", f"{ours}/film", f"{ours}/preview.png", f"{other}/flip.png",
                     f"{other}/photon_map.glb", f"/v1/scenes/{scene.json['id']}/preview.png"):
            self.assertEqual(daemon.request("GET", path).status, 200, path)
        frames = daemon.request("POST", "/v1/sequences", json_body={
            **small_job(size=16, passes=1), "scene": "moving/teleport", "frames": 2}).json
        video = f"/v1/sequences/{frames['id']}/video?format=mp4"
        daemon.wait_for_state(f"/v1/sequences/{frames['id']}", ("succeeded",))
        self.assertEqual(daemon.request("GET", video).body[4:8], b"ftyp")
        image = daemon.request("GET", f"{ours}/image.exr").body
        added = daemon.request("POST", "/v1/images", body=image, headers={"Content-Type": "image/x-exr"})
        self.assertEqual(added.status, 201, added)

    def test_work_is_done_under_the_kernels_own(self):
        daemon = self.daemon(None)
        self.do_everything(daemon)
        by, version = access_of(daemon)
        self.assertIn(by, ("landlock", "mount_namespace", "none"))
        self.assertEqual(version is not None, by == "landlock")
        for process in processes(daemon.request("GET", "/v1/status").json):
            status = pathlib.Path(f"/proc/{process['pid']}/status").read_text()
            self.assertRegex(status, r"NoNewPrivs:\s1\n", process)
            self.assertRegex(status, r"Seccomp:\s2\n", process)
        if os.geteuid() != 0:  # who is not root sees that they are not dumpable
            children = [process["pid"] for process in processes(daemon.request("GET", "/v1/status").json)]
            for pid in (daemon.process.pid, *children):
                with self.assertRaises(PermissionError):
                    os.listdir(f"/proc/{pid}/fd")

    def test_work_is_done_under_the_second_version(self):
        daemon = self.daemon("2")
        if access_of(daemon)[0] != "landlock":
            self.skipTest("this kernel has no Landlock")
        self.assertEqual(access_of(daemon), ("landlock", 2))
        self.do_everything(daemon)

    def test_work_is_done_without_landlock_and_the_doctor_says_what_there_is(self):
        daemon = self.daemon("0")
        by, version = access_of(daemon)
        self.assertIn((by, version), (("mount_namespace", None), ("none", None)))
        self.do_everything(daemon)
        told = subprocess.run([BIN / "photonctl", "doctor", "--server", f"http://127.0.0.1:{daemon.port}"],
                              capture_output=True, text=True).stdout
        self.assertRegex(told, r"warn +sandbox +none: workers may open any file" if by == "none" else
                         r"ok +sandbox +the workers' files are bounded by a mount namespace")


if __name__ == "__main__":
    unittest.main()
