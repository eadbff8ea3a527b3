"""The Python client as its users have it: its own examples (doctests, README), then what they do not show, against a real
daemon."""

import contextlib
import doctest
import importlib
import io
import os
import pathlib
import pkgutil
import re
import subprocess
import sys
import threading
import types
import unittest
import unittest.mock

import numpy
import OpenImageIO as oiio

import tiny_scene
from photond_daemon import BIN, Daemon
from python_client_case import PACKAGE, SMALL, Case, fixture, gltf_folder, photond, url_of

setUpModule, tearDownModule = fixture.start, fixture.stop


def exr_layer(path, names):
    """height x width x channels of an EXR's channels of these names."""
    file = oiio.ImageInput.open(str(path))
    pixels, channels = file.read_image(oiio.FLOAT), list(file.spec().channelnames)
    file.close()
    return pixels[:, :, [channels.index(name) for name in names]]


class Examples(Case):
    def test_doctests(self):
        names = {"client": self.client, "photond": photond, "folder": self.folder, "entry": photond.entry,
                 "triangle_gltf": gltf_folder(self.folder / "doctest")}
        tried = 0
        for module in pkgutil.iter_modules(photond.__path__, "photond."):
            with self.subTest(module=module.name):
                loaded = importlib.import_module(module.name)
                report = io.StringIO()
                with contextlib.redirect_stdout(report):
                    result = doctest.testmod(loaded, extraglobs=names)
                self.assertEqual(result.failed, 0, report.getvalue())
                tried += result.attempted
        self.assertGreater(tried, 60)  # they were found

    def test_the_lines_of_the_readme_run_as_they_stand(self):
        blocks = re.findall(r"```python\n(.*?)```", (PACKAGE / "README.md").read_text(), re.DOTALL)
        self.assertGreater(len(blocks), 3)
        place = self.folder / "readme"
        place.mkdir()
        (place / "room.glb").write_bytes(tiny_scene.glb(77))
        self.client.render("cornell-box", **SMALL).save(place / "fine.exr")
        script = place / "readme.py"
        script.write_text("\n".join(blocks))
        result = subprocess.run([sys.executable, script.name], cwd=place, capture_output=True, text=True,
                                env={**os.environ, "PHOTOND_URL": url_of(self.daemon), "PYTHONPATH": str(PACKAGE),
                                     "MPLBACKEND": "agg"})
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertTrue((place / "error.svg").read_text().startswith("<?xml"))


class Scenes(Case):
    def test_every_form_of_a_scene_can_be_uploaded(self):
        gltf = gltf_folder(self.folder / "forms")
        (self.folder / "forms.zip").write_bytes(tiny_scene.zipped(tiny_scene.gltf_files(1)))
        (self.folder / "forms.glb").write_bytes(tiny_scene.glb(2))
        for path in (gltf, gltf.parent, str(self.folder / "forms.zip"), self.folder / "forms.glb"):
            with self.subTest(path=str(path)):
                scene = self.client.upload_scene(path, name=f"form {pathlib.Path(path).name}")
                self.assertEqual((scene.triangles, scene.cameras), (1, ["front"]))
                self.assertEqual(scene.data, self.client.scene(scene.id).data)
                self.assertIn(scene.id, [listed.id for listed in self.client.scenes()])
                self.assertEqual(scene._repr_png_(), scene.thumbnail())

    def test_a_path_given_as_a_scene_is_uploaded_once(self):
        (self.folder / "path.glb").write_bytes(tiny_scene.glb(3))
        job = self.client.render(self.folder / "path.glb", **SMALL)
        again = self.client.render(str(self.folder / "path.glb"), **SMALL)
        self.assertEqual(job.request["scene"], again.request["scene"])
        self.assertEqual(job.statistics["pixel_hash"], again.statistics["pixel_hash"])

    def test_views(self):
        scene = self.client.scene("cornell-box")
        view = scene.default_view
        # One pass: a picture of more is given what passes it got in its time, which differ on a busy machine.
        small = {"width": 96, "height": 72, "passes": 1}
        self.assertEqual(scene.preview(**small), scene.preview({"look_at": view}, **small))
        self.assertEqual(scene.preview("camera", width=64, height=32, passes=2)[16:24], b"\0\0\0\x40\0\0\0\x20")
        with self.assertRaises(photond.Invalid):
            scene.preview("camera", width=4096)

    def test_deleting(self):
        (self.folder / "gone.glb").write_bytes(tiny_scene.glb(4))
        scene = self.client.upload_scene(self.folder / "gone.glb")
        scene.delete()
        with self.assertRaises(photond.NotFound):
            self.client.scene(scene.id)

    def test_what_cannot_be_sent_is_named_before_anything_is(self):
        def bad(name, content, words):
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(content)
            with self.subTest(name=name), self.assertRaises(photond.BadFile) as raised:
                self.client.upload_scene(path)
            for word in words:
                self.assertIn(word, str(raised.exception))

        lacking = '{"buffers": [{"uri": "a.bin"}, {"uri": "../b.bin"}], "images": [{"uri": "/c.png"}]}'
        bad("bad/lacking.gltf", lacking, ["a.bin: no such file", "../b.bin: lies outside", "/c.png: lies outside"])
        bad("bad/broken.gltf", "{", ["not a JSON object"])
        bad("bad/scene.obj", "", [".glb"])
        with self.assertRaisesRegex(photond.BadFile, "holds 2 files"):
            self.client.upload_scene(self.folder / "bad")
        with self.assertRaisesRegex(photond.BadFile, "no such file"):
            self.client.upload_scene(self.folder / "not there.glb")

    def test_what_is_of_one_image_is_refused_of_a_sequence(self):
        for of_one in ({"time": 0.5}, {"time": 0}, {"first_pass": 2}):
            for call in (self.client.sequence, self.client.submit_sequence):
                with self.subTest(of_one=of_one), self.assertRaisesRegex(TypeError, "times of their own"):
                    call(self.folder / "not there.glb", frames=2, **of_one)

    def test_a_scene_the_daemon_finds_faults_in(self):
        (self.folder / "broken.glb").write_bytes(b"this is no scene")
        with self.assertRaises(photond.Invalid) as raised:
            self.client.upload_scene(self.folder / "broken.glb")
        self.assertEqual((raised.exception.status, raised.exception.code), (422, "bad_scene"))


class Images(Case):
    def test_layers_are_those_of_the_exr(self):
        job = self.client.render("cornell-box", width=40, height=24, passes=2, layers=["albedo", "normal", "depth"])
        path = job.save(self.folder / "layers.exr")
        for layer, channels in {"beauty": "R G B", "indirect": "indirect.R indirect.G indirect.B",
                                "albedo": "albedo.R albedo.G albedo.B", "normal": "normal.X normal.Y normal.Z",
                                "depth": "depth.Z"}.items():
            with self.subTest(layer=layer):
                image, expected = job.image(layer), exr_layer(path, channels.split())
                self.assertEqual(image.dtype, numpy.float32)
                numpy.testing.assert_array_equal(image.reshape(expected.shape), expected)
                self.assertTrue(image.any())
        image = job.image()
        image[:] = 0  # it is the caller's own
        half = job.image(precision="half")
        self.assertEqual(half.dtype, numpy.float16)
        numpy.testing.assert_allclose(half, job.image(), rtol=1e-3, atol=1e-6)

    def test_without_numpy_pixels_are_there_and_arrays_say_what_is_missing(self):
        job = self.client.render("furnace", **SMALL)
        pixels = job.pixels()
        numpy.testing.assert_array_equal(pixels.at(23, 15), job.image()[15, 23])
        with self.assertRaises(IndexError):
            pixels.at(24, 0)
        with unittest.mock.patch.dict(sys.modules, {"numpy": None}):
            with self.assertRaisesRegex(photond.MissingPackage, "numpy"):
                job.image()

    def test_files(self):
        job = self.client.render("cornell-box", **SMALL, reference="path_tracing:8")
        self.assertEqual(job.save(self.folder / "a.png").read_bytes(), job._repr_png_())
        self.assertEqual(job.exr(), job.save(self.folder / "a.exr").read_bytes())
        self.assertLess(len(job.exr(precision="half")), len(job.exr()))
        self.assertEqual(job.difference()[:4], b"\x76\x2f\x31\x01")
        self.assertEqual(job.preview(max_size=16)[16:24], b"\0\0\0\x10\0\0\0\x0b")
        for png in (job.flip(), job.error_map(), job.preview(layer="indirect", exposure=1, curve="filmic")):
            self.assertEqual(png[:4], b"\x89PNG")
        self.assertIn("curve.csv", job.data["links"]["curve"])
        self.assertTrue(job.download("curve.csv").startswith(b"seconds,"))
        self.assertIn("succeeded after 2 passes", job.log())
        with self.assertRaisesRegex(ValueError, "a.jpg"):
            job.save(self.folder / "a.jpg")
        self.assertEqual([file.name for file in self.folder.iterdir() if ".part" in file.name], [])

    def test_nothing_is_written_where_there_is_nothing(self):
        first, waiting = self.long_job(), self.long_job()
        with self.assertRaises(photond.NothingYet):
            waiting.save(self.folder / "waiting.exr")
        with self.assertRaises(photond.NothingYet):
            waiting.image()
        self.assertIsNone(waiting._repr_png_())
        self.assertEqual(list(self.folder.glob("waiting*")), [])
        first.cancel()

    def test_uploaded_images_measure_and_light(self):
        job = self.client.render("cornell-box", **SMALL)
        path = job.save(self.folder / "upload.exr")
        image = self.client.upload_image(path)
        self.assertEqual((image.width, image.height), (24, 16))
        self.assertEqual(image.data, self.client.image(image.id).data)
        self.assertEqual(sorted(image.layers), ["beauty", "direct", "emitted", "indirect"])
        numpy.testing.assert_array_equal(image.array("indirect"), job.image("indirect"))
        image.save(self.folder / "back.exr")
        self.assertEqual((self.folder / "back.exr").read_bytes(), path.read_bytes())
        for same in (image, path, f"image:{image.id}", job, job.id):
            self.assertEqual(self.client.measure(job, same, ["rmse"])["metrics"]["rmse"], 0)
        lit = self.client.render("cornell-box", **SMALL, environment={"image": path, "scale": 2})
        self.assertEqual(lit.request["environment"]["image"], f"image:{image.id}")
        with self.assertRaises(photond.BadFile):
            self.client.upload_image(self.folder / "picture.jpg")


class Jobs(Case):
    def test_what_is_asked_for_is_what_the_daemon_understands(self):
        camera = photond.look_at([2.7, 2.7, 8], [2.7, 2.7, 0], up=[0, 1, 0], yfov=0.6, aperture=0.01, focus_distance=8)
        job = self.client.submit(
            self.client.scene("cornell-box"), {"name": "photon_mapping", "parameters": {"photons": 500}}, device="cpu",
            parameters={"gather": "direct"}, **SMALL, filter="gaussian", seconds=20, target=("relative_mse", 1e-9),
            first_pass=3, seed=7, layers=["albedo"], camera=camera, glass="solid", reference="path_tracing:4",
            metrics=["indirect:rmse"], priority=5, labels={"asked": "1"})
        asked = job.request
        self.assertEqual(asked["method"]["parameters"]["photons"], 500)
        self.assertEqual(asked["method"]["parameters"]["gather"], "direct")
        self.assertEqual(asked["stop"], {"seconds": 20, "passes": 2, "target": {"metric": "relative_mse", "value": 1e-9}})
        self.assertEqual((asked["first_pass"], asked["seed"], asked["glass"], asked["priority"]), (3, 7, "solid", 5))
        self.assertEqual((asked["layers"], asked["metrics"], job.labels), (["albedo"], ["indirect:rmse"], {"asked": "1"}))
        self.assertEqual(asked["camera"]["look_at"]["eye"], [2.7, 2.7, 8])
        self.assertEqual(asked["camera"]["aperture"], 0.01)
        self.assertEqual(asked["image"], {"width": 24, "height": 16, "filter": "gaussian"})
        job.wait()
        self.assertGreater(job.errors["relative_mse"], 0)
        self.assertEqual([point["passes"] for point in job.curve], [1, 2])
        # What the daemon understood is a request again, and gives the same bits.
        again = self.client.submit_request(job.request).wait()
        self.assertEqual(again.statistics["pixel_hash"], job.statistics["pixel_hash"])

    def test_every_fault_comes_with_its_place(self):
        with self.assertRaises(photond.Invalid) as raised:
            self.client.submit_request({"scene": "cornell-box", "image": {"width": 0, "height": 8, "filtr": "box"},
                                        "method": {"name": "path_tracing"}, "stop": {"passes": 1}})
        refused = raised.exception
        pointers = [fault.pointer for fault in refused.faults]
        self.assertEqual(sorted(pointers), ["/image/filtr", "/image/width"])
        for fault in refused.faults:
            self.assertIn(f"{fault.pointer}: {fault.detail}", str(refused))
        self.assertIn("422", str(refused))
        self.assertIsInstance(refused, (photond.Refused, ValueError))
        with self.assertRaises(TypeError):
            self.client.submit("cornell-box", layers="albedo", **SMALL)
        with self.assertRaises(TypeError):
            self.client.submit("cornell-box", withd=8)
        with self.assertRaises(photond.NotFound) as raised:
            self.client.job("J99999999")
        self.assertEqual(raised.exception.code, "not_found")

    def test_events_tell_how_a_job_comes_to_its_end(self):
        job = self.client.submit("cornell-box", width=32, height=32, seconds=0.7, reference="path_tracing:2")
        seen = list(job.events())
        states = [event.changes["state"] for event in seen if "state" in event.changes]
        self.assertIn(states[0], ("queued", "running"))
        self.assertEqual(states[-1], "succeeded")
        self.assertTrue(all(event.job == job.id for event in seen))
        ids = [event.id for event in seen if event.id is not None]
        self.assertEqual(ids, sorted(ids))
        points = [point["passes"] for event in seen if event.kind == "curve" for point in event.changes["curve"]]
        self.assertTrue(points)
        passes = [point["passes"] for point in job.curve]
        self.assertEqual(passes, sorted(set(passes)))
        self.assertLessEqual(set(points), set(passes))
        self.assertEqual(job.data, self.daemon.job(job.id))

    def test_a_curve_grows_point_by_point_while_a_job_runs(self):
        job = self.client.submit("cornell-box", width=32, height=32, seconds=1.5, reference="path_tracing:2")
        grown = []
        job.wait(on_event=lambda job, event: grown.append(len(job.curve)))
        self.assertEqual(grown, sorted(grown))
        self.assertGreater(len(set(grown)), 2)

    def test_render_waits_no_longer_than_it_is_told_to(self):
        label = {"limited": "1"}
        with self.assertRaises(photond.TimedOut):
            self.client.render("cornell-box", width=32, height=32, seconds=600, labels=label, timeout=0.3)
        [job] = self.client.jobs(label="limited=1")
        self.addCleanup(self.daemon.request, "DELETE", f"/v1/jobs/{job.id}?purge=true")
        self.assertIn(job.state, ("queued", "running"))

    def test_progress_is_told_to_a_function_and_on_standard_error(self):
        seen = []
        job = self.client.render("furnace", **SMALL, progress=lambda job: seen.append((job.id, job.state, job.progress)))
        self.assertEqual(seen[-1], (job.id, "succeeded", 1))
        for progress, said in ((True, "succeeded, 2/2 passes"), (None, None), (False, None)):
            with self.subTest(progress=progress), contextlib.redirect_stderr(io.StringIO()) as told:
                self.client.render("furnace", **SMALL, progress=progress)
                self.assertEqual(told.getvalue(), "") if said is None else self.assertIn(said, told.getvalue())

    def test_a_notebook_shows_one_bar_that_is_updated(self):
        shown = []

        class Handle:
            def update(self, picture):
                shown.append(("updated", picture))

        def display(picture, display_id):
            shown.append(("displayed", picture))
            return Handle()

        shell = types.SimpleNamespace(kernel=object())  # what a notebook's has and a terminal's has not
        ipython = types.SimpleNamespace(get_ipython=lambda: shell, display=types.SimpleNamespace(display=display))
        with unittest.mock.patch.dict(sys.modules, {"IPython": ipython, "IPython.display": ipython.display}):
            self.client.render("furnace", **SMALL)
            self.client.render("furnace", **SMALL, progress=False)
        self.assertEqual([how for how, _ in shown], ["displayed"] + ["updated"] * (len(shown) - 1))
        self.assertGreater(len(shown), 1)
        last = shown[-1][1]
        self.assertIn('value="1.000"', last._repr_html_())
        self.assertRegex(repr(last), r"^J\d+ succeeded, 2/2 passes")  # where nobody shows HTML

    def test_a_timeout_leaves_the_job_running(self):
        job = self.long_job()
        with self.assertRaises(photond.TimedOut) as raised:
            job.wait(timeout=0.5)
        self.assertIsInstance(raised.exception, TimeoutError)
        self.assertIn(job.id, str(raised.exception))
        self.daemon.wait_for_job(job.id, states=("running",))

    def test_cancel_retry_priority_purge(self):
        first, job = self.long_job(), self.long_job(labels={"changed": "1"})
        self.assertEqual([listed.id for listed in self.client.jobs(label="changed=1", scene="cornell-box")], [job.id])
        with self.assertRaises(photond.WrongState):
            job.retry()
        with self.assertRaises(photond.JobCancelled):
            job.cancel().wait()
        self.assertEqual(job.wait(check=False).state, "cancelled")
        self.assertIn(job.retry().state, ("queued", "running"))
        job.cancel().wait(check=False)
        job.purge()
        with self.assertRaises(photond.NotFound):
            job.refresh()
        first.cancel()

    def test_light_rows_and_counts(self):
        jobs = [self.client.render("furnace", width=8, height=4, passes=1, labels={"light": "1"}) for _ in range(3)]
        rows = list(self.client.job_summaries(label="light=1", state=["succeeded", "failed"], device="cpu"))
        self.assertEqual([row["id"] for row in rows], [job.id for job in reversed(jobs)])
        self.assertEqual((rows[0]["scene"], rows[0]["method"], rows[0]["width"], rows[0]["labels"]),
                         ("furnace", "path_tracing", 8, {"light": "1"}))
        self.assertEqual(self.client.count_jobs(label="light=1"), 3)
        self.assertEqual(self.client.count_jobs(label="light=1", state="failed"), 0)
        self.assertEqual(len(list(self.client.job_summaries(label="light=1", limit=2))), 2)

    def test_ctrl_c_cancels_only_where_asked_to(self):
        def interrupt(job, event):
            raise KeyboardInterrupt

        job = self.long_job()
        with self.assertRaises(KeyboardInterrupt):
            job.wait(on_event=interrupt)
        self.assertIn(job.refresh().state, ("queued", "running"))
        with self.assertRaises(KeyboardInterrupt):
            job.wait(on_event=interrupt, cancel_on_interrupt=True)
        self.assertEqual(job.wait(check=False).state, "cancelled")

    def test_a_failed_job_says_why(self):
        with self.assertRaises(photond.Invalid) as raised:
            self.client.render("cornell-box", width=20000, height=20000, passes=1)
        self.assertIn(raised.exception.code, ("out_of_memory", "out_of_range"))
        with Daemon("--max-job-seconds", 0.5) as strict:
            strict.wait_ready()
            with self.assertRaises(photond.JobFailed) as raised:
                photond.Client(url_of(strict)).render("cornell-box", width=32, height=32, seconds=60)
        failed = raised.exception
        self.assertEqual((failed.job.state, failed.code), ("failed", "timed_out"))
        self.assertIn(failed.job.id, str(failed))
        self.assertIn(failed.problem["detail"], str(failed))

    def test_lists_are_taken_page_by_page(self):
        for _ in range(3):
            self.client.render("furnace", width=4, height=4, passes=1, labels={"paged": "1"})
        with unittest.mock.patch("photond._daemon.MOST_ITEMS", 2):
            listed = [job.id for job in self.client.jobs(label="paged=1")]
            self.assertEqual(len(set(listed)), 3)
            self.assertEqual([job.id for job in self.client.jobs(label="paged=1", limit=2)], listed[:2])

    def test_the_whole_daemons_events(self):
        events, found = self.client.events(), []

        def listen():
            for event in events:
                if event.changes.get("state") == "succeeded":
                    found.append(event.job)
                    return

        listener = threading.Thread(target=listen)
        listener.start()
        done = [self.client.render("furnace", **SMALL).id]
        while listener.is_alive():  # it may have begun to listen after that one
            done.append(self.client.render("furnace", **SMALL).id)
            listener.join(0.2)
        self.assertIn(found[0], done)

    def test_threads_share_a_client(self):
        jobs = [self.client.submit("furnace", width=8, height=8, passes=1, seed=i) for i in range(6)]
        threads = [threading.Thread(target=job.wait) for job in jobs]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({job.state for job in jobs}, {"succeeded"})


class Bounds(unittest.TestCase):
    """Errors that are not told apart from 0, and results of before, of a report as the daemon would send it."""

    def comparison(self, points, **row):
        mean = [{"low": None, "high": None, "min": 0, "max": 1, **point} for point in points]
        curve = [{"seconds": point["seconds"], "passes": i + 1, "metrics": {"rmse": point["error"]},
                  **({"intervals": {"rmse": point["interval"]}} if "interval" in point else {})}
                 for i, point in enumerate(points)]
        end = {"value": points[-1]["error"], "low": None, "high": None, "reference": None, "near_reference": True,
               "interval": points[-1].get("interval")}
        table = [{"label": "a", "parameters": {}, "seeds": 1, "passes": None, "seconds": None, "error": {"rmse": end},
                  "mean_curve": {"rmse": mean}, "peak_bytes": None, "efficiency": None, "pareto": True, **row}]
        request = {"metrics": ["rmse"], "scene": "s", "image": {"width": 1, "height": 1}, "entries": []}
        made = photond.Comparison(None, {"id": "C1", "state": "succeeded", "request": request, "table": table,
                                         "reference": {"error": {"rmse": 0.3}}, "headlines": [], "warnings": []})
        made._report = {"table": table, "curves": [{"job": "J1", "points": curve}],
                        "jobs": [{"id": "J1", "label": "a", "parameters": {}, "seed": 1}]}
        return made

    def test_they_are_bounds_in_curves_tables_and_plots(self):
        import matplotlib
        matplotlib.use("agg")
        points = [{"seconds": 1, "error": 0.5, "interval": [0.4, 0.6]}, {"seconds": 2, "error": -0.1, "interval": [-0.3, 0.1]},
                  {"seconds": 4, "error": -0.4, "interval": [-0.6, -0.2]}]
        bias = {"squared_bias": 0.05, "low": 0.04, "high": 0.06, "floor": True}
        made = self.comparison(points, bias={"mse": bias})
        for curve in [*made.curves(), *made.mean_curves()]:
            self.assertEqual((curve.seconds, curve.errors, list(curve.intervals)), ([1], [0.5], [(0.4, 0.6)]))
            self.assertEqual([(bound.seconds, round(bound.below, 9)) for bound in curve.bounds], [(2, 0.1), (4, 0.2)])
        self.assertEqual(made.floors(), {"a": 0.2})
        lines = {line.get_label(): line for line in made.plot().get_lines()}
        self.assertIn("a: reaches no less than 0.2", lines)
        self.assertNotIn("the reference's own noise", lines)
        self.assertEqual(made.rows()[0]["greatest"], -0.2)
        points[-1] = {"seconds": 4, "error": None, "interval": [0, 0.2]}
        self.assertIn("below 0.2 (not told apart from 0)", self.comparison(points).table_text())

    def test_results_of_before_are_read_as_they_were(self):
        made = self.comparison([{"seconds": 1, "error": 0.5}, {"seconds": 2, "error": 0.2}, {"seconds": 4, "error": 0.1}])
        [curve] = made.mean_curves()
        self.assertEqual((curve.errors, list(curve.intervals), list(curve.bounds)), ([0.5, 0.2, 0.1], [None] * 3, []))
        self.assertEqual((made.rows()[0]["least"], made.rows()[0]["bias"], made.floors()), (None, None, {}))
        self.assertIn("the reference's own noise", [line.get_label() for line in made.plot().get_lines()])
        self.assertIn("near the reference's noise", made.table_text())


class Comparisons(Case):
    @classmethod
    def setUpClass(cls):
        cls.comparison = fixture.client.compare(
            "cornell-box", [photond.entry("path_tracing", "paths"),
                            photond.entry("photon_mapping", "map", parameters={"gather": "direct"},
                                          sweep={"photons": [500, 2000]})],
            width=24, height=24, passes=8, reference="path_tracing:64", seeds=[1, 2, 3],
            metrics=["relative_mse", "indirect:relative_mse"])

    def test_curves_are_those_of_the_jobs(self):
        curves = self.comparison.curves()
        self.assertEqual(len(curves), 9)
        for curve in curves:
            job = self.client.job(curve.job)
            self.assertEqual(curve.passes, [point["passes"] for point in job.curve])
            self.assertEqual(curve.errors, [point["metrics"]["relative_mse"] for point in job.curve])
            self.assertEqual(job.request["seed"], curve.seed)
        self.assertEqual([curve.name for curve in curves[3:6]], ["map, photons 500"] * 3)

    def test_means_over_seeds_lie_between_the_seeds(self):
        for metric in self.comparison.metrics:
            means = self.comparison.mean_curves(metric)
            self.assertEqual([mean.name for mean in means], [row["name"] for row in self.comparison.rows(metric)])
            for mean in means:
                curves = [curve for curve in self.comparison.curves(metric) if curve.name == mean.name]
                self.assertEqual(mean.seconds, sorted(mean.seconds))
                begin, end = max(curve.seconds[0] for curve in curves), min(curve.seconds[-1] for curve in curves)
                if begin <= end:
                    self.assertEqual((mean.seconds[0], mean.seconds[-1]), (begin, end))
                else:  # on a machine so busy that the seeds share no time
                    self.assertEqual(len(mean.seconds), 1)
                for error, low, high in zip(mean.errors, mean.low, mean.high):
                    self.assertLess(low, error)
                    self.assertLess(error, high)
                self.assertLessEqual(min(min(curve.errors) for curve in curves), min(mean.errors))

    def test_times_to_errors_are_the_daemons(self):
        """A curve read here and there: the table's times are means over the seeds of what one curve gives."""
        compared = 0
        for metric in self.comparison.metrics:
            for row in self.comparison.table:
                name = photond.MeanCurve(row["label"], row["parameters"], [], [], None, None).name
                curves = [curve for curve in self.comparison.curves(metric) if curve.name == name]
                for point in row["time_to_error"][metric]:
                    times = [photond.curves.time_to_error(curve, point["error"]) for curve in curves]
                    reached = [time for time in times if time is not None]
                    self.assertEqual(len(reached), point["reached"])
                    if point["seconds"] is not None:
                        mean = numpy.exp(numpy.mean(numpy.log(reached)))
                        self.assertAlmostEqual(mean / point["seconds"], 1, places=5)
                        compared += 1
        self.assertGreater(compared, 0)

    def test_errors_have_what_the_reference_leaves_open(self):
        self.assertEqual(self.comparison.reference["form"], "two_films")
        for curve in self.comparison.curves():
            self.assertEqual(len(curve.intervals), len(curve.errors))
            for error, interval in zip(curve.errors, curve.intervals):
                self.assertLess(interval.least, error)
                self.assertLess(error, interval.greatest)
        job = self.client.job(self.comparison.job_ids[0])
        self.assertEqual(job.reference_jobs, self.comparison.reference["jobs"])
        least, greatest = job.error_intervals["relative_mse"]
        self.assertLess(least, job.errors["relative_mse"])
        self.assertLess(job.errors["relative_mse"], greatest)
        row = self.comparison.rows()[0]
        self.assertLess(row["least"], row["greatest"])

    def test_bias_and_its_map(self):
        # It is measured when nothing renders.
        self.daemon.wait_until(lambda: all(row["bias"] for row in self.comparison.refresh().rows()), "bias is measured")
        for row in self.comparison.rows():
            bias = row["bias"]
            self.assertLess(bias["low"], bias["squared_bias"])
            self.assertLess(bias["variance_low"], bias["variance_high"])
            self.assertTrue(bias["text"])
        map = self.comparison.bias_map("map, photons 500", layer="indirect")
        self.assertEqual((map.data["row"], map.data["layer"], map.png[:4]), (1, "indirect", b"\x89PNG"))
        self.assertEqual(map.array().shape, (map.data["height"], map.data["width"]))
        self.assertEqual(sum(found for row in map.found for found in row), map.data["found"])
        map.save(self.folder / "map.png")
        self.assertEqual((self.folder / "map.png").read_bytes(), map._repr_png_())
        self.assertIn(map.text, repr(map))
        with self.assertRaisesRegex(ValueError, "map, photons 2000"):
            self.comparison.bias_map("map")

    def test_tables(self):
        rows = self.comparison.rows("indirect:relative_mse")
        self.assertEqual([row["name"] for row in rows], ["paths", "map, photons 500", "map, photons 2000"])
        self.assertEqual([row["passes"] for row in rows], [8, 8, 8])
        for row in rows:
            self.assertLess(row["low"], row["error"])
            self.assertLess(row["error"], row["high"])
            self.assertGreater(row["peak_bytes"], 0)
        self.assertIn("map, photons 2000", str(self.comparison))
        self.assertTrue(self.comparison.verdicts)
        self.assertIn(self.comparison.verdicts[0], str(self.comparison))
        self.assertEqual(list(self.comparison.headlines.values()),
                         [headline["text"] for headline in self.comparison.data["headlines"]])
        for metric in self.comparison.metrics:
            self.assertIn(f"By {metric}: {self.comparison.headlines[metric]}.", str(self.comparison))
        html = self.comparison._repr_html_()
        self.assertEqual(html.count("<tr>"), 4)
        self.assertIn(f"By relative_mse: {self.comparison.headlines['relative_mse']}.", html)
        reached = self.comparison.time_to_error(1e9)
        for mean in self.comparison.mean_curves():  # one point alone is borne out by no other
            self.assertEqual(reached[mean.name], mean.seconds[0] if len(mean.seconds) > 1 else None)
        self.assertEqual(set(self.comparison.time_to_error(1e-9).values()), {None})

    def test_a_plot(self):
        import matplotlib
        matplotlib.use("agg")
        axes = self.comparison.plot()
        self.assertEqual((axes.get_xscale(), axes.get_yscale(), axes.get_ylabel()), ("log", "log", "relative_mse"))
        means = self.comparison.mean_curves()
        lines = [line for line in axes.get_lines() if not line.get_label().startswith("_")]
        for line, mean in zip(lines, means):
            drawn = [(time, error) for time, error in zip(line.get_xdata(), line.get_ydata()) if error == error]
            self.assertEqual((line.get_label(), drawn), (mean.name, list(zip(mean.seconds, mean.errors))))
        floors = self.comparison.floors()
        self.assertEqual(len(lines), 3 + len(floors))  # the reference's noise has no part in the errors
        axes.figure.savefig(self.folder / "plot.svg")
        with unittest.mock.patch.dict(sys.modules, {"matplotlib.pyplot": None}):
            with self.assertRaisesRegex(photond.MissingPackage, "matplotlib"):
                self.comparison.plot()

    def test_reports(self):
        for name, begins in (("report.html", b"<!doctype html>"), ("report.csv", b"label,"), ("report.json", b"{")):
            self.comparison.save_report(self.folder / name)
            self.assertTrue((self.folder / name).read_bytes().lower().startswith(begins), name)
        with self.assertRaisesRegex(ValueError, "report.pdf"):
            self.comparison.save_report("report.pdf")

    def test_one_from_the_list_gets_its_table_when_it_is_asked_for(self):
        def listed_alike():
            listed = next(found for found in self.client.comparisons() if found.id == self.comparison.id)
            self.assertNotIn("table", listed.data)
            return listed.table == self.comparison.refresh().table and listed  # bias comes into it after the last job
        listed = self.daemon.wait_until(listed_alike, "its table is the same")
        self.assertEqual([job.id for job in listed.jobs], self.comparison.job_ids)

    def test_a_comparison_that_is_cancelled(self):
        comparison = self.client.submit_comparison("cornell-box", ["path_tracing"], width=32, height=32, seconds=600,
                                                   reference="path_tracing:2")
        with self.assertRaises(photond.TimedOut):
            comparison.wait(timeout=0.3)
        comparison.cancel()
        with self.assertRaisesRegex(photond.ComparisonFailed, comparison.id):
            comparison.wait()
        comparison.purge()
        with self.assertRaises(photond.NotFound):
            comparison.refresh()


class Help(Case):
    def test_a_method_shows_what_the_daemon_declares(self):
        declared = self.daemon.request("GET", "/v1/methods/photon_mapping").json
        method = self.client.methods["photon_mapping"]
        page = str(method)
        for name, schema in declared["parameters"]["properties"].items():
            self.assertIn(name, page)
            self.assertIn(schema["description"], page)
            self.assertIn(method.parameters[name].range_text, page)
            self.assertIn(schema.get("x-unit", ""), method._repr_html_())
        self.assertEqual(list(method.parameters), declared["parameters"]["x-order"])
        self.assertIn("photon_mapping", str(self.client.methods))
        self.assertEqual(set(self.client.methods), {m["name"] for m in self.daemon.request("GET", "/v1/methods").json["items"]})

    def test_a_misspelt_argument_is_a_fault_of_the_call_that_was_made(self):
        for call, arguments, said in (
                (self.client.render, {"pases": 1}, r"^Client\.render\(\) has no argument 'pases'; did you mean 'passes'\?$"),
                (self.client.sequence, {"frmes": 2}, r"^Client\.sequence\(\) has no argument 'frmes'; did you mean 'frames'\?$"),
                (self.client.compare, {"entries": [], "sceds": 1}, r"^Client\.compare\(\) has no argument 'sceds'; did you mean 'seeds'\?$"),
                (self.client.submit, {"photons": 5}, r"^Client\.submit\(\) .*parameters=\{'photons': 5\}$"),
                (self.client.submit, {"timeout": 5}, r"^Client\.submit\(\) has no argument 'timeout'"),  # it does not wait
                (self.client.render, {"scene": "furnace"}, r"^Client\.render\(\): multiple values for argument 'scene'$")):
            with self.subTest(arguments=arguments), self.assertRaisesRegex(TypeError, said):
                call("furnace", **arguments)
        with self.assertRaisesRegex(TypeError, r"^Client\.render\(\): missing a required argument: 'scene'$"):
            self.client.render()

    def test_help_has_the_arguments(self):
        import inspect
        arguments = inspect.signature(photond.Client.render).parameters
        self.assertIn("passes", arguments)
        self.assertIn("first one met ends the job", photond.Client.render.__doc__)


class Doors(Case):
    def test_a_token_comes_from_the_environment_an_argument_or_a_file(self):
        made = subprocess.run([str(BIN / "photond"), "--new-token", "tester:write"], capture_output=True, text=True, check=True)
        token = re.search(r"[^\s:]{40,}", made.stdout)[0]
        tokens = self.folder / "tokens"
        tokens.write_text(re.search(r"tester write sha256:\w+", made.stdout)[0] + "\n")
        tokens.chmod(0o600)
        (self.folder / "token").write_text(token + "\n")
        (self.folder / "empty").write_text("\n")
        with Daemon("--tokens", tokens) as guarded:
            guarded.wait_ready()
            url = url_of(guarded)
            with self.assertRaises(photond.Denied) as raised:
                photond.Client(url).status()
            self.assertEqual(raised.exception.status, 401)
            with self.assertRaises(photond.Denied):
                photond.Client(url, "wrong").status()
            photond.Client(url, token).status()
            photond.Client(url, token_file=self.folder / "token").status()
            with unittest.mock.patch.dict(os.environ, {"PHOTOND_URL": url, "PHOTOND_TOKEN": token}):
                client = photond.Client()
                self.assertEqual(client.url, url)
                self.assertEqual(client.render("furnace", **SMALL).state, "succeeded")  # events want the token too
            with self.assertRaisesRegex(ValueError, "no token"):
                photond.Client(url, token_file=self.folder / "empty")

    def test_addresses_that_are_none(self):
        for url in ("127.0.0.1:8080", "ftp://here", "http://", "http://here:port", "http://here/?a=b"):
            with self.subTest(url=url), self.assertRaises(ValueError):
                photond.Client(url)

    def test_what_answers_is_no_daemon(self):
        import http.server

        class Other(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200 if self.path == "/v1/status" else 500)
                self.end_headers()
                self.wfile.write(b"<html>")

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Other) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            client = photond.Client(f"http://127.0.0.1:{server.server_port}/")
            with self.assertRaisesRegex(photond.ProtocolError, "photond daemon"):
                client.status()
            with self.assertRaises(photond.ServerFault):
                client.devices()
            server.shutdown()

    def test_devices_and_figures(self):
        self.assertEqual(self.client.devices(), self.daemon.request("GET", "/v1/devices").json["items"])
        self.assertIn("# HELP", self.client.metrics_text())
        estimate = self.client.estimate("cornell-box", width=64, height=64, passes=4)
        self.assertRegex(str(estimate), r"^memory [\d.]+ MB; time ")


if __name__ == "__main__":
    unittest.main()
