"""Two hundred job bodies malformed by hand, each with the status and the pointer it must get, and thousands generated
from good ones: always a 4xx problem document or an accepted job, never a 5xx, and the daemon lives.
"""

import copy
import http.client
import json
import os
import random
import unittest

from photond_daemon import DaemonTestCase, small_job

GENERATED = int(os.environ.get("PHOTOND_GENERATED_JOBS", "4000"))

BASE = small_job(size=16, passes=1)
PATHS = {"name": "path_tracing"}
ESTIMATED = "estimated_relative_mse"
EYE = {"eye": [0, 0, 2], "target": [0, 0, 0]}


def look(**changes):
    return {"look_at": {**EYE, **changes}}


def made(**changes):
    return {"method": PATHS, "stop": {"passes": 1}, **changes}


# Not JSON, or not one JSON text: 400, wherever it breaks.
TEXTS = [
    "", " ", "{", "}", "[", "nul", "'scene'", "{'scene': 1}", "{scene: 1}", '{"scene": }', '{"scene"}',
    '{"scene": "a",}',
    '{"scene": "a"} x', '{"scene": "a"}{"scene": "a"}', "[1,]", "01", "+1", ".5", "1.", "1e", "- 1", "0x10", "NaN",
    "Infinity", "-Infinity", '{"seed": NaN}', '{"seed": 1e999}', '{"seed": -1e999}', '"\t"', '"\\x41"', '"\\ud800"',
    '"\\u12"', "// comment\n{}", "/* c */ {}", "{\"a\": 1 \"b\": 2}", "\ufeff\ufeff{}", "\x00{}", '{"a": "\x01"}',
    "[" * 1000, "{\"a\":" * 1000, "[" * 33 + "]" * 33, "[" * 500_000, '{"a":' * 100_000,
    '{"scene": "a", "scene": "b"}', '{"image": {"width": 1, "width": 2}}', "[" + "1," * 150_000 + "1]",
    b'{"scene": "\xff"}', b'{"scene": "\xc3\x28"}', b"\xfe\xff\x00{\x00}", b"\x1f\x8b\x08\x00",
]

# (pointer at which the base is changed, value put there, pointer of the fault; None: the same place)
REMOVED = object()
FAULTS = [
    # what is required
    ("/scene", REMOVED, None), ("/image", REMOVED, None), ("/image/width", REMOVED, None),
    ("/image/height", REMOVED, None), ("/method", REMOVED, None), ("/method/name", REMOVED, None),
    ("/stop", REMOVED, None), ("/stop", {}, None), ("/scene", None, None), ("/image", None, None),
    ("/method", None, None), ("/stop", None, None), ("/image/width", None, None), ("/method/name", None, None),
    ("/stop", {"passes": None}, None), ("/stop", {"seconds": None, "passes": None}, None),
    # unknown fields, misspelt ones among them
    ("/scenes", "x", None), ("/Scene", "x", None), ("/", 1, None), ("/a~1b", 1, None), ("/a~0b", 1, None),
    ("/image/widht", 5, None), ("/image/depth", 5, None), ("/method/params", {}, None), ("/method/version", 1, None),
    ("/stop/pases", 1, None), ("/stop/minutes", 1, None), ("/camera", {"nmae": "a"}, "/camera/nmae"),
    ("/camera", {"fov": 1}, "/camera/fov"), ("/camera", look(roll=1), "/camera/look_at/roll"),
    ("/environment", {"image": "image:x", "colour": 1}, "/environment/colour"), ("/dry_run", True, None),
    ("/method/parameters", {"bounces_": 3}, "/method/parameters/bounces_"), ("/id", "J1", None),
    ("/method/parameters", {"": 3}, "/method/parameters/"), ("/é", 1, None),
    # wrong types
    ("/scene", 1, None), ("/scene", [], None), ("/scene", {}, None), ("/scene", True, None), ("/scene", 1.5, None),
    ("/image", [], None), ("/image", "64x64", None), ("/image", 64, None), ("/image/width", "64", None),
    ("/image/width", 1.5, None), ("/image/width", True, None), ("/image/width", [64], None),
    ("/image/height", {}, None), ("/image/height", "64", None), ("/image/filter", 1, None), ("/image/filter", [], None),
    ("/method", "path_tracing", None), ("/method", [], None), ("/method/name", 1, None), ("/method/name", {}, None),
    ("/method/device", 0, None), ("/method/device", [], None), ("/method/parameters", [], None),
    ("/method/parameters", "x", None), ("/method/parameters", 1, None), ("/stop", 1, None), ("/stop", "1 s", None),
    ("/stop", [], None), ("/stop/passes", "1", None), ("/stop/passes", 1.5, None), ("/stop/passes", True, None),
    ("/stop/passes", [], None), ("/stop/seconds", "1", None), ("/stop/seconds", True, None),
    ("/stop/seconds", {}, None), ("/seed", "1", None), ("/seed", True, None), ("/seed", [], None),
    ("/layers", "albedo", None), ("/layers", {}, None), ("/layers", 1, None), ("/layers", [1], "/layers/0"),
    ("/layers", ["albedo", None], "/layers/1"), ("/layers", [["albedo"]], "/layers/0"), ("/priority", "high", None),
    ("/priority", 0.5, None), ("/priority", [], None), ("/labels", [], None), ("/labels", "a", None),
    ("/labels", {"a": 1}, "/labels/a"), ("/labels", {"a": None}, "/labels/a"), ("/labels", {"a": {}}, "/labels/a"),
    ("/camera", "camera", None), ("/camera", [], None), ("/camera", {"name": 1}, "/camera/name"),
    ("/camera", {"look_at": []}, "/camera/look_at"), ("/camera", {"look_at": "x"}, "/camera/look_at"),
    ("/camera", look(eye=1), "/camera/look_at/eye"), ("/camera", look(eye={}), "/camera/look_at/eye"),
    ("/camera", look(eye=["a", 0, 0]), "/camera/look_at/eye/0"),
    ("/camera", look(target=[0, None, 0]), "/camera/look_at/target/1"), ("/camera", look(up="y"), "/camera/look_at/up"),
    ("/camera", look(yfov="wide"), "/camera/look_at/yfov"), ("/camera", {"aperture": "f/2"}, "/camera/aperture"),
    ("/camera", {"focus_distance": []}, "/camera/focus_distance"), ("/environment", "image:x", None),
    ("/environment", [], None), ("/environment", {"image": 5}, "/environment/image"),
    ("/environment", {"image": "image:x", "scale": "1"}, "/environment/scale"),
    ("/environment", {"image": "image:x", "rotation": "1"}, "/environment/rotation"), ("/glass", 1, None),
    ("/glass", True, None), ("/time", "0", None), ("/time", [], None), ("/animation", True, None), ("/animation", [0], None),
    ("/animation", {"name": "walk"}, None), ("/animation", 0.5, None),
    # out of range
    ("/scene", "", None), ("/scene", "x" * 300, None), ("/scene", "a\nb", None), ("/scene", "a\u0000b", None),
    ("/image/width", 0, None), ("/image/width", -1, None), ("/image/width", 1_000_000, None),
    ("/image/width", 2**32, None), ("/image/width", 2**63, None), ("/image/width", 2**64, None),
    ("/image/width", 10**40, None), ("/image/width", -(10**40), None), ("/image/width", 1e300, None),
    ("/image/height", 0, None), ("/image/height", -64, None), ("/image/height", 65537, None),
    ("/stop/passes", 0, None), ("/stop/passes", -1, None), ("/stop/passes", 2**32, None), ("/stop/passes", 1e12, None),
    ("/stop/seconds", 0, None), ("/stop/seconds", -1, None), ("/stop/seconds", 1e300, None),
    ("/stop/seconds", 1e-300, None), ("/seed", -1, None), ("/seed", 0.5, None), ("/seed", 2**64, None),
    ("/seed", 1e300, None), ("/priority", 101, None), ("/priority", -101, None), ("/priority", 1e300, None),
    ("/labels", {"": "x"}, "/labels/"), ("/labels", {"a=b": "x"}, "/labels/a=b"),
    ("/labels", {"k" * 65: "x"}, "/labels/" + "k" * 65), ("/labels", {"a": "x" * 257}, "/labels/a"),
    ("/labels", {f"k{i}": "x" for i in range(65)}, "/labels"),
    ("/camera", {"name": ""}, "/camera/name"), ("/camera", {"name": "x" * 300}, "/camera/name"),
    ("/camera", {"aperture": -0.1}, "/camera/aperture"), ("/camera", {"aperture": 1e300}, "/camera/aperture"),
    ("/camera", {"focus_distance": 0}, "/camera/focus_distance"),
    ("/camera", {"focus_distance": -1}, "/camera/focus_distance"),
    ("/camera", look(eye=[0, 0]), "/camera/look_at/eye"), ("/camera", look(eye=[0, 0, 1, 1]), "/camera/look_at/eye"),
    ("/camera", look(eye=[]), "/camera/look_at/eye"), ("/camera", look(eye=[1e300, 0, 0]), "/camera/look_at/eye/0"),
    ("/camera", look(yfov=0), "/camera/look_at/yfov"), ("/camera", look(yfov=-1), "/camera/look_at/yfov"),
    ("/camera", look(yfov=3.1416), "/camera/look_at/yfov"), ("/camera", look(yfov=45), "/camera/look_at/yfov"),
    ("/environment", {"image": "image:x", "scale": -1}, "/environment/scale"),
    ("/environment", {"image": "image:x", "scale": 1e300}, "/environment/scale"),
    ("/environment", {"image": "image:x", "rotation": 1e300}, "/environment/rotation"),
    # names that do not exist
    ("/scene", "no-such-scene", None), ("/scene", "../../etc/passwd", None), ("/method/name", "path_tracin", None),
    ("/method/name", "PATH_TRACING", None), ("/method/name", "", None), ("/image/filter", "lanczos", None),
    ("/image/filter", "Box", None), ("/image/filter", "", None), ("/method/device", "tpu", None),
    ("/method/device", "gpu:", None), ("/method/device", "gpu:-1", None), ("/method/device", "gpu:x", None),
    ("/method/device", "gpu:99999999999", None), ("/method/device", "cpu:0", None), ("/method/device", "", None),
    ("/layers", ["albdo"], "/layers/0"), ("/layers", ["albedo", "depht"], "/layers/1"), ("/layers", [""], "/layers/0"),
    ("/camera", {"name": "no-such-camera"}, "/camera/name"), ("/glass", "hollow", None), ("/glass", "", None),
    ("/environment", {"image": "sky.exr"}, "/environment/image"), ("/environment", {"image": "image:"},
                                                                  "/environment/image"),
    ("/environment", {"image": "image:no-such-image"}, "/environment/image"),
    ("/environment", {}, "/environment/image"),
    # fields that exclude each other
    ("/camera", {"name": "camera", **look()}, "/camera/look_at"),
    ("/camera", look(target=[0, 0, 2]), "/camera/look_at/target"),
    ("/camera", look(up=[0, 0, 0]), "/camera/look_at/up"),
    ("/camera", look(up=[0, 0, -3]), "/camera/look_at/up"), ("/camera", {"aperture": 0.1}, "/camera/focus_distance"),
    ("/layers", ["depth", "depth"], "/layers/1"), ("/camera", {"look_at": {}}, "/camera/look_at/eye"),
    ("/method", {"name": "photon_mapping", "parameters": {"radius": 1, "radius_relative": 0.1}},
     "/method/parameters/radius_relative"),
    # what another method has
    ("/layers", ["photon_count"], "/layers/0"), ("/layers", ["depth", "photon_count"], "/layers/1"),
    ("/method/parameters", {"photons": 1000}, "/method/parameters/photons"),
    ("/method", {"name": "photon_mapping", "parameters": {"roulette_start": 3}}, "/method/parameters/roulette_start"),
    ("/method", {"name": "photon_mapping", "parameters": {"cone_k": 0.5}}, "/method/parameters/cone_k"),
    ("/method", {"name": "photon_mapping", "parameters": {"nearest_photons": 1}}, "/method/parameters/nearest_photons"),
    # not on this device
    ("/method/device", "gpu", None), ("/method/device", "gpu:0", None), ("/time", 1e300, None), ("/animation", -1, None),
    ("/shutter", -0.1, None), ("/shutter", "1/48", None), ("/animation", 65536, None), ("/animation", "x" * 300, None),
    # references, targets, metrics, parts
    ("/reference", "J1", None), ("/reference", "job:", None), ("/reference", "image:", None), ("/reference", "", None),
    ("/reference", "job:J999999999", None), ("/reference", "job:x", None), ("/reference", "image:none", None),
    ("/reference", 1, None), ("/reference", [], None), ("/reference", True, None),
    ("/reference", {}, "/reference/method"), ("/reference", {"method": PATHS}, "/reference/stop"),
    ("/reference", {"stop": {"passes": 1}}, "/reference/method"), ("/reference", made(seed=2), "/reference/seed"),
    ("/reference", made(method={"name": "x"}), "/reference/method/name"),
    ("/reference", made(method={**PATHS, "device": "gpu:0"}), "/reference/method/device"),
    ("/reference", made(method={**PATHS, "parameters": {"x": 1}}), "/reference/method/parameters/x"),
    ("/reference", made(stop={"passes": 0}), "/reference/stop/passes"),
    ("/reference", made(stop={}), "/reference/stop"),
    ("/reference", made(stop={"target": {"metric": "rmse", "value": 1}}), "/reference/stop/target/metric"),
    ("/stop/target", {"metric": "relative_mse", "value": 0.1}, "/stop/target/metric"), ("/stop/target", 1, None),
    ("/stop/target", {"metric": ESTIMATED}, "/stop/target/value"),
    ("/stop/target", {"value": 1}, "/stop/target/metric"),
    ("/stop/target", {"metric": ESTIMATED, "value": -1}, "/stop/target/value"),
    ("/stop/target", {"metric": ESTIMATED, "value": "1"}, "/stop/target/value"),
    ("/stop/target", {"metric": "estimated_relative_mes", "value": 1}, "/stop/target/metric"),
    ("/stop/target", {"metric": "direct:" + ESTIMATED, "value": 1}, "/stop/target/metric"),
    ("/stop/target", {"metric": ESTIMATED, "value": 1, "layer": "direct"}, "/stop/target/layer"),
    ("/metrics", ["rmse"], None), ("/metrics", "rmse", None), ("/metrics", ["rsme"], "/metrics/0"),
    ("/metrics", [1], "/metrics/0"), ("/metrics", ["rmse", "rmse"], "/metrics/1"),
    ("/metrics", ["albedo:rmse"], "/metrics/0"), ("/metrics", ["caustic:rmse"], "/metrics/0"),
    ("/metrics", ["percentiles"], "/metrics/0"), ("/first_pass", -1, None), ("/first_pass", 0.5, None),
    ("/first_pass", "0", None), ("/first_pass", 2**32, None),
]

# Bodies that are well-formed JSON and no object: the fault is the whole.
WHOLES = ["null", "true", "1", "-1.5", '"x"', "[]", "[{}]"]


def changed(pointer, value):
    body = copy.deepcopy(BASE)
    *parents, last = [part.replace("~1", "/").replace("~0", "~") for part in pointer[1:].split("/")]
    target = body
    for part in parents:
        target = target[part]
    if value is REMOVED:
        del target[last]
    else:
        target[last] = value
    return body


class Poster:
    """Many posts over one connection."""

    def __init__(self, daemon):
        self.connection = http.client.HTTPConnection(daemon.address, daemon.port)

    def post(self, body):
        if isinstance(body, str):
            body = body.encode("utf-8", "surrogatepass")
        self.connection.request("POST", "/v1/jobs", body=body, headers={"Content-Type": "application/json"})
        response = self.connection.getresponse()
        return response.status, response.getheader("Content-Type"), response.read()


class MalformedJobsTest(DaemonTestCase):
    def setUp(self):
        self.poster = Poster(self.daemon)
        self.addCleanup(self.poster.connection.close)

    def tearDown(self):
        self.assertTrue(self.daemon.running())
        self.assertEqual(self.daemon.request("GET", "/readyz").status, 200)

    def assert_refused(self, answer, status):
        self.assertEqual(answer[0], status, answer)
        self.assertEqual(answer[1], "application/problem+json")
        problem = json.loads(answer[2])
        self.assertEqual(problem["status"], status)
        self.assertTrue(problem["detail"])
        return problem

    def test_there_are_two_hundred(self):
        self.assertGreaterEqual(len(TEXTS) + len(FAULTS) + len(WHOLES), 200)

    def test_the_base_is_good(self):
        self.assertEqual(self.poster.post(json.dumps(BASE))[0], 202)

    def test_texts_that_are_not_json(self):
        for text in TEXTS:
            with self.subTest(text=text[:60]):
                problem = self.assert_refused(self.poster.post(text), 400)
                self.assertEqual(problem["code"], "bad_json")
                self.assertRegex(problem["detail"], r"line \d+, column \d+")

    def test_each_fault_is_named_at_its_place(self):
        for at, value, pointer in FAULTS:
            with self.subTest(at=at, value="removed" if value is REMOVED else repr(value)[:60]):
                problem = self.assert_refused(self.poster.post(json.dumps(changed(at, value))), 422)
                self.assertIn(pointer or at, [error["pointer"] for error in problem["errors"]], problem)

    def test_wholes_that_are_no_object(self):
        for text in WHOLES:
            with self.subTest(text=text):
                problem = self.assert_refused(self.poster.post(text), 422)
                self.assertEqual([error["pointer"] for error in problem["errors"]], [""])

    def test_each_fault_has_its_code(self):
        body = {**BASE, "color": "red", "method": {"name": "path_tracing", "parameters": {"indirect_bounces": "two"}},
                "image": {"width": 16, "height": 100_000}}
        del body["stop"]
        problem = self.assert_refused(self.poster.post(json.dumps(body)), 422)
        self.assertEqual({error["pointer"]: error["code"] for error in problem["errors"]},
                         {"/color": "unknown_field", "/method/parameters/indirect_bounces": "wrong_type",
                          "/image/height": "out_of_range", "/stop": "missing_field"})

    def test_several_faults_are_named_together(self):
        body = changed("/image", {"width": 0, "hight": 3})
        body["layers"] = ["albdo"]
        body["sed"] = 1
        problem = self.assert_refused(self.poster.post(json.dumps(body)), 422)
        self.assertEqual({error["pointer"] for error in problem["errors"]},
                         {"/image/width", "/image/height", "/image/hight", "/layers/0", "/sed"})
        for pointer, nearest in (("/image/hight", "height"), ("/layers/0", "albedo"), ("/sed", "seed")):
            detail = next(error["detail"] for error in problem["errors"] if error["pointer"] == pointer)
            self.assertIn(f'did you mean "{nearest}"', detail)

    def test_generated_bodies_never_cause_a_5xx(self):
        source = random.Random(20240607)
        seen = {}
        for number in range(GENERATED):
            body = mutated_text(source) if number % 2 else mutated_value(source)
            status, media_type, answer = self.poster.post(body)
            seen[status] = seen.get(status, 0) + 1
            if status == 202:  # a mutation may be harmless; it must not render for long
                self.daemon.request("DELETE", f"/v1/jobs/{json.loads(answer)['id']}?purge=true")
                continue
            if status not in (400, 422):
                self.fail(f"number {number}: {status} {answer[:500]} for {body[:500]!r}")
            self.assertEqual(media_type, "application/problem+json")
        self.assertGreater(seen.get(400, 0), GENERATED // 10)
        self.assertGreater(seen.get(422, 0), GENERATED // 10)


RICH = {**BASE, "camera": look(up=[0, 1, 0], yfov=0.7), "seed": 7, "layers": ["albedo", "depth"], "priority": 3,
        "labels": {"a": "b"}, "glass": "solid", "time": 0, "reference": made(), "metrics": ["rmse", "direct:mae"],
        "first_pass": 0, "stop": {"passes": 1, "seconds": None, "target": {"metric": "rmse", "value": 0.5}}}
STRANGE = [None, True, False, 0, -1, 1, 0.5, 1e300, -1e300, 5e-324, 2**31, 2**32, 2**53 + 1, 2**63, 2**64, 10**30, "",
           "x", "\u0000", "é" * 10, "a" * 1000, [], {}, [[]], [{}], {"a": {}}, [None] * 5, {"": ""}, "gpu", "cpu",
           "NaN"]


def places(value, found, path=()):
    found.append(path)
    if isinstance(value, dict):
        for key in value:
            places(value[key], found, path + (key,))
    elif isinstance(value, list):
        for i in range(len(value)):
            places(value[i], found, path + (i,))
    return found


def mutated_value(source):
    body = copy.deepcopy(RICH)
    for _ in range(source.randint(1, 4)):
        path = source.choice(places(body, [])[1:] or [()])
        if not path:
            break
        target = body
        for part in path[:-1]:
            target = target[part]
        kind = source.random()
        if kind < 0.6:
            target[path[-1]] = copy.deepcopy(source.choice(STRANGE))
        elif kind < 0.8:
            del target[path[-1]]
        elif isinstance(target, dict):
            target[source.choice(["", "x", "width", "name", "passes", "~/", path[-1] + "s"])] = source.choice(STRANGE)
        else:
            target.append(source.choice(STRANGE))
    return json.dumps(body)


def mutated_text(source):
    text = bytearray(json.dumps(RICH).encode())
    for _ in range(source.randint(1, 6)):
        at = source.randrange(len(text))
        kind = source.random()
        if kind < 0.4:
            text[at] = source.choice(b'{}[]":,0123456789.eE+-tfn\\u\x00\xff ') if kind < 0.3 else source.randrange(256)
        elif kind < 0.6:
            del text[at:at + source.randint(1, 20)]
        elif kind < 0.8:
            text[at:at] = text[source.randrange(len(text)):][:source.randint(1, 40)]
        else:
            text[at:at] = source.choice([b"[" * 50, b'"a":1,', b"1e400", b"\xed\xa0\x80", b"\xef\xbb\xbf", b"null,"])
        if not text:
            text = bytearray(b" ")
    return bytes(text)


if __name__ == "__main__":
    unittest.main()
