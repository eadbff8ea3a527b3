"""Every body the API takes and gives validates against /v1/openapi.json, both ways: what the document allows is taken,
what it forbids is refused, and every answer is one that it announces.
"""

import json
import random
import re
import unittest

import malformed_jobs_test as malformed
import tiny_scene
from jsonschema import Draft202012Validator
from photond_daemon import Daemon, Reply, small_job

# Faults that no schema can express: they depend on what the daemon holds, or relate one field to another.
BEYOND_SCHEMAS = {"/scene", "/camera/name", "/camera/look_at", "/camera/look_at/target", "/camera/look_at/up",
                  "/camera/focus_distance", "/environment/image", "/animation", "/method/device",
                  "/method/parameters/radius_relative", "/reference", "/reference/method/device",
                  "/reference/stop/target/metric", "/stop/target/metric",
                  "/metrics", "/metrics/0", "/metrics/1"}


SEQUENCE = {"scene": "moving/teleport", "image": {"width": 8, "height": 8}, "method": {"name": "path_tracing"},
            "stop": {"passes": 1}, "to": 1, "fps": 2}
COMPARISON = {"scene": "cornell-box", "image": {"width": 8, "height": 8},
              "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 8}},
              "entries": [{"label": "paths", "method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": [1, 2]}},
                          {"method": {"name": "photon_mapping", "parameters": {"photons": 100, "gather_rays": 1}}}],
              "stop": {"passes": 2}, "metrics": ["relative_mse"], "seeds": [1, 2]}


class Document:
    def __init__(self, document):
        self.document = document
        self.validators = {}

    def validator(self, schema):
        key = json.dumps(schema, sort_keys=True)
        if key not in self.validators:
            whole = {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema,
                     "components": self.document["components"]}
            self.validators[key] = Draft202012Validator(whole)
        return self.validators[key]

    def component(self, name):
        return self.validator({"$ref": f"#/components/schemas/{name}"})

    def operation(self, method, path):
        """The operation that a request is of; None for a path that is not served."""
        bare = path.split("?")[0]
        for pattern, methods in sorted(self.document["paths"].items(), key=lambda item: item[0].count("{")):
            if re.fullmatch(re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(pattern)), bare) and method.lower() in methods:
                return methods[method.lower()]
        return None


class OpenApiTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.daemon.wait_ready()
        cls.api = Document(cls.daemon.request("GET", "/v1/openapi.json").json)
        cls.answered = set()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def check(self, validator, value, what):
        errors = [f"{error.json_path}: {error.message[:300]}" for error in validator.iter_errors(value)]
        self.assertEqual(errors, [], what)

    def ask(self, method, path, body=None, headers=None, json_body=None):
        """A request whose answer is held to the document."""
        reply = self.daemon.request(method, path, body=body, headers=headers, json_body=json_body)
        self.hold_to_document(method, path, reply)
        return reply

    def hold_to_document(self, method, path, reply):
        what = f"{method} {path} -> {reply.status}"
        operation = self.api.operation(method, path)
        media_type = reply.headers.get("content-type", "").split(";")[0]
        if reply.status >= 400:
            self.assertEqual(media_type, "application/problem+json", what)
            self.check(self.api.component("Problem"), reply.json, what)
            self.assertEqual(reply.json["status"], reply.status)
            return
        self.assertIsNotNone(operation, what)
        self.assertIn(str(reply.status), operation["responses"], what)
        self.answered.add((operation["operationId"], reply.status))
        content = operation["responses"][str(reply.status)].get("content")
        if content is None:
            self.assertEqual(reply.body, b"", what)
            return
        self.assertIn(media_type, content, what)
        if media_type == "application/json":
            self.check(self.api.validator(content[media_type]["schema"]), reply.json, what)

    # --- the document itself

    def test_all_schemas_are_schemas(self):
        def schemas(value):
            if isinstance(value, dict):
                for key, inner in value.items():
                    if key == "schema":
                        yield inner
                    yield from schemas(inner)
            elif isinstance(value, list):
                for inner in value:
                    yield from schemas(inner)
        found = list(schemas(self.api.document["paths"])) + list(self.api.document["components"]["schemas"].values())
        self.assertGreater(len(found), 50)
        for schema in found:
            Draft202012Validator.check_schema(schema)
        for method in self.daemon.request("GET", "/v1/methods").json["items"]:
            Draft202012Validator.check_schema(method["parameters"])
            self.assertEqual(self.api.document["components"]["schemas"]["Parameters." + method["name"]],
                             method["parameters"])

    def test_the_document_names_what_is_served_and_no_more(self):
        for path, methods in self.api.document["paths"].items():
            concrete = re.sub(r"\{\w+\}", "none", path)
            # The daemon itself says which methods a path has.
            reply = self.daemon.request("BREW", concrete)
            self.assertEqual(reply.status, 405, path)
            allowed = set(reply.headers["allow"].split(", ")) - {"HEAD"}
            # "/v1/jobs/merge" is also the place of a job of that name, which is never there.
            named = [other for pattern, other in self.api.document["paths"].items()
                     if pattern == path or "{" not in path and re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", pattern), path)]
            self.assertEqual(allowed, {method.upper() for methods in named for method in methods}, path)

    # --- answers

    def test_every_answer_is_announced(self):
        ask = self.ask
        binary = {"Content-Type": "model/gltf-binary"}
        for path in ("/healthz", "/readyz", "/metrics", "/favicon.svg", "/v1/status",
                     "/v1/openapi.json", "/v1/methods", "/v1/methods/path_tracing", "/v1/devices", "/v1/layers",
                     "/v1/metrics", "/v1/scenes?limit=1000", "/v1/jobs"):
            self.assertEqual(ask("GET", path).status, 200, path)
        page = ask("GET", "/")
        for kind in ("js", "css"):
            self.assertEqual(ask("GET", re.search(rf"/assets/[\w.-]+\.{kind}", page.text).group()).status, 200, kind)
        for path in self.api.document["paths"]:  # wherever one goes in it, the dashboard is one page
            if self.api.document["paths"][path].get("get", {}).get("operationId", "").startswith("showDashboard"):
                self.assertEqual(ask("GET", re.sub(r"\{\w+\}", "none", path)).body, page.body, path)
        scene = ask("POST", "/v1/scenes?name=x", tiny_scene.glb(), binary).json
        ask("POST", "/v1/scenes", tiny_scene.glb(), binary)
        ask("GET", f"/v1/scenes/{scene['id']}")
        ask("GET", f"/v1/scenes/{scene['id']}/thumbnail.png")
        self.assertEqual(ask("GET", f"/v1/scenes/{scene['id']}/baked").status, 200)
        self.assertEqual(ask("GET", f"/v1/scenes/{scene['id']}/preview.png").status, 200)
        for builtin in [item for item in ask("GET", "/v1/scenes?limit=1000").json["items"] if item["builtin"]]:
            ask("GET", f"/v1/scenes/{builtin['id']}")
        self.assertEqual(ask("POST", "/v1/jobs?dry_run=true", json_body=small_job(scene=scene["id"])).status, 200)
        job = ask("POST", "/v1/jobs", json_body=small_job(scene=scene["id"], layers=["albedo"])).json
        self.daemon.wait_for_job(job["id"])
        ask("GET", f"/v1/jobs/{job['id']}")
        for name in ("image.exr", "preview.png", "pixels", "statistics.json", "log.txt"):
            self.assertEqual(ask("GET", f"/v1/jobs/{job['id']}/{name}").status, 200, name)
        rendered = ask("POST", "/v1/render?wait=400", json_body=small_job())
        self.assertEqual(rendered.status, 200)
        self.daemon.request("DELETE", rendered.headers["location"] + "?purge=true")
        self.measured(scene["id"], job["id"])
        photons = {"name": "photon_mapping", "parameters": {"photons": 1000, "gather_rays": 1, "keep_photon_map": True}}
        kept = ask("POST", "/v1/jobs", json_body={**small_job(), "method": photons}).json
        self.daemon.wait_for_job(kept["id"])
        ask("GET", f"/v1/jobs/{kept['id']}")
        self.assertEqual(ask("GET", f"/v1/jobs/{kept['id']}/photon_map.glb").status, 200)
        exr = self.daemon.request("GET", f"/v1/jobs/{job['id']}/image.exr").body
        image = ask("POST", "/v1/images", exr, {"Content-Type": "image/x-exr"}).json
        ask("POST", "/v1/images", exr, {"Content-Type": "image/x-exr"})
        ask("GET", f"/v1/images/{image['id']}")
        ask("GET", f"/v1/images/{image['id']}/file")
        self.assertEqual(ask("GET", f"/v1/images/{image['id']}/pixels").status, 200)
        flip = f"/v1/flip?reference=image:{image['id']}&image=job:"
        self.assertEqual(ask("GET", flip + job["id"]).status, 200)
        backup = ask("POST", "/v1/backups").json
        self.assertEqual(ask("GET", f"/v1/backups/{backup['id']}").json, backup)
        self.assertEqual(ask("GET", f"/v1/backups/{backup['id']}/file?path=store.sqlite").status, 200)
        self.assertEqual(ask("DELETE", f"/v1/backups/{backup['id']}").status, 200)
        long_jobs = [ask("POST", "/v1/jobs", json_body={**small_job(), "stop": {"seconds": 3600}}).json["id"]
                     for _ in range(2)]
        ask("GET", "/v1/jobs")
        self.assertEqual(len(ask("GET", "/v1/jobs?view=summary&state=queued,running").json["items"]), 2)
        self.assertEqual(ask("PATCH", f"/v1/jobs/{long_jobs[1]}", json_body={"priority": 5}).status, 200)
        for name in ("image.exr", "preview.png", "pixels", "statistics.json"):
            self.assertEqual(ask("GET", f"/v1/jobs/{long_jobs[1]}/{name}").status, 202, name)
        self.assertEqual(ask("GET", flip + long_jobs[1]).status, 202)
        self.daemon.wait_for_job(long_jobs[0], states=("running",))
        for name in ("thumbnail.png", "preview.png"):  # of a scene that nobody has looked at
            reply = ask("GET", f"/v1/scenes/keyhole/{name}", headers={"Prefer": "respond-async"})
            self.assertEqual((reply.status, reply.headers["preference-applied"]), (202, "respond-async"), name)
        late = ask("POST", "/v1/render?wait=0", json_body=small_job())
        self.assertEqual(late.status, 202)
        long_jobs.append(late.json["id"])
        waiting = ask("POST", "/v1/jobs", json_body={**small_job(), "method": photons}).json["id"]
        self.assertEqual(ask("GET", f"/v1/jobs/{waiting}/photon_map.glb").status, 202)
        long_jobs.append(waiting)
        for job_id in long_jobs:
            ask("DELETE", f"/v1/jobs/{job_id}")
            self.daemon.wait_for_job(job_id)
            ask("GET", f"/v1/jobs/{job_id}")
        ask("POST", f"/v1/jobs/{long_jobs[0]}/retry")
        ask("DELETE", f"/v1/jobs/{long_jobs[0]}?purge=true")
        self.assertEqual(ask("DELETE", f"/v1/jobs/{long_jobs[1]}").status, 200)
        self.daemon.request("DELETE", f"/v1/jobs/{kept['id']}?purge=true")
        for job_id in long_jobs:
            self.daemon.request("DELETE", f"/v1/jobs/{job_id}?purge=true")
        repeated = ask("POST", f"/v1/jobs/{job['id']}/repeat").json["id"]
        self.daemon.wait_for_job(repeated)
        self.daemon.request("DELETE", f"/v1/jobs/{repeated}?purge=true")
        self.assertEqual(ask("DELETE", f"/v1/jobs/{job['id']}?purge=true").status, 200)
        self.assertEqual(ask("DELETE", f"/v1/scenes/{scene['id']}").status, 200)
        self.ask_about_comparisons()
        self.ask_about_sequences()
        announced = {(operation["operationId"], int(status))
                     for methods in self.api.document["paths"].values() for operation in methods.values()
                     for status in operation["responses"] if status != "default"}
        # Event streams never end, so the plain request above cannot read them; api_test does.
        self.assertEqual({entry for entry in announced - self.answered if not entry[0].endswith("Events")}, set())

    def ask_about_sequences(self):
        ask = self.ask
        self.assertEqual(ask("POST", "/v1/sequences?dry_run=true", json_body=SEQUENCE).status, 200)
        done = ask("POST", "/v1/sequences", json_body=SEQUENCE).json
        self.daemon.wait_for_state(f"/v1/sequences/{done['id']}", ("succeeded",))
        ask("GET", f"/v1/sequences/{done['id']}")
        self.assertEqual(len(ask("GET", "/v1/sequences").json["items"]), 1)
        self.assertEqual(ask("GET", f"/v1/sequences/{done['id']}/frames.zip?images=png").status, 200)
        self.assertEqual(ask("GET", f"/v1/sequences/{done['id']}/video?format=png").status, 200)
        self.assertEqual(ask("GET", f"/v1/sequences/{done['id']}/report.html").status, 200)
        references = [ask("POST", "/v1/sequences", json_body={**SEQUENCE, "seed": seed}).json["id"] for seed in (100, 200)]
        for id in references:
            self.daemon.wait_for_state(f"/v1/sequences/{id}", ("succeeded",))
        errors = f"/v1/sequences/{done['id']}/errors?first={references[0]}&second="
        self.assertEqual(ask("GET", errors + references[1]).status, 200)
        self.assertEqual(ask("GET", errors + references[0]).status, 422)
        long = ask("POST", "/v1/sequences", json_body={**SEQUENCE, "stop": {"seconds": 3600}}).json
        self.assertEqual(ask("DELETE", f"/v1/sequences/{long['id']}").status, 202)
        self.assertEqual(ask("GET", f"/v1/sequences/{long['id']}/frames.zip").status, 202)
        self.assertEqual(ask("GET", f"/v1/sequences/{long['id']}/video").status, 202)
        self.daemon.wait_for_state(f"/v1/sequences/{long['id']}", ("cancelled",))
        for sequence in (long, done):
            self.assertEqual(ask("DELETE", f"/v1/sequences/{sequence['id']}?purge=true").status, 200)

    def ask_about_comparisons(self):
        ask = self.ask
        self.assertEqual(ask("POST", "/v1/comparisons?dry_run=true", json_body=COMPARISON).status, 200)
        compared = ask("POST", "/v1/comparisons", json_body=COMPARISON).json
        self.daemon.wait_for_state(f"/v1/comparisons/{compared['id']}", ("succeeded",))
        ask("GET", f"/v1/comparisons/{compared['id']}")
        self.assertEqual(len(ask("GET", "/v1/comparisons").json["items"]), 1)
        changed = ask("PATCH", f"/v1/comparisons/{compared['id']}", json_body={"title": "x", "notes": "a\nb"})
        self.assertEqual((changed.status, changed.json["request"]["title"]), (200, "x"))
        for name in ("report.json", "report.csv", "report.html"):
            self.assertEqual(ask("GET", f"/v1/comparisons/{compared['id']}/{name}").status, 200, name)
        for name in ("bias.json", "bias.png"):
            path = f"/v1/comparisons/{compared['id']}/rows/0/{name}"
            # The pictures that nobody waited for may be drawn before it.
            drawn = self.daemon.wait_until(lambda: (reply := ask("GET", path)).status != 503 and reply, f"{name} is drawn")
            self.assertEqual(drawn.status, 200)
        long = ask("POST", "/v1/comparisons", json_body={**COMPARISON, "stop": {"seconds": 3600}}).json
        self.assertEqual(ask("DELETE", f"/v1/comparisons/{long['id']}").status, 202)
        self.daemon.wait_for_state(f"/v1/comparisons/{long['id']}", ("cancelled",))
        for comparison in (long, compared):
            self.assertEqual(ask("DELETE", f"/v1/comparisons/{comparison['id']}?purge=true").status, 200)

    def measured(self, scene, reference):
        """What there is of errors, extended and merged jobs."""
        ask = self.ask
        job = ask("POST", "/v1/jobs", json_body=small_job(scene=scene, passes=2, reference=f"job:{reference}",
                                                          metrics=["indirect:rmse", "flip_hdr"])).json
        self.daemon.wait_for_job(job["id"])
        ask("GET", f"/v1/jobs/{job['id']}")
        for name in ("curve.csv", "difference.exr", "flip.png", "error.png", "film", "statistics.json"):
            self.assertEqual(ask("GET", f"/v1/jobs/{job['id']}/{name}").status, 200, name)
        pair = {"image": f"job:{job['id']}", "reference": f"job:{reference}"}
        self.assertEqual(ask("POST", "/v1/metrics", json_body=pair).status, 200)
        self.check(self.api.component("MeasurementRequest"), pair, "a measurement")
        stop = {"stop": {"passes": 4}}
        self.check(self.api.component("Extension"), stop, "an extension")
        self.assertEqual(ask("POST", f"/v1/jobs/{job['id']}/extend", json_body=stop).status, 202)
        self.daemon.wait_for_job(job["id"])
        merged = ask("POST", "/v1/jobs/merge", json_body={"jobs": [job["id"]]})
        self.assertEqual(merged.status, 201, merged)
        made = {"method": {"name": "path_tracing"}, "stop": {"seconds": 3600}}
        waiting = ask("POST", "/v1/jobs", json_body=small_job(scene=scene, reference=made)).json
        for name in ("curve.csv", "difference.exr", "flip.png", "error.png", "film"):
            self.assertEqual(ask("GET", f"/v1/jobs/{waiting['id']}/{name}").status, 202, name)
        self.assertEqual(ask("DELETE", f"/v1/jobs/{waiting['reference_job']}").status, 202)
        self.daemon.wait_for_job(waiting["id"])
        ask("GET", f"/v1/jobs/{waiting['id']}")
        for job_id in (job["id"], merged.json["id"], waiting["id"], *waiting["reference_jobs"]):
            self.daemon.wait_for_job(job_id)
            self.daemon.request("DELETE", f"/v1/jobs/{job_id}?purge=true")

    def test_every_refusal_is_a_problem(self):
        for method, path, options in (
                ("GET", "/none", {}), ("PUT", "/v1/jobs", {}), ("GET", "/v1/jobs/none", {}),
                ("DELETE", "/v1/scenes/cornell-box", {}), ("GET", "/v1/jobs?limit=0", {}),
                ("POST", "/v1/jobs", {"body": b"x", "headers": {"Content-Type": "text/plain"}}),
                ("POST", "/v1/jobs", {"body": b"{", "headers": {"Content-Type": "application/json"}}),
                ("POST", "/v1/scenes", {"body": b"no", "headers": {"Content-Type": "model/gltf-binary"}}),
                ("POST", "/v1/images", {"body": b"no", "headers": {"Content-Type": "image/x-exr"}}),
                ("POST", "/v1/jobs/none/retry", {}), ("POST", "/v1/jobs/none/repeat", {}),
                ("POST", "/v1/jobs/none/extend", {"json_body": {}}),
                ("PATCH", "/v1/jobs/none", {"json_body": {"priority": 1}}), ("PATCH", "/v1/jobs/none", {"json_body": {}}),
                ("POST", "/v1/comparisons?dry_run=true", {"json_body": {}}), ("GET", "/v1/jobs?view=x", {}),
                ("POST", "/v1/jobs/merge", {"json_body": {"jobs": ["none"]}}),
                ("POST", "/v1/metrics", {"json_body": {"image": "none"}}), ("GET", "/v1/jobs?role=x", {}),
                ("GET", "/v1/flip", {}), ("GET", "/v1/images/none/pixels", {}),
                ("GET", "/v1/comparisons/C999", {}), ("GET", "/v1/scenes/none/baked", {}),
                ("GET", "/v1/comparisons/none/report.html", {}), ("DELETE", "/v1/comparisons/none", {}),
                ("POST", "/v1/comparisons", {"json_body": {}})):
            self.assertGreaterEqual(self.ask(method, path, **options).status, 400)

    # --- requests

    def test_comparisons_are_taken_and_refused_as_the_schema_says(self):
        schema = self.api.component("ComparisonRequest")
        self.check(schema, COMPARISON, "the body")
        for change in ({"entries": []}, {"entries": None}, {"entries": [{"label": "x"}]}, {"entries": [{"method": {}}]},
                       {"entries": [{"method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": []}}]},
                       {"entries": [{"method": {"name": "path_tracing"}, "sweep": {"indirect_bounces": [None]}}]},
                       {"entries": [{"method": {"name": "path_tracing"}, "sweep": [1]}]},
                       {"entries": [{"method": {"name": "path_tracing"}, "more": 1}]},
                       {"entries": [{"method": {"name": "path_tracing"}, "label": ""}]},
                       {"seeds": []}, {"seeds": [1, 1]}, {"seeds": [-1]}, {"seeds": ["1"]}, {"seeds": 1},
                       {"metrics": []}, {"metrics": ["no_metric"]}, {"metrics": ["rmse", "rmse"]}, {"stop": {}},
                       {"stop": None}, {"image": {"width": 0, "height": 1}}, {"scene": None}, {"reference": "J1"},
                       {"method": {"name": "path_tracing"}}, {"seed": 1}, {"first_pass": 1}):
            body = {**COMPARISON, **change}
            with self.subTest(change=change):
                self.assertFalse(schema.is_valid(body))
                self.assertEqual(self.ask("POST", "/v1/comparisons", json_body=body).status, 422)

    def test_what_the_reader_refuses_the_schema_refuses(self):
        schema = self.api.component("JobRequest")
        self.assertTrue(schema.is_valid(malformed.BASE))
        self.assertTrue(schema.is_valid(malformed.RICH))
        let_through = []
        for at, value, pointer in malformed.FAULTS:
            body = malformed.changed(at, value)
            if schema.is_valid(body):
                let_through.append((at, pointer or at, repr(value)[:80]))
        self.assertEqual([fault for fault in let_through if fault[1] not in BEYOND_SCHEMAS], [])
        self.assertLess(len(let_through), 30, let_through)  # of some three hundred

    def test_what_the_reader_takes_the_schema_takes_and_back(self):
        schema = self.api.component("JobRequest")
        source = random.Random(99)
        poster = malformed.Poster(self.daemon)
        self.addCleanup(poster.connection.close)
        taken = refused = 0
        for _ in range(1500):
            text = malformed.mutated_value(source)
            status, media_type, answer = poster.post(text)
            body = json.loads(text)
            if status == 202:
                taken += 1
                self.check(schema, body, text)
                job = json.loads(answer)
                self.check(self.api.component("Job"), job, text)
                self.check(schema, job["request"], "the echo")
                self.daemon.request("DELETE", f"/v1/jobs/{job['id']}?purge=true")
                continue
            refused += 1
            self.hold_to_document("POST", "/v1/jobs", Reply(status, {"content-type": media_type}, answer))
            if schema.is_valid(body):
                pointers = {error["pointer"] for error in json.loads(answer)["errors"]}
                self.assertLessEqual(pointers, BEYOND_SCHEMAS, text)
        self.assertGreater(taken, 50)
        self.assertGreater(refused, 500)


if __name__ == "__main__":
    unittest.main()
