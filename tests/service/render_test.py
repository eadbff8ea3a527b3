"""One request, one image; and requests that wait for a job, of which any number holds no thread."""

import http.client
import json
import pathlib
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import tiny_scene  # noqa: E402
from photond_daemon import LONGEST_WAIT_S, DaemonTestCase, small_job  # noqa: E402

ENDLESS = 100_000_000  # passes: over long after the test
PNG, EXR = b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01"


def exr_attributes(image):
    """The texts among the header's attributes, read without an image library."""
    attributes, at = {}, 8  # magic and version
    while image[at]:
        name, kind = image[at:at + 300].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size = int.from_bytes(image[at:at + 4], "little")
        if kind == b"string":
            attributes[name.decode()] = image[at + 4:at + 4 + size].decode()
        at += 4 + size
    return attributes


class RenderTest(DaemonTestCase):
    def tearDown(self):
        for state in ("queued", "running"):
            for job in self.daemon.request("GET", f"/v1/jobs?state={state}").json["items"]:
                self.daemon.request("DELETE", f"/v1/jobs/{job['id']}")
                self.daemon.wait_for_job(job["id"])

    def render(self, accept=None, query="", job=None):
        return self.daemon.request("POST", "/v1/render" + query, json_body=job or small_job(size=16),
                                   headers={"Accept": accept} if accept else {})

    def unanswered(self, method, path, body=None):
        """A request that was sent, whose answer is still to come."""
        connection = http.client.HTTPConnection(self.daemon.address, self.daemon.port)
        connection.request(method, path, body=None if body is None else json.dumps(body),
                           headers={} if body is None else {"Content-Type": "application/json"})
        return connection

    def newest_job(self):
        """Its id; none before the first."""
        jobs = self.daemon.request("GET", "/v1/jobs?limit=1").json["items"]
        return jobs[0]["id"] if jobs else None

    def unanswered_render(self, query=""):
        """A request for an image that is never done, and its job."""
        before = self.newest_job()
        connection = self.unanswered("POST", "/v1/render" + query, small_job(size=16, passes=ENDLESS))
        self.daemon.wait_until(lambda: self.newest_job() != before, "a job has come")
        return connection, self.newest_job()

    def endless(self):
        return self.daemon.submit(small_job(size=16, passes=ENDLESS))["id"]

    def test_answers_with_the_image_as_it_is_asked_for(self):
        image = self.render()
        self.assertEqual((image.status, image.headers["content-type"], image.body[:8]), (200, "image/png", PNG))
        path = image.headers["location"]
        self.assertEqual(image.body, self.daemon.request("GET", path + "/preview.png").body)
        image = self.render("image/x-exr")
        self.assertEqual((image.status, image.headers["content-type"], image.body[:4]), (200, "image/x-exr", EXR))
        self.assertEqual(image.body, self.daemon.request("GET", image.headers["location"] + "/image.exr").body)
        job = self.render("application/json")
        self.assertEqual((job.status, job.json["state"]), (200, "succeeded"))
        self.assertEqual(job.headers["location"], "/v1/jobs/" + job.json["id"])
        before = self.newest_job()
        refused = self.render("text/html")
        self.assertEqual((refused.status, refused.json["code"]), (406, "not_acceptable"))
        self.assertEqual(self.newest_job(), before, "nothing is queued for who cannot take it")

    def form(self, path, files, fields):
        content_type, body = tiny_scene.form(files, fields)
        return self.daemon.request("POST", path, body=body, headers={"Content-Type": content_type})

    def test_brings_its_scene_along(self):
        whole = small_job(size=16)
        job = json.dumps({key: value for key, value in whole.items() if key != "scene"})
        files = {"a.glb": tiny_scene.glb()}
        image = self.form("/v1/render", files, {"job": job})
        self.assertEqual((image.status, image.body[:8]), (200, PNG), image)
        scene = self.daemon.request("GET", image.headers["location"]).json["request"]["scene"]
        refused = self.form("/v1/render", files, {"job": json.dumps(whole)})
        self.assertEqual((refused.status, refused.json["errors"][0]["pointer"]), (422, "/scene"), refused)
        refused = self.form("/v1/render", {}, {"jib": "{}"})
        self.assertEqual((refused.status, refused.json["code"]), (422, "unknown_field"))
        # A form of one file may bring a scene alone, too.
        added = self.form("/v1/scenes", files, {})
        self.assertEqual((added.status, added.json["id"]), (200, scene))

    def test_says_what_is_wrong_instead_of_an_image(self):
        bad = self.render(job=small_job(scene="no-such-scene"))
        self.assertEqual((bad.status, bad.json["errors"][0]["pointer"]), (422, "/scene"))
        for wait in ("-1", "601", "x"):
            self.assertEqual(self.render(query="?wait=" + wait).status, 422, wait)
        connection, job = self.unanswered_render()
        self.daemon.request("DELETE", "/v1/jobs/" + job)
        answer = connection.getresponse()
        self.assertEqual((answer.status, json.loads(answer.read())["code"]), (409, "cancelled"))
        connection.close()

    def test_tells_of_the_job_when_the_time_is_over(self):
        late = self.render(query="?wait=0.2", job=small_job(size=16, passes=ENDLESS))
        self.assertEqual((late.status, late.headers["location"]), (202, "/v1/jobs/" + late.json["id"]))
        self.assertIn(late.json["state"], ("queued", "running"))
        path = late.headers["location"]
        self.assertEqual(self.daemon.request("GET", path + "?wait=0.1").json["state"], "running")
        unready = self.daemon.request("GET", path + "/image.exr?wait=0.1")
        self.assertEqual((unready.status, unready.json["code"]), (503, "unavailable"), "curl -f fails")
        more = self.daemon.request("POST", "/v1/jobs?wait=0.1", json_body=small_job(size=16, passes=ENDLESS))
        self.assertEqual(more.status, 202)

    def test_waits_until_a_job_is_over(self):
        done = self.daemon.request("POST", f"/v1/jobs?wait={LONGEST_WAIT_S}", json_body=small_job(size=16))
        self.assertEqual((done.status, done.json["state"]), (200, "succeeded"))
        again = self.daemon.request("GET", f"/v1/jobs/{done.json['id']}/image.exr?wait={LONGEST_WAIT_S}")
        self.assertEqual((again.status, again.body[:4]), (200, EXR))
        begun = self.endless()
        waiting = [self.unanswered("GET", f"/v1/jobs/{begun}{path}?wait={LONGEST_WAIT_S}") for path in ("", "/image.exr", "/log.txt")]
        self.daemon.wait_for_job(begun, states=("running",))
        self.daemon.request("DELETE", f"/v1/jobs/{begun}")
        job, image, log = (connection.getresponse() for connection in waiting)
        self.assertEqual(json.loads(job.read())["state"], "cancelled")
        self.assertIn(image.status, (200, 404))  # of a pass that was done, or none
        self.assertIn(b"cancelled", log.read())
        for connection in waiting:
            connection.close()

    def test_any_number_waits_and_others_are_answered(self):
        begun = self.endless()
        waiting = [self.unanswered("GET", f"/v1/jobs/{begun}?wait={LONGEST_WAIT_S}") for _ in range(200)]
        asked = time.monotonic()
        self.assertEqual(self.daemon.request("GET", "/v1/status").status, 200)
        print(f"an answer beside 200 that wait: {1e3 * (time.monotonic() - asked):.1f} ms")
        self.daemon.request("DELETE", f"/v1/jobs/{begun}")
        for connection in waiting:
            self.assertEqual(json.loads(connection.getresponse().read())["state"], "cancelled")
            connection.close()

    def test_a_client_that_leaves_takes_its_job_along_if_it_said_so(self):
        for query, state in ((f"?wait={LONGEST_WAIT_S}", "running"), (f"?wait={LONGEST_WAIT_S}&cancel_on_disconnect=true", "cancelled")):
            connection, job = self.unanswered_render(query)
            self.daemon.wait_for_job(job, states=("running",))
            connection.close()
            if state == "cancelled":
                self.daemon.wait_for_job(job, states=("cancelled",))
            else:
                self.daemon.request("GET", "/v1/jobs")  # whatever follows from that has followed
                self.assertEqual(self.daemon.job(job)["state"], "running")
                self.daemon.request("DELETE", "/v1/jobs/" + job)
                self.daemon.wait_for_job(job)

    def test_an_exr_says_how_to_make_it_again(self):
        asked = small_job(scene="interior", size=16, passes=2, seed=7,
                          method="photon_mapping")
        asked["method"]["parameters"] = {"photons": 2000}
        image = self.render("image/x-exr", job=asked)
        job = self.daemon.request("GET", image.headers["location"]).json
        attributes = exr_attributes(image.body)
        request = json.loads(attributes["photond:request"])
        self.assertEqual(request, job["request"])
        self.assertEqual(attributes["photond:scene"],
                         self.daemon.request("GET", f"/v1/scenes/{asked['scene']}").json["id"])
        again = self.daemon.run_job(request)
        self.assertEqual(again["statistics"]["pixel_hash"], job["statistics"]["pixel_hash"])

    def test_who_only_looks_takes_no_job_along(self):
        begun = self.endless()
        for path in ("", "/image.exr"):
            refused = self.daemon.request("GET", f"/v1/jobs/{begun}{path}?wait=0&cancel_on_disconnect=true")
            self.assertEqual((refused.status, refused.json["code"]), (422, "unknown_field"), path)

    def test_the_same_key_gives_the_same_image(self):
        headers = {"Idempotency-Key": "once"}
        first, second = (self.daemon.request("POST", "/v1/render", json_body=small_job(size=16), headers=headers)
                         for _ in range(2))
        self.assertEqual((first.status, second.status), (200, 200))
        self.assertEqual((first.headers["location"], first.body), (second.headers["location"], second.body))

    def test_a_daemon_that_ends_lets_them_go(self):
        with type(self.daemon)() as other:
            job = other.submit(small_job(size=16, passes=ENDLESS))["id"]
            other.wait_for_job(job, states=("running",))
            connection = http.client.HTTPConnection(other.address, other.port)
            connection.request("GET", f"/v1/jobs/{job}?wait={LONGEST_WAIT_S}")
            other.stop()
            try:
                self.assertIn(json.loads(connection.getresponse().read())["state"], ("running", "queued"))
            except (http.client.HTTPException, ConnectionError):
                pass  # it was faster than the answer
            connection.close()


if __name__ == "__main__":
    unittest.main()
