"""Data folders of older versions are brought up to date, whatever is killed meanwhile, and what was rendered then stays:
it is read, gone on with, and says what it does not know.
"""

import hashlib
import json
import shutil
import subprocess
import time
import unittest

import tiny_scene
from film_versions import NEWEST, as_version, passes_of, version_of
from older_store import make_older, migrations, rows_of
from older_store import version_of as version_of_store
from photond_daemon import BIN, Daemon, small_job

STORE_VERSION = 8  # before references of two films
FILM_VERSION = 5   # before films kept the means of their passes
KILLS = 12
# Members that results of that time did not have.
AS_THEN = ("UPDATE jobs SET statistics = json_remove(statistics, '$.error_interval', '$.reference.form', "
           "'$.reference.confidence', '$.reference.denominators') WHERE statistics <> ''",
           "UPDATE jobs SET error_now = json_remove(error_now, '$.interval') WHERE error_now <> ''",
           "UPDATE jobs SET curve = (SELECT json_group_array(json_remove(value, '$.intervals')) FROM json_each(curve)) "
           "WHERE curve <> ''")


KEYED_JOB = small_job(size=8, seed=77)
KEYED_COMPARISON = {"scene": "cornell-box", "image": {"width": 16, "height": 16}, "stop": {"passes": 4}, "seeds": [1, 2],
                    "reference": {"method": {"name": "path_tracing"}, "stop": {"passes": 16}},
                    "entries": [{"label": "a", "method": {"name": "path_tracing"}}]}


SINCE_THEN = ("animation", "shutter", "temporal", "history_cap")  # members of requests and of methods' parameters


def of_then(part):
    if isinstance(part, dict):
        return {name: of_then(value) for name, value in part.items() if name not in SINCE_THEN}
    return [of_then(inner) for inner in part] if isinstance(part, list) else part


def hash_of_then(request):
    """What that time noted of a request beside its Idempotency-Key."""
    return hashlib.sha256(json.dumps(of_then(request), sort_keys=True, separators=(",", ":")).encode()).hexdigest()


class OlderVersionsTest(unittest.TestCase):
    """One folder that a daemon filled, made what one of before would have left."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = daemon = Daemon("--threads", 1)
        daemon.wait_ready()
        cls.data = daemon.data_dir
        cls.store = cls.data / "store.sqlite"
        scene = daemon.request("POST", "/v1/scenes", body=tiny_scene.glb(3), headers={"Content-Type": "model/gltf-binary"})
        assert scene.status == 201, scene
        cls.judge = daemon.run_job(small_job(passes=64, seed=9))
        cls.longer = daemon.run_job(small_job(passes=5, reference=f"job:{cls.judge['id']}", metrics=["indirect:rmse"]))
        cls.measured = daemon.run_job(small_job(passes=3, reference=f"job:{cls.judge['id']}", metrics=["indirect:rmse"]))
        cls.other_scene = daemon.run_job(small_job(scene=scene.json["id"], size=8, labels={"study": "old"}))
        cls.keyed = daemon.wait_for_job(daemon.submit(KEYED_JOB, idempotency_key="of then")["id"])
        compared = daemon.request("POST", "/v1/comparisons", json_body=KEYED_COMPARISON,
                                  headers={"Idempotency-Key": "of then"})
        assert compared.status == 202, compared
        cls.comparison = f"/v1/comparisons/{compared.json['id']}"
        daemon.wait_for_state(cls.comparison, ("succeeded",))
        assert daemon.stop() == 0
        make_older(cls.store, STORE_VERSION, AS_THEN + tuple(
            f"UPDATE {table} SET body_sha256 = '{hash_of_then(request)}'"
            for table, request in (("keys", cls.keyed["request"]), ("comparison_keys", compared.json["request"]))))
        for film in (cls.data / "films").glob("*.film"):
            film.write_bytes(as_version(film.read_bytes(), FILM_VERSION))
        cls.rows = rows_of(cls.store, STORE_VERSION)
        cls.kept = cls.data.with_name(cls.data.name + ".kept")
        cls.data.rename(cls.kept)
        cls.addClassCleanup(shutil.rmtree, cls.kept)

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def setUp(self):
        self.restore()
        self.addCleanup(self.daemon.kill)

    def restore(self):
        shutil.rmtree(self.data, ignore_errors=True)
        shutil.copytree(self.kept, self.data, symlinks=True)

    def check_nothing_is_lost(self):
        """After a daemon, started on it, has stopped."""
        self.assertEqual(version_of_store(self.store), len(migrations()))
        rows, changing = rows_of(self.store, STORE_VERSION), ("events", "meta")  # a start may number events anew
        self.assertEqual({table: rows[table] for table in rows if table not in changing},
                         {table: self.rows[table] for table in rows if table not in changing})
        self.assertFalse((self.data / "quarantine").exists() and any((self.data / "quarantine").iterdir()))

    def test_a_start_that_is_killed_at_any_time(self):
        """The unit test StoreMigration has every moment of the migration itself; this is the program's start whole."""
        begun = time.monotonic()
        self.daemon.start()
        self.daemon.wait_ready()
        whole = time.monotonic() - begun
        self.assertEqual(self.daemon.stop(), 0)
        self.check_nothing_is_lost()
        versions = []
        for kill in range(KILLS):
            self.restore()
            started = subprocess.Popen([BIN / "photond", "--data", self.data, "--listen", "127.0.0.1:0"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(whole * (kill / KILLS) ** 2)  # more of them early, where the store is brought up to date
            started.kill()
            started.wait()
            kept = self.data.parent / (self.data.name + ".killed")
            kept.mkdir()
            try:  # a copy, since looking at a store carries on what its log has
                for file in self.data.glob("store.sqlite*"):
                    shutil.copy(file, kept)
                versions.append(version_of_store(kept / "store.sqlite"))
                self.assertEqual(rows_of(kept / "store.sqlite", STORE_VERSION)["jobs"], self.rows["jobs"])
            finally:
                shutil.rmtree(kept)
        print("the store's version when the start was killed:", versions)
        self.assertIn(STORE_VERSION, versions, "no kill came before the store was brought up to date")
        self.daemon.start()
        self.daemon.wait_ready()
        self.assertEqual(self.daemon.job(self.other_scene["id"])["request"]["labels"], {"study": "old"})
        self.assertEqual(self.daemon.stop(), 0)
        self.check_nothing_is_lost()

    def test_a_key_of_then_gives_what_it_gave(self):
        self.daemon.start()
        self.daemon.wait_ready()
        key = {"Idempotency-Key": "of then"}
        again = self.daemon.request("POST", "/v1/jobs", json_body=KEYED_JOB, headers=key)
        self.assertEqual((again.status, again.json.get("id")), (202, self.keyed["id"]), again)
        again = self.daemon.request("POST", "/v1/comparisons", json_body=KEYED_COMPARISON, headers=key)
        self.assertEqual((again.status, again.json.get("links", {}).get("self")), (202, self.comparison), again)

    def test_results_stay_readable(self):
        self.daemon.start()
        self.daemon.wait_ready()
        for before in (self.judge, self.measured, self.other_scene):
            job = self.daemon.job(before["id"])
            self.assertEqual(job["statistics"]["pixel_hash"], before["statistics"]["pixel_hash"])
            self.assertEqual(job["reference_job"], before["reference_job"])
            self.assertEqual(self.daemon.request("GET", job["links"]["image"]).status, 200)
        self.assertEqual(self.daemon.job(self.measured["id"])["statistics"]["error"],
                         self.measured["statistics"]["error"])
        for path in ("", "/report.csv", "/report.json", "/report.html"):
            self.assertEqual(self.daemon.request("GET", self.comparison + path).status, 200, path)
        self.assertEqual(self.daemon.request("GET", self.comparison).json["state"], "succeeded")

    def test_a_film_is_gone_on_with_and_says_what_it_does_not_know(self):
        path = self.data / "films" / f"{self.measured['id']}-1.film"
        self.assertEqual((version_of(path.read_bytes()), passes_of(path.read_bytes())), (FILM_VERSION, 3))
        self.daemon.start()
        self.daemon.wait_ready()
        extended = self.daemon.request("POST", f"/v1/jobs/{self.measured['id']}/extend", json_body={"stop": {"passes": 5}})
        self.assertEqual(extended.status, 202, extended)
        statistics = self.daemon.wait_for_job(self.measured["id"])["statistics"]
        self.assertEqual(statistics["resumed_passes"], 3)
        self.assertEqual(statistics["pixel_hash"], self.longer["statistics"]["pixel_hash"])
        error, expected = statistics["error"], dict(self.longer["statistics"]["error"])
        for name in ("bias_standard_error", "indirect:bias_standard_error"):
            self.assertEqual(len(expected[name]), 3)
            expected[name] = None
        for values in (error, expected):
            del values["estimated_relative_mse"]  # by what the job saw on the way
        self.assertEqual(error, expected)
        self.assertIn("bias_standard_error: unknown, for 3 of the 5 passes are from a film that an older version saved, "
                      "without their means", statistics["reference"]["notes"])
        (film,) = (self.data / "films").glob(f"{self.measured['id']}-*.film")
        self.assertEqual((version_of(film.read_bytes()), passes_of(film.read_bytes())), (NEWEST, 5))

# Of parameters that are new or had other defaults: what was done before, as MethodInfo::settings_before has it.
BEFORE = {"photon_mapping": {"boundary": "none"}, "photon_splatting": {"bounces": 1},
          "svo_many_lights": {"bounces": 1, "caustic_photons": 0}}


class OlderDefaultsTest(unittest.TestCase):
    """Jobs and comparisons that were kept without parameters which are new, or whose defaults have changed since."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = daemon = Daemon("--threads", 1)
        daemon.wait_ready()
        cls.jobs, cls.longer, removed = {}, {}, []
        for method, parameters in BEFORE.items():
            of_method = {"name": method, "parameters": {"photons" if "photon" in method else "vpls": 300, **parameters}}
            job = {**small_job(scene="cornell-box-glass", size=16, passes=2), "method": of_method}
            cls.jobs[method] = daemon.run_job(job)
            cls.longer[method] = daemon.run_job({**job, "stop": {"passes": 3}})
            removed += [f"'{place}.method.parameters.{name}'" for place in ("$", "$.reference") for name in parameters]
        compared = daemon.request("POST", "/v1/comparisons", json_body={
            "scene": "cornell-box", "image": {"width": 8, "height": 8}, "stop": {"passes": 1},
            "reference": {"method": {"name": "photon_mapping", "parameters": {"photons": 300, "boundary": "none"}},
                          "stop": {"passes": 2}},
            "entries": [{"label": "a", "method": {"name": "photon_splatting", "parameters": {"photons": 50, "bounces": 1}}}]})
        assert compared.status == 202, compared
        cls.comparison = f"/v1/comparisons/{compared.json['id']}"
        daemon.wait_for_state(cls.comparison, ("succeeded",))
        cls.references = daemon.request("GET", cls.comparison).json["reference"]["jobs"]
        assert daemon.stop() == 0
        removed = ", ".join(removed)
        make_older(daemon.data_dir / "store.sqlite", len(migrations()), [
            f"UPDATE jobs SET request = json_remove(request, {removed}), "
            "content = CASE content WHEN '' THEN '' ELSE 'one of two films: as it was called' || seq END",
            "UPDATE comparisons SET request = json_remove(request, '$.reference.method.parameters.boundary', "
            "'$.entries[0].method.parameters.bounces')",
            "DELETE FROM meta WHERE key = 'requests_are_of'"])
        daemon.start()
        daemon.wait_ready()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def parameters_of(self, job):
        return {name: job["request"]["method"]["parameters"][name] for name in BEFORE[job["request"]["method"]["name"]]}

    def test_a_repeat_does_what_was_done(self):
        for method, before in self.jobs.items():
            self.assertEqual(self.daemon.job(before["id"])["request"], before["request"])
            answer = self.daemon.request("POST", f"/v1/jobs/{before['id']}/repeat")
            self.assertEqual(answer.status, 202, answer)
            repeat = self.daemon.wait_for_job(answer.json["id"])
            self.assertEqual(self.parameters_of(repeat), BEFORE[method])
            self.assertEqual(repeat["statistics"]["pixel_hash"], before["statistics"]["pixel_hash"])

    def test_an_extended_job_goes_on_with_what_it_was_made_with(self):
        for method, before in self.jobs.items():
            answer = self.daemon.request("POST", f"/v1/jobs/{before['id']}/extend", json_body={"stop": {"passes": 3}})
            self.assertEqual(answer.status, 202, answer)
            job = self.daemon.wait_for_job(before["id"])
            self.assertEqual(self.parameters_of(job), BEFORE[method])
            self.assertEqual(job["statistics"]["resumed_passes"], 2)
            self.assertEqual(job["statistics"]["pixel_hash"], self.longer[method]["statistics"]["pixel_hash"])

    def test_a_comparison_asked_for_again_finds_its_reference_and_its_defaults(self):
        compared = self.daemon.request("GET", self.comparison).json
        self.assertEqual(compared["request"]["reference"]["method"]["parameters"]["boundary"], "none")
        self.assertEqual(compared["request"]["entries"][0]["method"]["parameters"]["bounces"], 1)
        again = self.daemon.request("POST", "/v1/comparisons", json_body=compared["request"])
        self.assertEqual(again.status, 202, again)
        self.assertEqual(self.daemon.request("GET", f"/v1/comparisons/{again.json['id']}").json["reference"]["jobs"],
                         self.references)


if __name__ == "__main__":
    unittest.main()
