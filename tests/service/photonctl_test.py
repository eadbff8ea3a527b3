"""photonctl against a real daemon, as a person and as a script use it; and through a proxy that breaks connections, to
hold it to what it promises about repeats."""

import json
import os
import re
import signal
import struct
import subprocess
import threading
import time
import unittest
import zipfile

import OpenImageIO as oiio

from bad_weather import BadWeather
from photond_daemon import BIN, Daemon
from photonctl_case import (CANCELLED, INTERRUPTED, LOCAL_FILE, OK, PHOTONCTL, REFUSED, SMALL, TIMED_OUT, UNREACHABLE, USAGE, Case, cli,
                            json_lines)

daemon = None
folder = None


def setUpModule():
    global daemon, folder
    cli.start()
    daemon, folder = cli.daemon, cli.folder


def tearDownModule():
    cli.stop()


def a_triangle(place, buffer_uri="data%20of%20it/./triangle.bin", glb=False):
    """One triangle with its buffer in another file, or inside a .glb."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                           "max": [1, 1, 0]}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}]}
    place.mkdir(parents=True, exist_ok=True)
    if not glb:
        gltf["buffers"][0]["uri"] = buffer_uri
        (place / "data of it").mkdir(exist_ok=True)
        (place / "data of it" / "triangle.bin").write_bytes(positions)
        (place / "triangle.gltf").write_text(json.dumps(gltf))
        return place / "triangle.gltf"
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", 36, b"BIN\0") + positions
    (place / "triangle.glb").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    return place / "triangle.glb"


class Rendering(Case):
    def test_what_is_asked_for_is_what_is_rendered_and_saved(self):
        exr, png = folder / "out.exr", folder / "out.png"
        result = self.run_ok("render", "cornell-box", "--width", 24, "--height", 16, "--passes", 3, "--seed", 7, "--layers",
                             "albedo,depth", "--filter", "gaussian", "--priority", 5, "--label", "study=cli", "--label",
                             "part=2", "--indirect-bounces", 2, "-o", exr, "--precision", "half", "--preview", png,
                             "--exposure", "-1.5", "--eye", "-0.1,0.2,2", "--look-at", "0,0.25,0", "--yfov", 0.5)
        job = daemon.request("GET", "/v1/jobs?label=part%3D2").json["items"][0]
        request = job["request"]
        self.assertEqual(request["image"], {"width": 24, "height": 16, "filter": "gaussian"})
        self.assertEqual(request["method"]["parameters"]["indirect_bounces"], 2)
        self.assertEqual((request["seed"], request["priority"]), (7, 5))
        self.assertEqual(request["layers"], ["albedo", "depth"])
        self.assertEqual(request["labels"], {"study": "cli", "part": "2"})
        self.assertEqual(request["stop"]["passes"], 3)
        self.assertEqual(request["camera"]["look_at"]["eye"], [-0.1, 0.2, 2])
        self.assertEqual(job["state"], "succeeded")

        image = oiio.ImageInput.open(str(exr))
        spec = image.spec()
        image.close()
        self.assertEqual((spec.width, spec.height), (24, 16))
        self.assertEqual(str(spec.format), "half")
        self.assertIn("albedo.R", spec.channelnames)
        path = f"/v1/jobs/{job['id']}"
        self.assertEqual(exr.read_bytes(), daemon.request("GET", path + "/image.exr?precision=half").body)
        self.assertEqual(png.read_bytes(), daemon.request("GET", path + "/preview.png?exposure=-1.5").body)
        self.assertNotEqual(png.read_bytes(), daemon.request("GET", path + "/preview.png").body)

        statistics = job["statistics"]
        self.assertIn(statistics["pixel_hash"], result.stdout)
        for stage in statistics["stages"]:
            self.assertIn(stage["name"].replace("_", " "), result.stdout)
        self.assertRegex(result.stdout, r"rays: camera +[\d.]+")
        self.assertIn("succeeded", result.stderr)
        self.assertEqual(sorted(p.name for p in folder.glob("out.*")), ["out.exr", "out.png"])  # nothing half written

    def test_json_output_is_the_job_and_nothing_else(self):
        result = self.run_ok("render", "furnace", *SMALL, "--json", "--set", "indirect_bounces=1")
        [job] = json_lines(result)
        self.assertEqual(job, daemon.job(job["id"]))

    def test_a_job_file_is_the_start_and_options_change_it(self):
        body = {"scene": "furnace", "image": {"width": 8, "height": 8}, "method": {"name": "path_tracing"},
                "stop": {"passes": 1}, "labels": {"from": "file"}}
        [job] = json_lines(self.run_ok("render", "--request", "-", "--width", 12, "--label", "more=1", "--json",
                                       input=json.dumps(body)))
        self.assertEqual(job["request"]["scene"], "furnace")
        self.assertEqual((job["request"]["image"]["width"], job["request"]["image"]["height"]), (12, 8))
        self.assertEqual(job["request"]["labels"], {"from": "file", "more": "1"})
        self.assertEqual(job["request"]["stop"]["passes"], 1)

    def test_a_dry_run_prints_what_the_job_would_take_and_queues_nothing(self):
        self.run_ok("render", "cornell-box", *SMALL)  # now a sample's time is known
        before = daemon.request("GET", "/v1/jobs?limit=1000").json["items"]
        for layers in ([], ["--layers", "albedo,normal,position,depth"]):
            size = ["--width", 64, "--height", 48, "--passes", 3]
            [estimate] = json_lines(self.run_ok("render", "cornell-box", *size, *layers, "--dry-run", "--json"))
            self.assertEqual(set(estimate), {"memory_bytes", "device_memory_bytes", "seconds", "pass_seconds", "left_out", "warnings"})
            self.assertGreater(estimate["memory_bytes"], 288 * 64 * 48)
            self.assertGreater(estimate["seconds"], 0)
            shown = self.run_ok("render", "cornell-box", *size, *layers, "--dry-run").stdout
            self.assertRegex(shown, r"^memory [\d.]+ [kM]B\ntime   [\d.]+ (ms|s)\n$")
        after = daemon.request("GET", "/v1/jobs?limit=1000").json["items"]
        self.assertEqual([job["id"] for job in after], [job["id"] for job in before])
        for more in (["-o", "x.exr"], ["--no-wait"], ["--timeout", 5]):
            self.run_for(USAGE, "render", "cornell-box", "--dry-run", *more)
        self.run_for(REFUSED, "render", "cornell-box", "--width", 65536, "--height", 65536, "--dry-run")

    def test_an_environment_is_sent_first(self):
        sky = oiio.ImageBuf(oiio.ImageSpec(8, 4, 3, oiio.FLOAT))
        oiio.ImageBufAlgo.fill(sky, (2.0, 2.0, 2.0))
        self.assertTrue(sky.write(str(folder / "sky.exr")), sky.geterror())
        [job] = json_lines(self.run_ok("render", a_triangle(folder / "sky", glb=True), *SMALL, "--environment",
                                       folder / "sky.exr", "--environment-scale", 3, "--json"))
        self.assertTrue(job["request"]["environment"]["image"].startswith("image:"))
        self.assertEqual(job["request"]["environment"]["scale"], 3)
        self.assertEqual(job["state"], "succeeded")

    def test_what_cannot_be_saved_is_told_before_anything_is_rendered(self):
        (folder / "a folder.exr").mkdir()
        before = daemon.request("GET", "/v1/jobs?limit=1&view=summary").json["total"]
        for code, said, *options in (
                (LOCAL_FILE, "no such folder/a.exr", "-o", folder / "no such folder" / "a.exr"),
                (LOCAL_FILE, "no such folder/a.png", "--preview", folder / "no such folder" / "a.png"),
                (LOCAL_FILE, "no such folder/log", "--film", folder / "no such folder" / "log"),
                (LOCAL_FILE, "it is a folder", "-o", folder / "a folder.exr"),
                (USAGE, "name it .png", "--preview", "a.jpg"),
                (USAGE, "name it .glb", "--photon-map", "photons.ply"),
                (USAGE, "name it .exr", "--reference", "path_tracing:2", "--difference", "difference.png"),
                (USAGE, "did you mean albedo? there are", "--layers", "albdo"),
                (USAGE, "it has beauty, emitted, direct, indirect; --layers", "--preview", "a.png", "--preview-layer", "caustic"),
                (USAGE, "--format says what -o - writes", "-o", "a.exr", "--format", "png"),
                (USAGE, "one of the results", "-o", "-", "--film", "-"),
                (USAGE, "--json", "-o", "-", "--json")):
            with self.subTest(options=options):
                self.assertIn(said, self.run_for(code, "render", "furnace", *SMALL, *options).stderr)
        self.run_ok("render", "furnace", *SMALL, "--layers", "caustic", "--preview", "a.png", "--preview-layer", "caustic")
        self.assertEqual(daemon.request("GET", "/v1/jobs?limit=1&view=summary").json["total"], before + 1)
        self.assertEqual(list(folder.glob("*.part*")), [])

    def test_an_image_on_standard_output(self):
        for options, resource in (([], "image.exr"), (["--format", "png"], "preview.png?exposure=0")):
            with self.subTest(options=options):
                result = subprocess.run([PHOTONCTL, "render", "furnace", *SMALL, "-o", "-", *options], capture_output=True,
                                        env=cli.environment(), cwd=folder)
                self.assertEqual(result.returncode, OK, result.stderr)
                job = result.stderr.split()[0].decode()
                self.assertEqual(result.stdout, daemon.request("GET", f"/v1/jobs/{job}/{resource}").body)
                self.assertIn(b"pixel hash", result.stderr)

    def test_a_device_is_written_to_and_not_replaced(self):
        (folder / "full.exr").symlink_to("/dev/full")
        os.mkfifo(folder / "pipe.exr")
        reader = subprocess.Popen(["cat", folder / "pipe.exr"], stdout=subprocess.PIPE)
        self.addCleanup(reader.stdout.close)
        self.run_ok("render", "furnace", *SMALL, "-o", "pipe.exr")
        self.assertTrue(reader.communicate()[0].startswith(b"\x76\x2f\x31\x01"))
        self.assertIn("No space left", self.run_for(LOCAL_FILE, "render", "furnace", *SMALL, "-o", "full.exr").stderr)
        self.assertTrue((folder / "full.exr").is_char_device() and (folder / "pipe.exr").is_fifo())

    def test_no_image_is_written_to_a_terminal(self):
        terminal, other_end = os.openpty()
        self.addCleanup(os.close, terminal)
        try:
            result = subprocess.run([PHOTONCTL, "render", "furnace", *SMALL, "-o", "-"], stdout=other_end,
                                    stderr=subprocess.PIPE, text=True, env=cli.environment())
        finally:
            os.close(other_end)
        self.assertEqual(result.returncode, USAGE)
        self.assertIn("standard output is a terminal", result.stderr)

    def test_an_image_says_how_to_make_it_again(self):
        [job] = json_lines(self.run_ok("render", "cornell-box", *SMALL, "--seed", 5, "--layers", "depth", "-o", "told.exr",
                                       "--json"))
        [again] = json_lines(self.run_ok("repeat", "told.exr", "-o", "again.exr", "--json"))
        self.assertNotEqual(again["id"], job["id"])
        self.assertEqual(again["request"], job["request"])
        self.assertEqual(again["statistics"]["pixel_hash"], job["statistics"]["pixel_hash"])
        self.assertTrue((folder / "again.exr").read_bytes().startswith(b"\x76\x2f\x31\x01"))
        [more] = json_lines(self.run_ok("repeat", "told.exr", "--samples", 3, "--seed", 6, "--json"))
        self.assertEqual((more["request"]["stop"]["passes"], more["request"]["seed"]), (3, 6))

        self.assertTrue(oiio.ImageBuf(oiio.ImageSpec(4, 4, 3, oiio.HALF)).write(str(folder / "silent.exr")))
        (folder / "torn.exr").write_bytes((folder / "told.exr").read_bytes()[:200])
        (folder / "none.exr").write_bytes(b"this is no image")
        for name, said in (("silent.exr", "no attribute photond:request"), ("torn.exr", "not a whole one"),
                           ("none.exr", "no OpenEXR file"), ("not there.exr", "cannot read")):
            with self.subTest(name=name):
                self.assertIn(said, self.run_for(USAGE, "repeat", name).stderr)


class Waiting(Case):
    """Jobs that would take minutes: stopping to watch is not stopping to render."""

    LONG = ["render", "cornell-box", "--width", "32", "--height", "32", "--seconds", "600"]

    def start_long(self, *more):
        process = cli.popen(*self.LONG, *more)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        line = process.stderr.readline()
        while "running" not in line:
            self.assertTrue(line, "ended before the job ran")
            line = process.stderr.readline()
        job = line.split()[0]
        self.addCleanup(daemon.request, "DELETE", f"/v1/jobs/{job}")
        return process, job

    def test_an_interrupt_leaves_the_job_running(self):
        process, job = self.start_long()
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(), INTERRUPTED)
        self.assertIn(f"photonctl jobs watch {job}", process.stderr.read())
        self.assertEqual(daemon.job(job)["state"], "running")

    def test_an_interrupt_cancels_where_asked_to_and_keeps_what_was_rendered(self):
        process, job = self.start_long("--cancel-on-interrupt", "-o", "interrupted.exr")
        daemon.wait_for_passes(job)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(), CANCELLED)
        self.assertEqual(daemon.job(job)["state"], "cancelled")
        self.assertTrue((folder / "interrupted.exr").read_bytes().startswith(b"\x76\x2f\x31\x01"))

    def test_a_timeout_leaves_the_job_running(self):
        result = self.run_for(TIMED_OUT, *self.LONG, "--timeout", "0.5", "--label", "timeout=1")
        job = daemon.request("GET", "/v1/jobs?label=timeout%3D1").json["items"][0]
        self.addCleanup(daemon.request, "DELETE", f"/v1/jobs/{job['id']}")
        self.assertIn(job["state"], ("queued", "running"))
        self.assertIn(job["id"], result.stderr)

    def test_commands_on_jobs(self):
        job = self.run_ok(*self.LONG, "--no-wait", "--label", "commands=1").stdout.strip()
        self.addCleanup(daemon.request, "DELETE", f"/v1/jobs/{job}")
        [listed] = json_lines(self.run_ok("jobs", "list", "--label", "commands=1", "--json"))
        self.assertEqual(listed["id"], job)
        self.run_for(REFUSED, "jobs", "retry", job)  # it is neither failed nor cancelled
        self.run_ok("jobs", "cancel", job)
        watched = self.run_for(CANCELLED, "jobs", "watch", job, "--json")
        self.assertEqual(json_lines(watched)[-1]["state"], "cancelled")
        self.assertIn("cornell-box", self.run_ok("jobs", "show", job).stdout)
        self.run_ok("jobs", "retry", job)
        self.assertIn(daemon.job(job)["state"], ("queued", "running"))
        self.assertIn(f"{job} has priority -7", self.run_ok("jobs", "priority", job, -7).stderr)
        self.assertEqual(daemon.job(job)["request"]["priority"], -7)
        self.run_ok("jobs", "cancel", job)
        daemon.wait_for_job(job)
        self.assertIn("was over before: it had been cancelled", self.run_ok("jobs", "cancel", job).stderr)
        self.run_for(REFUSED, "jobs", "priority", job, 5)
        self.assertIn(f"{job} removed", self.run_ok("jobs", "remove", job).stderr)
        self.assertEqual(daemon.request("GET", f"/v1/jobs/{job}").status, 404)

    def test_what_is_over_is_not_said_to_be_cancelled(self):
        [job] = json_lines(self.run_ok("render", "furnace", *SMALL, "--json"))
        self.assertEqual(self.run_ok("jobs", "cancel", job["id"]).stderr, f"{job['id']} was over before: it had succeeded\n")

    def test_fetch_saves_image_statistics_and_log(self):
        [job] = json_lines(self.run_ok("render", "furnace", *SMALL, "--json"))
        self.run_ok("jobs", "fetch", job["id"])
        self.assertEqual((folder / f"{job['id']}.exr").read_bytes(),
                         daemon.request("GET", f"/v1/jobs/{job['id']}/image.exr").body)
        printed = self.run_ok("jobs", "fetch", job["id"], "--statistics", "-")
        self.assertEqual(json.loads(printed.stdout), job["statistics"])
        self.run_ok("jobs", "fetch", job["id"], "--log", folder / "log.txt", "-o", folder / "p.png")
        self.assertEqual((folder / "log.txt").read_bytes(), daemon.request("GET", f"/v1/jobs/{job['id']}/log.txt").body)
        self.assertTrue((folder / "p.png").read_bytes().startswith(b"\x89PNG"))


class Scenes(Case):
    def test_every_form_of_a_scene_can_be_added(self):
        gltf = a_triangle(folder / "forms")
        with zipfile.ZipFile(folder / "forms.zip", "w") as packed:
            packed.write(gltf, "triangle.gltf")
            packed.write(gltf.parent / "data of it" / "triangle.bin", "data of it/triangle.bin")
        for path in (gltf, gltf.parent, folder / "forms.zip", a_triangle(folder / "binary", glb=True)):
            with self.subTest(path=path.name):
                [scene] = json_lines(self.run_ok("scenes", "add", path, "--name", f"form-{path.name}", "--json"))
                self.assertEqual(scene["triangles"], 1)
                self.assertEqual(scene, daemon.request("GET", f"/v1/scenes/{scene['id']}").json)

    def test_a_scene_sent_twice_is_the_same_scene(self):
        path = a_triangle(folder / "twice", glb=True)
        first = self.run_ok("scenes", "add", path, "--json")
        second = self.run_ok("scenes", "add", path, "--json")
        self.assertEqual(json_lines(first)[0]["id"], json_lines(second)[0]["id"])
        self.assertIn("known already", second.stderr)

    def test_show_list_remove(self):
        path = a_triangle(folder / "removed")
        [scene] = json_lines(self.run_ok("scenes", "add", path, "--name", "to-remove", "--json"))
        self.assertIn(scene["id"], {item["id"] for item in json_lines(self.run_ok("scenes", "list", "--json"))})
        listed = self.run_ok("scenes", "list")
        self.assertIn("by --family: hard-cases, ", listed.stderr)
        self.assertIn("moving/cornell-box", self.run_ok("scenes", "list", "--family", "moving").stdout)
        self.assertIn(scene["id"], self.run_ok("scenes", "show", scene["id"]).stdout)
        self.run_ok("render", path, "--width", "8", "--height", "8", "--passes", "1", "--label", "named=1")
        self.assertIn(f" {scene['name']} ", self.run_ok("jobs", "list", "--label", "named=1").stdout)
        self.run_ok("scenes", "remove", scene["id"])
        self.assertIn(f" {scene['id']} ", self.run_ok("jobs", "list", "--label", "named=1").stdout, "its name went with it")
        self.run_for(REFUSED, "scenes", "show", scene["id"])
        self.run_for(REFUSED, "scenes", "remove", scene["id"])

    def test_what_a_gltf_lacks_is_named_before_anything_is_sent(self):
        missing = a_triangle(folder / "missing", buffer_uri="gone.bin")
        self.assertIn("gone.bin", self.run_for(USAGE, "scenes", "add", missing).stderr)
        outside = a_triangle(folder / "outside", buffer_uri="../missing/triangle.gltf")
        self.assertIn("outside", self.run_for(USAGE, "scenes", "add", outside).stderr)
        self.assertIn("not a JSON object", self.run_for(USAGE, "scenes", "add", self.broken("broken.gltf")).stderr)
        self.run_for(USAGE, "scenes", "add", folder / "not there.glb")

    def test_faults_the_daemon_finds_are_printed(self):
        result = self.run_for(REFUSED, "scenes", "add", self.broken("broken.glb"), "--json")
        [failure] = json_lines(result)
        self.assertEqual(failure["failure"]["exit_code"], REFUSED)
        self.assertEqual(failure["failure"]["problem"]["status"], 422)

    def broken(self, name):
        (folder / name).write_bytes(b"this is no scene")
        return folder / name


class HelpAndChecks(Case):
    def test_help_lists_the_parameters_the_daemon_declares(self):
        text = re.sub(r"\s+", " ", self.run_ok("render", "--method", "path_tracing", "--help").stdout)
        properties = daemon.request("GET", "/v1/methods/path_tracing").json["parameters"]["properties"]
        self.assertTrue(properties)
        for name, schema in properties.items():
            self.assertIn("--" + name.replace("_", "-"), text)
            self.assertIn(re.sub(r"\s+", " ", schema["description"]), text)
        self.assertIn("standard_error", text)  # a layer, from the job's schema

    def test_help_works_without_a_daemon(self):
        text = self.run_ok("render", "--help", PHOTOND_URL="http://127.0.0.1:1").stdout
        self.assertIn("--passes", text)

    def test_values_are_checked_against_the_schema(self):
        for arguments, words in (
                (["--indirect-bounces", "-1"], ["indirect_bounces", "-1", "outside"]),
                (["--set", "indirect_bounces=two"], ["two", "whole number"]),
                (["--set", "sampler=sobbol"], ["sobbol", "sobol", "random"]),
                (["--set", "indirect_bouncs=2"], ["did you mean indirect_bounces"]),
                (["--indirect-bouncs", "2"], ["did you mean --indirect-bounces"]),
                (["--method", "path_trcing"], ["did you mean path_tracing"]),
                (["--label", "novalue"], ["KEY=VALUE"]),
                (["-o", "image.tiff"], [".exr", ".png"]),
                (["--eye", "0,0,1"], ["--look-at"])):
            with self.subTest(arguments=arguments):
                result = self.run_for(USAGE, "render", "cornell-box", *SMALL, *arguments)
                for word in words:
                    self.assertIn(word, result.stderr)

    def test_a_command_that_is_none_is_named_with_the_nearest(self):
        for arguments, said in ((["rendr", "furnace"], "no command photonctl rendr\n  did you mean photonctl render?"),
                                (["jobs", "wacth", "J1"], "no command photonctl jobs wacth\n  did you mean photonctl jobs watch?"),
                                (["jobs", "frobnicate"], "photonctl jobs has the commands list, show, watch"),
                                (["comparisons"], "photonctl comparisons needs a command")):
            with self.subTest(arguments=arguments):
                self.assertIn(said, self.run_for(USAGE, *arguments).stderr)

    def test_a_fault_is_told_once_and_has_a_code(self):
        for arguments, code, said in (
                (["--width", 0], "out_of_range", "photonctl: the value lies outside its declared range: /image/width: 0 is outside [1, 65536]\n"),
                (["--camera", "camra"], "unknown_name", "/camera/name: the scene has no camera 'camra'; did you mean 'camera'?; it has camera\n"),
                (["--width", 60000, "--height", 60000], "out_of_range", "= 3600000000 pixels, the limit is 67108864 in all; the job needs about"),
                (["--method", "imperfect_shadow_maps"], "usage", "ask for --device gpu")):
            with self.subTest(arguments=arguments):
                result = cli.run("render", "furnace", "--passes", 1, *arguments, "--json")
                self.assertEqual(result.returncode, USAGE if code == "usage" else REFUSED, result.stderr)
                self.assertIn(said, result.stderr)
                self.assertEqual(json_lines(result)[0]["failure"]["code"], code)
                self.assertEqual(len(result.stderr.splitlines()), 2 if code == "usage" else 1, result.stderr)
        result = self.run_for(UNREACHABLE, "status", "--json", "--server", "http://127.0.0.1:1")
        self.assertEqual(json_lines(result)[0]["failure"]["code"], "unreachable")

    def test_the_devices_are_what_they_are(self):
        [cpu] = [line for line in self.run_ok("devices").stdout.splitlines() if line.startswith("cpu ")]
        self.assertNotIn("software", cpu)
        self.assertRegex(cpu, r"[\d.]+ GB  cpu$")

    def test_every_fault_the_daemon_finds_is_printed_with_its_place(self):
        body = {"scene": "cornell-box", "image": {"width": 0, "height": 8, "filtr": "box"},
                "method": {"name": "path_tracing"}, "stop": {"passes": 1}}
        result = self.run_for(REFUSED, "render", "--request", "-", "--json", input=json.dumps(body))
        problem = json_lines(result)[0]["failure"]["problem"]
        self.assertGreaterEqual(len(problem["errors"]), 2)
        for fault in problem["errors"]:
            self.assertIn(fault["pointer"], result.stderr)
            self.assertIn(fault["detail"], result.stderr)

    def test_catalogue(self):
        listed = json_lines(self.run_ok("methods", "--json"))
        self.assertEqual(listed, daemon.request("GET", "/v1/methods").json["items"])
        self.assertIn("indirect_bounces", self.run_ok("methods", "path_tracing").stdout)
        self.run_for(REFUSED, "methods", "path_trcing")
        self.assertEqual(json_lines(self.run_ok("devices", "--json")), daemon.request("GET", "/v1/devices").json["items"])
        status = self.run_ok("status").stdout
        self.assertIn("version", status)
        self.assertNotRegex(status, r"(?m)^\S*\.\s", "no label ends where a unit was")


class Completion(Case):
    def test_commands_options_and_words(self):
        self.assertIn("render", self.completed("photonctl "))
        self.assertEqual(self.completed("photonctl jobs wa"), ["watch"])
        self.assertEqual(self.completed("photonctl render --indirect-b"), ["--indirect-bounces"])
        self.assertEqual(self.completed("photonctl render --precision "), ["half", "float"])
        self.assertEqual(self.completed("photonctl jobs list --state=fai"), ["failed"])
        self.assertNotIn("complete", self.completed("photonctl co"))  # hidden

    def test_what_the_daemon_knows(self):
        [job] = json_lines(self.run_ok("render", "furnace", *SMALL, "--json"))
        self.assertIn("cornell-box-glass", self.completed("photonctl render cornell-box-g"))
        self.assertEqual(self.completed("photonctl render --method path"), ["path_tracing"])
        self.assertIn(job["id"], self.completed("photonctl jobs show "))
        self.assertEqual(self.completed("photonctl render --set sampler=so"), ["sobol"])
        self.assertEqual(self.completed("photonctl render cornell-box --camera "), ["camera"])
        self.assertEqual(self.completed("photonctl render --layers albedo,no"), ["albedo,normal"])
        (folder / "completed.glb").write_bytes(b"")
        self.assertIn("completed.glb", self.completed("photonctl render comp"))

    def test_nothing_is_offered_and_nothing_hangs_without_a_daemon(self):
        result = cli.run("complete", "--words", "photonctl", "jobs", "show", "", PHOTOND_URL="http://127.0.0.1:1")
        self.assertEqual((result.returncode, result.stdout, result.stderr), (OK, "", ""))

    def test_scripts_for_the_other_shells_call_the_same_command(self):
        for shell in ("zsh", "fish"):
            self.assertIn("photonctl complete --words", self.run_ok("completion", shell).stdout)


class Doctor(Case):
    def test_a_healthy_daemon(self):
        checks = {row["check"]: row for row in json_lines(self.run_ok("doctor", "--render", "--json"))}
        for name in ("daemon", "access", "ready", "version", "device cpu", "methods", "render", "photond", "photond-worker"):
            self.assertEqual(checks[name]["state"], "ok", checks[name])
        self.assertTrue(all(row["fix"] for row in checks.values() if row["state"] != "ok"), checks)

    def test_no_daemon(self):
        result = self.run_for(UNREACHABLE, "doctor", PHOTOND_URL="http://127.0.0.1:1")
        self.assertRegex(result.stdout, r"fail +daemon")
        self.assertIn("-> ", result.stdout)

    def test_unreachable_is_its_own_exit_code_with_a_hint(self):
        result = self.run_for(UNREACHABLE, "status", "--server", "http://127.0.0.1:1")
        self.assertIn("--server", result.stderr)
        self.run_for(USAGE, "status", "--server", "127.0.0.1:1")


class Tokens(Case):
    def test_tokens_come_from_the_environment_or_a_file(self):
        made = subprocess.run([str(BIN / "photond"), "--new-token", "tester:write"], capture_output=True, text=True, check=True)
        token = re.search(r"[^\s:]{40,}", made.stdout)[0]
        line = re.search(r"tester write sha256:\w+", made.stdout)[0]
        tokens = folder / "tokens"
        tokens.write_text(line + "\n")
        tokens.chmod(0o600)
        (folder / "token").write_text(token + "\n")
        with Daemon("--tokens", tokens) as guarded:
            url = f"http://127.0.0.1:{guarded.port}"
            self.assertIn("401", self.run_for(REFUSED, "methods", "--json", PHOTOND_URL=url).stdout)
            self.run_for(REFUSED, "methods", PHOTOND_URL=url, PHOTOND_TOKEN="wrong")
            self.run_ok("methods", PHOTOND_URL=url, PHOTOND_TOKEN=token)
            self.run_ok("methods", "--token-file", folder / "token", PHOTOND_URL=url)
            self.run_for(USAGE, "methods", "--token-file", folder / "none", PHOTOND_URL=url)


class Weather(Case):
    def through(self, faults, code, *arguments):
        with BadWeather(cli.url(), faults) as proxy:
            result = self.run_for(code, *arguments, PHOTOND_URL=proxy.url)
            self.assertEqual(proxy.faults, [], "not every fault was met")
            return result, proxy.seen

    def labelled(self, label):
        return daemon.request("GET", "/v1/jobs?label=" + label.replace("=", "%3D")).json["items"]

    def test_a_submission_whose_answer_was_lost_is_one_job(self):
        _, seen = self.through([("POST", "^/v1/jobs$", "drop"), ("POST", "^/v1/jobs$", "drop")], OK, "render", "furnace",
                               *SMALL, "--label", "lost=1")
        submissions = [headers["Idempotency-Key"] for method, path, headers in seen if method == "POST"]
        self.assertEqual(len(submissions), 3)
        self.assertEqual(len(set(submissions)), 1)
        self.assertEqual(len(self.labelled("lost=1")), 1)

    def test_busy_answers_are_waited_out(self):
        begun = time.monotonic()
        _, seen = self.through([("GET", "methods", "503"), ("POST", "^/v1/jobs$", "429"), ("GET", "image.exr", "503")], OK,
                               "render", "furnace", *SMALL, "--label", "busy=1", "-o", "busy.exr")
        self.assertGreaterEqual(time.monotonic() - begun, 3)  # each said Retry-After: 1
        self.assertEqual(len([1 for method, path, _ in seen if method == "POST"]), 2)
        self.assertEqual(len(self.labelled("busy=1")), 1)

    def test_no_repeats_where_none_are_wanted(self):
        result, seen = self.through([("GET", "methods", "503")], REFUSED, "--retry-seconds", 0, "methods", "--json")
        self.assertEqual(len(seen), 1)
        self.assertEqual(json_lines(result)[0]["failure"]["problem"]["status"], 503)

    def test_a_refusal_is_not_repeated(self):
        _, seen = self.through([("GET", "methods", "404")], REFUSED, "methods")
        self.assertEqual(len(seen), 1)

    def test_a_retry_that_may_have_been_carried_out_is_not_repeated(self):
        job = self.run_ok("render", "cornell-box", "--width", 32, "--height", 32, "--seconds", 60, "--no-wait").stdout.strip()
        self.addCleanup(daemon.request, "DELETE", f"/v1/jobs/{job}")
        daemon.request("DELETE", f"/v1/jobs/{job}")
        daemon.wait_for_job(job)
        _, seen = self.through([("POST", "/retry$", "drop")], UNREACHABLE, "jobs", "retry", job)
        self.assertEqual(len(seen), 1)

    def test_a_download_that_breaks_off_is_whole_in_the_end(self):
        [job] = json_lines(self.run_ok("render", "furnace", *SMALL, "--json"))
        self.through([("GET", "image.exr", "drop")], OK, "jobs", "fetch", job["id"], "-o", "whole.exr")
        self.assertEqual((folder / "whole.exr").read_bytes(), daemon.request("GET", f"/v1/jobs/{job['id']}/image.exr").body)

    def watch(self, faults, streams, then=0):
        """Watches a job through `faults` until it is cancelled, once the proxy has_seen() that; the streams asked for."""
        job = self.run_ok("render", "cornell-box", "--width", 32, "--height", 32, "--seconds", 600, "--no-wait").stdout.strip()
        self.addCleanup(daemon.request, "DELETE", f"/v1/jobs/{job}")
        with BadWeather(cli.url(), faults) as proxy:
            def cancel():
                daemon.wait_until(lambda: proxy.has_seen(streams, then), "it asks that often", job=job)
                daemon.request("DELETE", f"/v1/jobs/{job}")
            canceller = threading.Thread(target=cancel)
            canceller.start()
            self.run_for(CANCELLED, "jobs", "watch", job, PHOTOND_URL=proxy.url)
            canceller.join()
            self.assertEqual(proxy.faults, [], "not every fault was met")
        self.assertEqual(daemon.job(job)["state"], "cancelled")
        return proxy.streams()

    def test_a_broken_event_stream_is_taken_up_where_it_broke(self):
        streams = self.watch([("GET", "/events$", "cut")], 2)
        self.assertGreaterEqual(len(streams), 2)
        self.assertNotIn("Last-Event-ID", streams[0])
        self.assertTrue(streams[1]["Last-Event-ID"].isdigit())

    def test_without_event_streams_the_job_is_asked_again_and_again(self):
        self.assertEqual(len(self.watch([("GET", "/events$", "404")] * 3, 3, then=3)), 3)


if __name__ == "__main__":
    unittest.main()
