"""Baked scenes: the helper's task, the route, and photonctl bake. What is in such a file is baked_scene_test's."""

import hashlib
import json
import os
import pathlib
import tempfile
import unittest
import urllib.parse

import malformed_gltf
import tiny_scene
from photonctl_case import LOCAL_FILE, REFUSED, USAGE, Case, cli, json_lines
from photond_daemon import UNDER_SANITIZER, Daemon
from worker_process import WorkerProcess

MAGIC = b"photond baked scene, version 1\n"
TEXELS = bytes((255, 128, 64, 255)) * 4  # of malformed_gltf's sound file
LARGE = "interior"


def setUpModule():
    cli.start()


def tearDownModule():
    cli.stop()


class HelperTask(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"

    def bake(self, scene, max_bytes=1 << 40, **options):
        helper = WorkerProcess("none", self.folder, **options)
        self.addCleanup(helper.close)
        helper.wait_for("hello")
        return helper.ask("bake", scene=scene, max_bytes=max_bytes, out=str(self.out))

    def test_it_writes_the_file_and_says_how_large(self):
        reply = self.bake({"id": "c", "builtin": "cornell-box"})
        self.assertIsNone(reply["failure"], reply)
        self.assertEqual(reply["result"], {"bytes": self.out.stat().st_size})
        self.assertEqual(self.out.read_bytes()[:len(MAGIC)], MAGIC)

    def assert_refused(self, reply, code, *words):
        self.assertEqual(reply["failure"]["code"], code, reply)
        for word in words:
            self.assertIn(str(word), reply["failure"]["detail"])
        self.assertEqual(os.listdir(self.folder), [], "nothing half written")

    def test_what_does_not_fit_is_refused_with_both_figures(self):
        builtin = {"id": "c", "builtin": "cornell-box"}
        size = self.bake(builtin)["result"]["bytes"]
        self.out.unlink()
        self.assert_refused(self.bake(builtin, max_bytes=size - 1), "no_space", size, size - 1, "disk")
        self.assertEqual(self.bake(builtin, max_bytes=size)["result"], {"bytes": size})

    def test_past_the_memory_limit(self):
        self.assert_refused(self.bake({"id": "i", "builtin": LARGE}, memory_limit=1 << 20), "out_of_memory", 1 << 20)


class Route(unittest.TestCase):
    def setUp(self):
        self.daemon = cli.daemon

    def get(self, scene, method="GET", **headers):
        return self.daemon.request(method, f"/v1/scenes/{urllib.parse.quote(scene, safe='')}/baked", headers=headers)

    def upload(self, data, name):
        reply = self.daemon.request("POST", f"/v1/scenes?name={name}", body=data,
                                    headers={"Content-Type": "model/gltf-binary"})
        self.assertEqual(reply.status, 201, reply)
        return reply.json

    def test_builtin_scenes(self):
        for name, file in (("cornell-box", "cornell-box.baked"),
                           ("hard-case/camera-in-glass", "hard-case-camera-in-glass.baked")):
            reply = self.get(name)
            self.assertEqual((reply.status, reply.headers["content-type"]), (200, "application/octet-stream"), name)
            self.assertEqual(reply.headers["content-disposition"], f'attachment; filename="{file}"')
            self.assertEqual(reply.body[:len(MAGIC)], MAGIC)

    def test_a_textured_upload_is_a_file_as_all_others(self):
        document, binary = malformed_gltf.document()
        document["asset"]["generator"] = "bake_test"  # no other test's scene
        textured = malformed_gltf.glb(document, binary)
        scene = self.upload(textured, "textured")
        self.assertEqual(scene["textures"], 1)
        reply = self.get("textured")
        self.assertEqual((reply.status, reply.body[:len(MAGIC)]), (200, MAGIC))
        self.assertIn(TEXELS, reply.body)
        self.assertIn(f'"{scene["id"]}.baked"', reply.headers["content-disposition"])
        etag = reply.headers["etag"]
        self.assertEqual(etag, f'"{hashlib.sha256(reply.body).hexdigest()}"')
        head = self.get(scene["id"], "HEAD")
        self.assertEqual((head.status, head.body, int(head.headers["content-length"]), head.headers["etag"]),
                         (200, b"", len(reply.body), etag))
        self.assertEqual(self.get(scene["id"], **{"If-None-Match": etag}).status, 304)
        part = self.get(scene["id"], Range="bytes=8-20")
        self.assertEqual((part.status, part.body), (206, reply.body[8:21]))
        # Deleted and sent again it is the same scene and the same file.
        self.assertEqual(self.daemon.request("DELETE", f"/v1/scenes/{scene['id']}").status, 200)
        self.assertEqual(self.get(scene["id"]).status, 404)
        self.upload(textured, "textured")
        self.assertEqual(self.get("textured").headers["etag"], etag)

    def test_refusals(self):
        for reply in (self.get("no-such-scene"), self.get("no-such-scene", "HEAD")):
            self.assertEqual(reply.status, 404)
        problem = self.get("no-such-scene").json
        self.assertEqual(problem["code"], "not_found")
        self.assertIn("no-such-scene", problem["detail"])
        reply = self.daemon.request("GET", "/v1/scenes/cornell-box/baked?precision=half")
        self.assertEqual(reply.status, 422, reply)

    @unittest.skipIf(UNDER_SANITIZER, "the helper holds more than it asked for")
    def test_a_scene_larger_than_the_helper_may_hold(self):
        size = len(self.get(LARGE).body)
        with Daemon("--memory-limit", size - 1) as daemon:
            daemon.wait_ready()
            reply = daemon.request("GET", f"/v1/scenes/{LARGE}/baked")
            self.assertEqual((reply.status, reply.headers["content-type"]), (422, "application/problem+json"))
            self.assertEqual(reply.json["code"], "out_of_memory", reply)
            for words in (f"scene '{LARGE}' cannot be baked", str(size), str(size - 1)):
                self.assertIn(words, reply.json["detail"])
            self.assertEqual(list((daemon.data_dir / "cache").iterdir()), [], "nothing half written is kept")
            self.assertEqual(daemon.request("GET", "/v1/scenes/cornell-box/baked").status, 200)


class Command(Case):
    def test_a_builtin_scene(self):
        result = self.run_ok("bake", "cornell-box", "box.baked")
        baked = (cli.folder / "box.baked").read_bytes()
        self.assertEqual(baked, cli.daemon.request("GET", "/v1/scenes/cornell-box/baked").body)
        self.assertRegex(result.stderr, r"saved box\.baked \([0-9.]+ .?i?B\)")
        self.assertEqual(result.stdout, "")

    def test_a_file_is_sent_first(self):
        (cli.folder / "room.glb").write_bytes(malformed_gltf.valid())
        result = self.run_ok("bake", "room.glb", "room.baked", "--json")
        [scene] = json_lines(result)
        self.assertEqual(scene["textures"], 1)
        self.assertIn("sending room.glb", result.stderr)
        self.assertIn(TEXELS, (cli.folder / "room.baked").read_bytes())
        self.run_ok("bake", scene["id"], "again.baked")
        self.assertEqual((cli.folder / "again.baked").read_bytes(), (cli.folder / "room.baked").read_bytes())

    def test_nothing_is_left_where_it_fails(self):
        (cli.folder / "bad.glb").write_bytes(tiny_scene.glb(77)[:-8])
        for code, scene, out, word in ((REFUSED, "no-such-scene", "none.baked", "no scene 'no-such-scene'"),
                                       (REFUSED, "bad.glb", "none.baked", ""),
                                       (USAGE, "gone.glb", "none.baked", "gone.glb"),
                                       (LOCAL_FILE, "cornell-box", "no-folder/none.baked", "no-folder/none.baked")):
            result = self.run_for(code, "bake", scene, out)
            self.assertIn(word, result.stderr)
        self.assertEqual([name for name in os.listdir(cli.folder) if "none" in name], [])
        self.assertIn("SCENE", self.run_for(USAGE, "bake").stderr + self.run_ok("bake", "--help").stdout)
        [failure] = json_lines(self.run_for(REFUSED, "bake", "no-such-scene", "none.baked", "--json"))
        self.assertEqual(failure["failure"]["problem"]["code"], "not_found", json.dumps(failure))

    def test_completion(self):
        self.assertIn("bake", self.completed("photonctl ba"))
        self.assertIn("cornell-box-glass", self.completed("photonctl bake cornell-box-g"))
        (cli.folder / "completed.glb").write_bytes(b"")
        self.assertIn("completed.glb", self.completed("photonctl bake comp"))


if __name__ == "__main__":
    unittest.main()
