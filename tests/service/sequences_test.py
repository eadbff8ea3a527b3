"""Sequences of frames: accepted as a whole, rendered in order by a worker that keeps the scene, gone on with after kills
to the same bits, cancelled, retried and removed.
"""

import io
import json
import os
import re
import signal
import struct
import subprocess
import tempfile
import unittest
import zipfile

from photond_daemon import Daemon, DaemonTestCase, small_job

OVER = ("succeeded", "failed", "cancelled")


def sequence(frames=4, passes=1, size=16, **more):
    return {"scene": "moving/cornell-box", "image": {"width": size, "height": size}, "method": {"name": "path_tracing"},
            "stop": {"passes": passes}, "frames": frames, "fps": 8, **more}


def submit(daemon, body, key=None):
    answer = daemon.request("POST", "/v1/sequences", json_body=body, headers={"Idempotency-Key": key} if key else None)
    assert answer.status == 202, answer
    return answer.json


def look(daemon, id):
    return daemon.request("GET", f"/v1/sequences/{id}").json


def wait_over(daemon, id):
    return daemon.wait_for_state(f"/v1/sequences/{id}")


def hashes(daemon, done):
    return [daemon.job(frame["id"])["statistics"]["pixel_hash"] for frame in done["frames"]]


class SequencesTest(DaemonTestCase):
    def test_frames_are_jobs_in_order(self):
        made = submit(self.daemon, sequence(frames=5, labels={"shot": "1"}))
        self.assertRegex(made["id"], r"^S\d+$")
        self.assertEqual([frame["frame"] for frame in made["frames"]], list(range(5)))
        self.assertEqual([frame["time"] for frame in made["frames"]], [i / 8 for i in range(5)])
        done = wait_over(self.daemon, made["id"])
        self.assertEqual((done["state"], done["progress"], done["seconds_left"]), ("succeeded", 1, 0))
        self.assertEqual(done["job_states"]["succeeded"], 5)
        jobs = [self.daemon.job(frame["id"]) for frame in done["frames"]]
        for i, job in enumerate(jobs):
            self.assertEqual((job["role"], job["sequence"], job["comparison"]), ("frame", made["id"], None))
            self.assertEqual((job["request"]["time"], job["request"]["seed"]), (i / 8, 1 + i))
            self.assertEqual(job["request"]["labels"], {"shot": "1"})
        started = [job["started"] for job in jobs]
        self.assertEqual(started, sorted(started))
        self.assertEqual(len(set(hashes(self.daemon, done))), 5)
        # The worker has loaded the scene once: later frames are of a scene that was there.
        later = self.daemon.request("GET", f"/v1/jobs/{jobs[-1]['id']}/log.txt").text
        self.assertIn("ready from an earlier job", later)

    def test_all_frames_come_in_one_file(self):
        made = submit(self.daemon, sequence(frames=3))
        path = f"/v1/sequences/{made['id']}/frames.zip"
        wait_over(self.daemon, made["id"])
        for images, start in (("exr", b"\x76\x2f\x31\x01"), ("png", b"\x89PNG")):
            answer = self.daemon.request("GET", f"{path}?images={images}")
            self.assertEqual((answer.status, answer.headers["content-type"]), (200, "application/zip"), answer)
            with zipfile.ZipFile(io.BytesIO(answer.body)) as archive:
                self.assertEqual(archive.namelist(), [f"{i:04d}.{images}" for i in range(3)])
                self.assertEqual({archive.read(name)[:4] for name in archive.namelist()}, {start})
                if images == "exr":
                    alone = self.daemon.request("GET", f"/v1/jobs/{made['frames'][1]['id']}/image.exr").body
                    self.assertEqual(archive.read("0001.exr"), alone)
            self.assertEqual(self.daemon.request("GET", f"{path}?images={images}").headers["etag"], answer.headers["etag"])
        self.assertEqual(self.daemon.request("GET", f"{path}?images=gif").status, 422)
        waiting = submit(self.daemon, sequence(frames=2, stop={"seconds": 60}))
        self.assertEqual(self.daemon.request("GET", f"/v1/sequences/{waiting['id']}/frames.zip").status, 202)
        self.daemon.request("DELETE", f"/v1/sequences/{waiting['id']}?purge=true")

    def test_frames_are_looked_at_as_a_video(self):
        made = wait_over(self.daemon, submit(self.daemon, sequence(frames=5, size=35))["id"])
        path = f"/v1/sequences/{made['id']}/video"
        for query, rate, seconds in (("", "8/1", 5 / 8), ("?fps=2.5&exposure=1&curve=filmic", "5/2", 2)):
            answer = self.daemon.request("GET", path + query)
            self.assertEqual((answer.status, answer.headers["content-type"]), (200, "video/mp4"), answer)
            with tempfile.NamedTemporaryFile(suffix=".mp4") as file:
                file.write(answer.body)
                file.flush()
                told = json.loads(subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json",
                                                  file.name], capture_output=True, check=True).stdout)["streams"][0]
            self.assertEqual((told["nb_read_frames"], told["r_frame_rate"]), ("5", rate))
            self.assertAlmostEqual(float(told["duration"]), seconds, 3)
            self.assertEqual((told["codec_name"], told["pix_fmt"], told["width"], told["height"]), ("h264", "yuv420p", 36, 36))
            self.assertEqual((told["color_space"], told["color_range"]), ("bt709", "tv"))
        self.assertEqual(self.daemon.request("GET", path).headers["etag"],
                         self.daemon.request("GET", path + "?format=mp4&fps=8").headers["etag"])
        for query, pointer in (("format=gif", "/format"), ("fps=0", "/fps"), ("curve=x", "/curve")):
            answer = self.daemon.request("GET", f"{path}?{query}")
            self.assertEqual((answer.status, answer.json["errors"][0]["pointer"]), (422, pointer), answer)
        waiting = submit(self.daemon, sequence(frames=2, stop={"seconds": 60}))
        self.assertEqual(self.daemon.request("GET", f"/v1/sequences/{waiting['id']}/video").status, 202)
        self.daemon.request("DELETE", f"/v1/sequences/{waiting['id']}?purge=true")

    def test_without_ffmpeg_frames_are_looked_at_beside_each_other(self):
        with Daemon(environment={"PATH": "/nonexistent"}) as daemon:
            daemon.wait_ready()
            path = f"/v1/sequences/{wait_over(daemon, submit(daemon, sequence(frames=12))['id'])['id']}/video"
            answer = daemon.request("GET", path)
            self.assertEqual((answer.status, answer.headers["content-type"]), (200, "image/png"), answer)
            width, height = struct.unpack(">II", answer.body[16:24])
            self.assertEqual((width, height), (10 * 20 - 4, 2 * 20 - 4), "ten in a row, four pixels between")
            self.assertEqual(daemon.request("GET", path + "?format=png").headers["etag"], answer.headers["etag"])
            refused = daemon.request("GET", path + "?format=mp4")
            self.assertEqual((refused.status, refused.json["code"]), (422, "unsupported"), refused)

    def errors(self, of, first, second, **query):
        query = {"first": first, "second": second, **query}
        return self.daemon.request("GET", f"/v1/sequences/{of}/errors?" + "&".join(f"{k}={v}" for k, v in query.items()))

    def test_errors_by_frame_tell_noise_that_flickers_from_noise_that_stands_still(self):
        still = {"scene": "cornell-box", "frames": 4,
                 "camera_path": {"keys": [{"time": 0, "eye": [0, 2.7, 3], "target": [0, 2.7, -2.8]}]}}
        first, second, fresh, frozen = (
            submit(self.daemon, sequence(**still, seed=seed, passes=passes, noise=noise))["id"]
            for seed, passes, noise in ((1, 256, "fresh"), (1001, 256, "fresh"), (2001, 1, "fresh"), (2001, 1, "still")))
        for id in (first, second, fresh, frozen):
            wait_over(self.daemon, id)
        of_fresh, of_frozen = (self.errors(of, first, second).json for of in (fresh, frozen))
        self.assertEqual((of_fresh["sequence"], of_fresh["references"], of_fresh["layer"]), (fresh, [first, second], "beauty"))
        for errors in (of_fresh, of_frozen):
            self.assertEqual([frame["time"] for frame in errors["frames"]], [i / 8 for i in range(4)])
            self.assertIsNone(errors["frames"][0]["flicker"])
            self.assertIsNone(errors["frames_late"], "nothing moves")
            for figure in ("relative_mse", "flicker", "lag", "change"):
                values = [frame[figure]["value"] for frame in errors["frames"] if frame[figure]]
                self.assertAlmostEqual(errors["mean"][figure]["value"], sum(values) / len(values), 9)
        error, flicker = (of_fresh["mean"][figure] for figure in ("relative_mse", "flicker"))
        self.assertGreater(flicker["interval"][0], error["value"], "twice the variance of a frame, where all error is noise")
        least, greatest = of_frozen["mean"]["flicker"]["interval"]
        self.assertLess(greatest - least, 0.1 * error["value"])
        self.assertLess(abs(of_frozen["mean"]["flicker"]["value"]), 0.1 * error["value"], "the same noise in all frames")
        self.look_at_page(fresh, frozen, first, second, of_fresh)

    def look_at_page(self, id, beside, first, second, errors):
        page = self.daemon.request("GET", f"/v1/sequences/{id}/report.html?first={first}&second={second}&beside={beside}")
        self.assertEqual((page.status, page.headers["content-type"]), (200, "text/html; charset=utf-8"), page)
        self.assertIn("script-src 'sha256-", page.headers["content-security-policy"])
        plots = re.findall(r'<svg class="plot".*?</svg>', page.text)
        self.assertEqual([re.search(r'aria-label="(.*?)"', plot)[1] for plot in plots],
                         ["Error by frame", "Flicker by frame", "Lag by frame"])
        for name in (f"path_tracing ({id})", f"path_tracing ({beside})"):
            points = re.findall(re.escape(name) + r": (\S+) at frame (\d+) \(", plots[0])
            self.assertEqual([frame for _, frame in points], ["0", "1", "2", "3"])
            if id in name:
                for shown, frame in zip(points, errors["frames"]):
                    self.assertAlmostEqual(float(shown[0]) / frame["relative_mse"]["value"], 1, 2)
        self.assertEqual(page.text.count("data:image/png;base64,"), 2)
        unmeasured = self.daemon.request("GET", f"/v1/sequences/{id}/report.html").text
        self.assertNotIn('<svg class="plot"', unmeasured)
        self.assertIn("Not measured", unmeasured)
        for query, status in ((f"first={first}", 422), ("beside=S999", 404), ("beside=" + ",".join([beside] * 16), 422)):
            self.assertEqual(self.daemon.request("GET", f"/v1/sequences/{id}/report.html?{query}").status, status, query)

    def test_errors_by_frame_want_references_that_are_independent(self):
        ids = {}
        round = {"camera_path": {"turns": 1}, "camera": {"look_at": {"eye": [0, 2.7, 3], "target": [0, 2.7, -2.8]}}}
        for name, more in {"measured": {"seed": 400}, "one": {}, "shifted": {"seed": 2}, "fast": {"seed": 100, "fps": 4},
                           "still": {"seed": 200, "noise": "still"}, "other": {"seed": 300}, "open": {"shutter": 0.1},
                           "lit": {"glass": "solid"}, "round": round, "rounder": {**round, "frames": 3, "seed": 9}}.items():
            ids[name] = submit(self.daemon, sequence(**{"frames": 2, **more}))["id"]
        for id in ids.values():
            wait_over(self.daemon, id)
        for first, second, pointer, text in (
                (ids["one"], ids["shifted"], "/second", "frame 1 of {one} and frame 0 of {shifted} have the seed 2"),
                (ids["open"], ids["other"], "/first", "{open} differ in their shutter"),
                (ids["lit"], ids["other"], "/first", "{lit} differ in their glass"),
                (ids["fast"], ids["other"], "/first", "sequences {measured} and {fast} differ in their fps"),
                (ids["other"], ids["still"], "/second", "frame 0 of {still} and frame 1 of {still} have the seed 200")):
            answer = self.errors(ids["measured"], first, second)
            self.assertEqual((answer.status, answer.json["code"]), (422, "conflict"), answer)
            self.assertIn(text.format(**ids), answer.text)
            self.assertIn(f'"{pointer}"', answer.text)
        answer = self.errors(ids["round"], ids["rounder"], ids["rounder"])
        self.assertEqual((answer.status, answer.json["code"]), (422, "conflict"), answer)
        self.assertIn("differ in their frames", answer.text)
        own = self.errors(ids["one"], ids["other"], ids["one"])
        self.assertEqual((own.status, own.json["errors"][0]["pointer"]), (422, "/second"), "an image that is its own truth")
        self.assertEqual(self.errors(ids["measured"], ids["one"], ids["other"]).status, 200)
        self.assertEqual(self.errors(ids["measured"], ids["other"], "").status, 422)
        self.assertEqual(self.errors(ids["measured"], ids["other"], "S999").status, 404)
        self.assertEqual(self.errors(ids["measured"], ids["one"], ids["other"], layer="sky").status, 422)

    def test_lists_and_filters_know_them(self):
        made = submit(self.daemon, sequence(frames=2))
        page = self.daemon.request("GET", "/v1/sequences?limit=1").json
        self.assertEqual([item["id"] for item in page["items"]], [made["id"]])
        self.assertNotIn("frames", page["items"][0])
        self.assertEqual(self.daemon.request("GET", f"/v1/comparisons/C{made['id'][1:]}").status, 404)
        self.assertNotIn("C" + made["id"][1:],
                         [item["id"] for item in self.daemon.request("GET", "/v1/comparisons").json["items"]])
        wait_over(self.daemon, made["id"])
        frames = self.daemon.request("GET", "/v1/jobs?role=frame&view=summary&limit=2").json["items"]
        self.assertEqual({frame["sequence"] for frame in frames}, {made["id"]})

    def test_a_summary_is_a_sequence_without_its_frames(self):
        made = submit(self.daemon, sequence(frames=3, stop={"seconds": 60}))
        self.daemon.wait_until(lambda: look(self.daemon, made["id"])["job_states"]["running"] == 1, "a frame runs")
        whole, summary = look(self.daemon, made["id"]), look(self.daemon, made["id"] + "?frames=false")
        self.assertEqual(set(whole) - set(summary), {"frames"})
        changing = ("frames", "progress", "seconds_left")
        self.assertEqual(*({name: value for name, value in of.items() if name not in changing} for of in (whole, summary)))
        self.assertEqual((summary["state"], summary["job_states"]["queued"]), ("running", 2))
        self.assertGreaterEqual(summary["progress"], whole["progress"])
        wrong = self.daemon.request("GET", f"/v1/sequences/{made['id']}?frames=none")
        self.assertEqual((wrong.status, wrong.json["errors"][0]["pointer"]), (422, "/frames"))
        self.daemon.request("DELETE", f"/v1/sequences/{made['id']}?purge=true")

    def test_frames_share_references_where_they_show_the_same_and_those_go_with_them(self):
        measured = {"reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 2}}, "metrics": ["relative_mse"]}
        still = {"scene": "cornell-box", "camera_path": {"keys": [{"time": 0, "eye": [0, 2.7, 3], "target": [0, 2.7, -2.8]}]}}
        done = wait_over(self.daemon, submit(self.daemon, sequence(frames=3, **still, **measured))["id"])
        jobs = [self.daemon.job(frame["id"]) for frame in done["frames"]]
        self.assertEqual(done["state"], "succeeded", done)
        self.assertEqual(len({tuple(job["reference_jobs"]) for job in jobs}), 1)
        self.assertEqual(len(jobs[0]["reference_jobs"]), 2)
        busy = self.daemon.submit(small_job(stop={"seconds": 600}, priority=9))
        self.daemon.wait_for_job(busy["id"], states=("running",))
        moving = submit(self.daemon, sequence(frames=3, **measured))
        films = {film for frame in moving["frames"] for film in self.daemon.job(frame["id"])["reference_jobs"]}
        self.assertEqual((len(films), look(self.daemon, moving["id"])["state"]), (6, "queued"))
        self.daemon.request("DELETE", f"/v1/sequences/{moving['id']}?purge=true")
        self.assertEqual({self.daemon.job(film)["state"] for film in films}, {"cancelled"})
        self.daemon.request("DELETE", f"/v1/jobs/{busy['id']}")

    def test_a_camera_path_needs_no_animation(self):
        body = sequence(frames=3, scene="cornell-box", camera={"look_at": {"eye": [0, 2.7, 3], "target": [0, 2.7, -3]}},
                        camera_path={"turns": 0.1})
        done = wait_over(self.daemon, submit(self.daemon, body)["id"])
        self.assertEqual(done["state"], "succeeded")
        self.assertEqual(len(set(hashes(self.daemon, done))), 3)

    def test_the_same_key_is_the_same_sequence(self):
        first = submit(self.daemon, sequence(frames=2), key="k1")
        self.assertEqual(submit(self.daemon, sequence(frames=2), key="k1")["id"], first["id"])
        other = self.daemon.request("POST", "/v1/sequences", json_body=sequence(frames=3), headers={"Idempotency-Key": "k1"})
        self.assertEqual(other.status, 422, other)

    def test_an_estimate_queues_nothing(self):
        before = self.daemon.request("GET", "/v1/sequences").json["items"]
        answer = self.daemon.request("POST", "/v1/sequences?dry_run=true", json_body=sequence(frames=1000))
        self.assertEqual((answer.status, answer.json["frames"]), (200, 1000), answer)
        self.assertGreater(answer.json["disk_bytes"], 1000 * 16 * 16 * 16)
        self.assertEqual(self.daemon.request("GET", "/v1/sequences").json["items"], before)

    def test_faults_are_named_with_their_places(self):
        for change, pointer in (({"frames": 0}, "/frames"), ({"animation": "walk"}, "/animation"),
                                ({"scene": "cornell-box"}, "/animation"), ({"scene": "nowhere"}, "/scene"),
                                ({"time": 1}, "/time"), ({"method": {"name": "path_tracin"}}, "/method/name"),
                                ({"shutter": 0.1, "method": {"name": "progressive_photon_mapping"}}, "/shutter")):
            with self.subTest(change=change):
                answer = self.daemon.request("POST", "/v1/sequences", json_body=sequence(**change))
                self.assertEqual((answer.status, answer.json["errors"][0]["pointer"]), (422, pointer), answer)

    def test_cancelled_frames_can_be_retried(self):
        made = submit(self.daemon, sequence(frames=4, passes=4000, size=32))
        self.daemon.request("DELETE", f"/v1/sequences/{made['id']}")
        done = wait_over(self.daemon, made["id"])
        self.assertEqual(done["job_states"]["cancelled"], 4, done)
        frame = done["frames"][2]["id"]
        self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{frame}/retry").status, 202)
        self.assertIn(look(self.daemon, made["id"])["frames"][2]["state"], ("queued", "running"))
        self.daemon.request("DELETE", f"/v1/jobs/{frame}")
        wait_over(self.daemon, made["id"])

    def test_a_sequence_goes_with_all_its_frames(self):
        made = submit(self.daemon, sequence(frames=3))
        wait_over(self.daemon, made["id"])
        frame = made["frames"][0]["id"]
        refused = self.daemon.request("DELETE", f"/v1/jobs/{frame}?purge=true")
        self.assertEqual(refused.status, 409, refused)
        self.assertIn(f"belongs to sequence {made['id']}", refused.json["detail"])
        self.assertEqual(self.daemon.request("DELETE", f"/v1/sequences/{made['id']}?purge=true").status, 200)
        self.assertEqual(self.daemon.request("GET", f"/v1/sequences/{made['id']}").status, 404)
        self.assertEqual(self.daemon.request("GET", f"/v1/jobs/{frame}").status, 404)


    def test_frames_that_follow_say_so_and_wait_for_the_one_before(self):
        follows = {"name": "path_tracing", "parameters": {"temporal": "reproject"}}
        made = submit(self.daemon, sequence(frames=4, method=follows, layers=["history_length"]))
        self.assertEqual(made["frames_share"], ["indirect light"])
        self.assertEqual(submit(self.daemon, sequence(frames=1))["frames_share"], [])
        done = wait_over(self.daemon, made["id"])
        self.assertEqual(done["job_states"]["succeeded"], 4, done)
        ids = [frame["id"] for frame in done["frames"]]
        logs = [self.daemon.request("GET", f"/v1/jobs/{id}/log.txt").text for id in ids]
        self.assertNotIn("follows the frame", logs[0])
        for i in (1, 2, 3):
            self.assertIn(f"follows the frame at {(i - 1) / 8:g} s", logs[i])
        # A frame rendered again follows the same one, to the same bits.
        again = submit(self.daemon, sequence(frames=4, method=follows, layers=["history_length"]))
        self.assertEqual(hashes(self.daemon, wait_over(self.daemon, again["id"])), hashes(self.daemon, done))
        alone = submit(self.daemon, sequence(frames=4, layers=["history_length"], method={**follows, "parameters": {}}))
        self.assertNotEqual(hashes(self.daemon, wait_over(self.daemon, alone["id"]))[1:], hashes(self.daemon, done)[1:])
        # Their films are no parts of one image, and no moment of an open shutter.
        self.assertFalse(self.daemon.job(ids[1])["statistics"]["mergeable"])
        merged = self.daemon.request("POST", "/v1/jobs/merge", json_body={"jobs": ids[1:3]})
        self.assertIn(merged.status, (409, 422), merged)
        for extra, place in (({"shutter": 0.05}, "/shutter"), ({"first_pass": 4}, "/first_pass")):
            job = {**small_job(), "method": follows, **extra}
            refused = self.daemon.request("POST", "/v1/jobs", json_body=job)
            self.assertEqual((refused.status, refused.json["errors"][0]["pointer"]), (422, place), refused)

    def test_a_frame_whose_forerunner_failed_begins_anew(self):
        follows = {"name": "path_tracing", "parameters": {"temporal": "reproject"}}
        made = submit(self.daemon, sequence(frames=3, passes=4000, size=32, method=follows))
        first, second, third = (frame["id"] for frame in made["frames"])
        self.daemon.wait_for_job(first, states=("running",))
        self.assertIn(f"job {first}", self.daemon.job(second)["waiting_for"])
        self.daemon.request("DELETE", f"/v1/jobs/{first}")
        self.daemon.wait_for_job(second, states=("running",))
        self.assertIn(f"job {second}", self.daemon.job(third)["waiting_for"])
        self.assertNotIn("follows the frame", self.daemon.request("GET", f"/v1/jobs/{second}/log.txt").text)
        self.daemon.request("DELETE", f"/v1/sequences/{made['id']}")
        wait_over(self.daemon, made["id"])


class KilledSequencesTest(unittest.TestCase):
    def test_daemon_and_workers_are_killed_five_times_and_no_bit_differs(self):
        # Of frames that follow from the one before: what each leaves is kept with its film.
        follows = {"name": "path_tracing", "parameters": {"temporal": "reproject"}}
        body = sequence(frames=12, passes=3, size=32, method=follows)
        with Daemon() as undisturbed:
            undisturbed.wait_ready()
            expected = hashes(undisturbed, wait_over(undisturbed, submit(undisturbed, body)["id"]))
        with Daemon() as daemon:
            daemon.wait_ready()
            id = submit(daemon, body)["id"]
            for kill in range(5):
                daemon.wait_until(lambda: look(daemon, id)["job_states"]["succeeded"] > 2 * kill, "two more frames")
                if kill % 2:
                    daemon.kill()
                    daemon.start()
                    daemon.wait_ready()
                else:
                    for worker in daemon.workers().values():
                        os.kill(worker, signal.SIGKILL)
            done = wait_over(daemon, id)
            self.assertEqual(done["job_states"]["succeeded"], 12, done)
            self.assertEqual(hashes(daemon, done), expected)


if __name__ == "__main__":
    unittest.main()
