"""Hostile scene uploads over HTTP: every hand-made malformed glTF, archives that are not what they claim, bodies that are
too large or end too soon. Each gets a problem that says where the fault lies; nothing of it stays on the disk, nothing
outside the spool is touched, and neither the daemon nor its helper notices.
"""

import io
import json
import os
import pathlib
import re
import socket
import tempfile
import unittest
import warnings
import zipfile

import malformed_gltf
import tiny_scene
from photond_daemon import BIN, Daemon

GLB = "model/gltf-binary"
ZIP = "application/zip"


def zipped(entries, method=zipfile.ZIP_DEFLATED):
    data = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # zipfile's own about two entries of one name
        with zipfile.ZipFile(data, "w", method) as archive:
            for name, content in entries:
                archive.writestr(name, content)
    return data.getvalue()


def special(name, mode):
    entry = zipfile.ZipInfo(name)
    entry.create_system, entry.external_attr = 3, mode << 16
    return entry


class UploadCase(unittest.TestCase):
    options = ()

    @classmethod
    def setUpClass(cls):
        # A folder of its own around the daemon's, so that whatever leaves the one is seen in the other.
        cls.around = tempfile.TemporaryDirectory(prefix="photond-test-")
        cls.daemon = Daemon(*cls.options, data_dir=pathlib.Path(cls.around.name) / "data")
        cls.daemon.wait_ready()
        cls.daemon.request("GET", "/v1/scenes?limit=1000")  # the built-in scenes have been judged: the helper is at rest

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()
        cls.around.cleanup()

    def setUp(self):
        self.before = self.state()

    def tearDown(self):
        self.assertEqual(self.state(), self.before)

    def state(self):
        """What no refused upload may change."""
        status = self.daemon.request("GET", "/v1/status").json
        scenes = self.daemon.request("GET", "/v1/scenes?limit=1000").json["items"]
        return {"processes": [(process["pid"], process["restarts"]) for process in status["workers"] + status["helpers"]],
                "scenes": [scene["id"] for scene in scenes],
                "files": self.files(),
                "around": sorted(os.listdir(self.around.name))}

    def files(self):
        data = pathlib.Path(self.daemon.data_dir)
        return sorted(str(path.relative_to(data)) for folder in ("spool", "scenes", "images", "films")
                      for path in (data / folder).rglob("*"))

    def helper_peak_bytes(self):
        helpers = self.daemon.request("GET", "/v1/status").json["helpers"]
        [pid] = [helper["pid"] for helper in helpers if helper["name"] == "bulk"]
        return int(re.search(r"VmHWM:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text())[1]) << 10

    def post(self, body, media_type):
        return self.daemon.request("POST", "/v1/scenes", body=body, headers={"Content-Type": media_type})

    def assert_refused(self, reply, status, code):
        self.assertEqual((reply.status, reply.headers["content-type"]), (status, "application/problem+json"), reply)
        self.assertEqual((reply.json["code"], reply.json["status"], reply.json["instance"]),
                         (code, status, "/v1/scenes"), reply)
        self.assertTrue(reply.json["detail"], reply)

    def assert_good_scene_is_taken(self):
        reply = self.post(tiny_scene.glb(3), GLB)
        self.assertEqual(reply.status, 201, reply)
        self.assertEqual(self.daemon.request("DELETE", f"/v1/scenes/{reply.json['id']}").status, 200)


class MalformedGltfTest(UploadCase):
    def test_every_malformed_file(self):
        sound = self.post(malformed_gltf.valid(), GLB)
        self.assertEqual(sound.status, 201, sound)
        self.assertEqual(self.daemon.request("DELETE", f"/v1/scenes/{sound.json['id']}").status, 200)
        posted, before, largest = 0, self.helper_peak_bytes(), 0
        for case in malformed_gltf.cases():
            forms = [(GLB, case.data)]
            if not case.data.startswith(b"glTF") and posted % 2:  # text: as a .gltf in a form as well
                forms.append(tiny_scene.form({"scene.gltf": case.data}))
            for media_type, body in forms:
                with self.subTest(case.name, form=media_type != GLB):
                    reply = self.post(body, media_type)
                    self.assert_refused(reply, 422, case.code)
                    pointers = [error["pointer"] for error in reply.json["errors"]]
                    if case.pointer or pointers:
                        self.assertIn(case.pointer, pointers, reply)
                    self.assertEqual(len({json.dumps(error) for error in reply.json["errors"]}), len(pointers), reply)
                    self.assertEqual(self.files(), self.before["files"])
            posted += 1
            largest = max(largest, len(case.data))
        self.assertGreater(posted, 250)
        growth = self.helper_peak_bytes() - before
        print(f"\n{posted} files, the largest of {largest >> 20} MiB: the helper's peak grew by {growth >> 20} MiB")
        # reliability.md, "Malformed scenes and jobs". A sanitizer's shadow and quarantine are not the helper's.
        if b"__asan_init" not in (BIN / "photond-worker").read_bytes():
            self.assertLess(growth, largest + (256 << 20))
        self.assert_good_scene_is_taken()

    def test_a_glb_that_ends_too_soon(self):
        whole = malformed_gltf.valid()
        for length in (0, 1, 4, 11, 12, 19, 20, 21, 400, len(whole) // 2, len(whole) - 4, len(whole) - 1):
            with self.subTest(length):
                self.assert_refused(self.post(whole[:length], GLB), 422, "bad_scene")
        # The same file whole, but the connection ends within its body: nothing is judged, nothing stays.
        with socket.create_connection((self.daemon.address, self.daemon.port)) as client:
            client.sendall(f"POST /v1/scenes HTTP/1.1\r\nHost: {self.daemon.address}\r\nContent-Type: {GLB}\r\n"
                           f"Content-Length: {len(whole)}\r\n\r\n".encode() + whole[:-7])
            client.shutdown(socket.SHUT_WR)
            answer = b""
            while piece := client.recv(4096):
                answer += piece
            self.assertNotIn(b" 201 ", answer)
        self.assert_good_scene_is_taken()


class MalformedArchiveTest(UploadCase):
    GOOD = [("scene.glb", tiny_scene.glb())]

    def test_names_that_leave_the_folder(self):
        names = ["../evil", "a/../../evil", "../../../../../../tmp/evil", "/etc/evil", "/", "//evil", "a//evil", "./evil",
                 "a/./evil", "a/..", "..", ".", "..\\evil", "a\\b", "C:evil", "C:\\evil", "a\nb", "a\x01b", "x" * 300,
                 "a/" * 40 + "evil", "textures/../../scene.glb", "%2e%2e/../evil", "a/../scene.glb"]
        for name in names:
            for first in (True, False):
                with self.subTest(name, first=first):
                    entries = [(name, b"evil")] + self.GOOD if first else self.GOOD + [(name, b"evil")]
                    self.assert_refused(self.post(zipped(entries), ZIP), 422, "bad_scene")
                    self.assertEqual(self.files(), self.before["files"])
        self.assert_good_scene_is_taken()

    def test_entries_that_are_no_plain_files(self):
        for kind, mode in (("link", 0o120777), ("fifo", 0o010644), ("device", 0o020666), ("block", 0o060666),
                           ("socket", 0o140777)):
            for name, content in (("mesh.bin", b"/etc/passwd"), ("scene.gltf", b"/etc/hostname"), ("dir", b"/")):
                with self.subTest(kind, name=name):
                    reply = self.post(zipped([*self.GOOD, (special(name, mode), content)]), ZIP)
                    self.assert_refused(reply, 422, "bad_scene")
        # A link, and then a file through it.
        through = zipped([*self.GOOD, (special("out", 0o120777), b".."), ("out/evil", b"evil")])
        self.assert_refused(self.post(through, ZIP), 422, "bad_scene")

    def test_bombs(self):
        bomb = zipped([*self.GOOD, ("zeros.bin", bytes(64 << 20))])
        self.assertLess(len(bomb), 100_000)
        reply = self.post(bomb, ZIP)
        self.assert_refused(reply, 422, "bad_scene")
        self.assertIn("ratio", reply.json["detail"])
        many = zipped([*self.GOOD, *((f"f{i}", b"") for i in range(10_001))])
        self.assert_refused(self.post(many, ZIP), 422, "bad_scene")
        # Sizes that lie: what the directory states is less than what comes out.
        honest = zipped([("scene.glb", tiny_scene.glb()), ("data.bin", os.urandom(100_000))])
        lying = honest.replace((100_000).to_bytes(4, "little"), (50_000).to_bytes(4, "little"))
        self.assertNotEqual(honest, lying)
        self.assert_refused(self.post(lying, ZIP), 422, "bad_scene")

    def test_archives_without_one_good_scene(self):
        whole = zipped(self.GOOD)
        broken = bytearray(zipped([("scene.glb", os.urandom(4096))]))
        broken[2000] ^= 0xff
        archives = {"empty": b"", "no archive": b"not an archive", "no entries": zipped([]), "cut": whole[:-30],
                    "half": whole[:len(whole) // 2], "damaged": bytes(broken),
                    "no scene": zipped([("readme.txt", b"x"), ("a/b.bin", b"y")]),
                    "two scenes": zipped([("a.gltf", b"{}"), ("b.glb", b"x")]),
                    "twice": zipped([*self.GOOD, *self.GOOD]),
                    "a folder named like one": zipped([("scene.gltf/", b"")]),
                    "another packing": zipped(self.GOOD, zipfile.ZIP_LZMA)}
        for name, body in archives.items():
            with self.subTest(name):
                self.assert_refused(self.post(body, ZIP), 422, "bad_scene")
        # The archive is sound, the glTF in it is not: its pointers come through.
        files = tiny_scene.gltf_files(4)
        document = json.loads(files["scene.gltf"])
        document["nodes"][0]["mesh"] = 7
        files["scene.gltf"] = json.dumps(document).encode()
        reply = self.post(tiny_scene.zipped(files), ZIP)
        self.assert_refused(reply, 422, "bad_scene")
        self.assertEqual([error["pointer"] for error in reply.json["errors"]], ["/nodes/0/mesh"])

    def test_a_gltf_that_asks_for_files_outside(self):
        secret = pathlib.Path(self.around.name) / "secret.bin"
        secret.write_bytes(os.urandom(42))
        try:
            for uri in ("../../../secret.bin", str(secret), f"file://{secret}", "data/../../../../secret.bin",
                        "http://127.0.0.1/mesh.bin", "%2e%2e/%2e%2e/%2e%2e/secret.bin", "..%2f..%2f..%2fsecret.bin"):
                files = tiny_scene.gltf_files(5)
                document = json.loads(files["scene.gltf"])
                document["buffers"][0]["uri"] = uri
                files["scene.gltf"] = json.dumps(document).encode()
                for media_type, body in ((ZIP, tiny_scene.zipped(files)), tiny_scene.form(files)):
                    with self.subTest(uri, media_type=media_type[:15]):
                        reply = self.post(body, media_type)
                        self.assert_refused(reply, 422, "bad_scene")
                        self.assertIn("/buffers/0", "".join(error["pointer"] for error in reply.json["errors"]))
        finally:
            secret.unlink()


class TooLargeTest(UploadCase):
    LIMIT = 1 << 20
    options = ("--max-body", LIMIT)

    def test_a_body_over_the_limit(self):
        too_large = tiny_scene.glb() + bytes(self.LIMIT)
        for media_type, body in ((GLB, too_large), (ZIP, zipped([("scene.glb", os.urandom(self.LIMIT))])),
                                 tiny_scene.form({"scene.gltf": b"{}", "mesh.bin": bytes(self.LIMIT)})):
            with self.subTest(media_type):
                reply = self.post(body, media_type)
                self.assert_refused(reply, 413, "payload_too_large")
                self.assertIn(str(self.LIMIT), reply.json["detail"])
        # Judged by the head: the answer comes although not a byte of the body has been sent.
        with socket.create_connection((self.daemon.address, self.daemon.port)) as client:
            client.sendall(f"POST /v1/scenes HTTP/1.1\r\nHost: {self.daemon.address}\r\nContent-Type: {GLB}\r\n"
                           f"Content-Length: {self.LIMIT + 1}\r\n\r\n".encode())
            self.assertTrue(client.recv(4096).startswith(b"HTTP/1.1 413 "))
        self.assert_good_scene_is_taken()


del UploadCase  # a base, not a test case
if __name__ == "__main__":
    unittest.main()
