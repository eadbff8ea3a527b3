"""Looking after the data folder: photond --check and --repair while no daemon runs, photonctl backup while one does and
jobs run, restore into an empty folder.
"""

import hashlib
import os
import pathlib
import shutil
import stat
import subprocess
import tempfile
import time
import unittest

import tiny_scene
from photond_daemon import BIN, Daemon, small_job

OK, FAULTS, FAILED = 0, 2, 1
LONGER = {"size": 64, "passes": 600}
HDR = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + bytes([128, 128, 128, 129]) * 2
PHOTONS = {**small_job(size=16), "method": {"name": "photon_mapping", "parameters": {
    "photons": 1000, "gather": "direct", "keep_photon_map": True}}}


def hash_of(job):
    return job["statistics"]["pixel_hash"]


class DataCase(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="photond-test-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.daemon = self.start(self.folder / "data")
        self.data = self.folder / "data"

    def start(self, data, *options):
        daemon = Daemon("--save-seconds", 0.05, "--threads", 1, *options, data_dir=data)
        self.addCleanup(daemon.close)
        daemon.wait_ready()
        return daemon

    def upload(self):
        """A scene and an image; their ids."""
        scene = self.daemon.request("POST", "/v1/scenes", body=tiny_scene.glb(7),
                                    headers={"Content-Type": "model/gltf-binary"})
        image = self.daemon.request("POST", "/v1/images", body=HDR, headers={"Content-Type": "image/vnd.radiance"})
        self.assertEqual((scene.status, image.status), (201, 201))
        return scene.json["id"], image.json["id"]

    def photond(self, *arguments, status):
        ended = subprocess.run([BIN / "photond", *arguments], capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, status, ended)
        return ended

    def check(self, *lines, data=None):
        """Runs --check, which must name exactly that, in any order, and change nothing."""
        data = data or self.data
        before = self.contents(data)
        ended = self.photond("--check", "--data", data, status=FAULTS if lines else OK)
        self.assertEqual(self.contents(data), before, "--check has changed something")
        said = ended.stdout.splitlines()
        self.assertEqual(len(said), len(lines), said)
        for line in lines:
            self.assertTrue([one for one in said if one.startswith(line)], (line, said))

    @staticmethod
    def contents(data):
        return {str(path.relative_to(data)): hashlib.sha256(path.read_bytes()).hexdigest()
                for path in data.rglob("*") if path.is_file()}

    def photonctl(self, *arguments, daemon=None, status=0):
        daemon = daemon or self.daemon
        ended = subprocess.run([BIN / "photonctl", *map(str, arguments)], capture_output=True, text=True,
                               check=False,
                               env={**os.environ, "PHOTOND_URL": f"http://127.0.0.1:{daemon.port}"})
        self.assertEqual(ended.returncode, status, ended)
        return ended


class CheckTest(DataCase):
    def test_a_folder_that_is_whole(self):
        self.daemon.run_job(PHOTONS)
        self.upload()
        refused = self.photond("--check", "--data", self.data, status=FAILED)
        self.assertIn("another photond uses", refused.stderr)
        self.daemon.kill()  # its log is not in the database's file yet, which the check does not change
        self.check()
        self.photond("--check", "--data", self.folder / "none", status=FAILED)
        self.assertFalse((self.folder / "none").exists())
        self.assertEqual(self.photond("--repair", "--data", self.data, status=OK).stdout, "")
        self.check()

    def test_all_that_can_be_wrong_is_named_and_set_right(self):
        jobs = [self.daemon.run_job({**PHOTONS, "seed": seed}) for seed in range(1, 5)]
        ids = [job["id"] for job in jobs]
        scene, image = self.upload()
        running = self.daemon.submit(small_job(size=64, passes=100_000_000))
        waiting = self.daemon.submit(small_job(scene=scene))
        film = self.data / "films" / f"{running['id']}-1.film"
        self.daemon.wait_until(film.exists, "a film is saved", job=running["id"])
        self.daemon.kill()
        films = self.data / "films"
        (films / f"{ids[0]}-1.film").unlink()
        content = bytearray((films / f"{ids[1]}-1.film").read_bytes())
        content[-50] ^= 1
        (films / f"{ids[1]}-1.film").write_bytes(content)
        (films / f"{ids[2]}-1.film.photon_map.glb").unlink()
        (self.data / "scenes" / scene / "scene.glb").write_bytes(b"something else")
        next((self.data / "images").iterdir()).unlink()
        (films / "J77-1.film").write_bytes(b"whose is it")
        wrong = [f"job {ids[0]}: films/{ids[0]}-1.film is missing",
                 f"job {ids[1]}: films/{ids[1]}-1.film cannot be read: the film file {ids[1]}-1.film is damaged",
                 f"job {ids[2]}: films/{ids[2]}-1.film.photon_map.glb is missing",
                 f"scene {scene}: scenes/{scene} is damaged", f"image {image}: images/{image}.hdr is missing",
                 "films/J77-1.film is named by no row"]
        said = self.photond("--check", "--data", self.data, status=FAULTS).stdout.splitlines()
        unknown = [line for line in said if line.startswith(f"job {running['id']}: films/")]  # where it was killed so
        self.check(*wrong, *unknown)
        done = self.photond("--repair", "--data", self.data, status=OK).stdout
        for words in (f"job {ids[0]}: films/{ids[0]}-1.film is missing: the job failed, as result_lost",
                      f"scene {scene}: scenes/{scene} is damaged: it is not what was uploaded: it is removed",
                      "1 jobs that waited failed", "films/J77-1.film: moved to quarantine"):
            self.assertIn(words, done)
        self.check()
        self.daemon.start()
        self.daemon.wait_ready()
        for job_id in ids[:2] + [waiting["id"]]:
            job = self.daemon.job(job_id)
            self.assertEqual((job["state"], job["failure"]["code"]), ("failed", "result_lost"))
        self.assertIn("repair: films/", self.daemon.request("GET", f"/v1/jobs/{ids[0]}/log.txt").text)
        self.assertIsNone(self.daemon.job(ids[2])["links"]["photon_map"])
        self.assertEqual(self.daemon.job(ids[3]), jobs[3])
        kept = {path.name: path.read_bytes() for path in (self.data / "quarantine").rglob("*") if path.is_file()}
        self.assertEqual(kept, {f"{ids[1]}-1.film": bytes(content), "scene.glb": b"something else",
                                "J77-1.film": b"whose is it"})
        # What was lost can be had again.
        self.assertEqual(self.upload(), (scene, image))
        self.daemon.request("DELETE", f"/v1/jobs/{running['id']}")
        self.assertEqual(self.daemon.request("POST", f"/v1/jobs/{ids[0]}/retry").status, 202)
        self.assertEqual(hash_of(self.daemon.wait_for_job(ids[0])), hash_of(jobs[0]))

    def test_a_damaged_store(self):
        self.daemon.run_job(small_job())
        self.daemon.stop()
        with open(self.data / "store.sqlite", "r+b") as file:
            file.seek(4096)
            file.write(b"\xff" * 8192)
        said = self.photond("--check", "--data", self.data, status=FAULTS).stdout
        self.assertTrue(said.startswith("store.sqlite"), said)
        refused = self.photond("--repair", "--data", self.data, status=FAILED)
        self.assertIn("damaged", refused.stderr)


class BackupTest(DataCase):
    def test_while_a_job_runs(self):
        finished = [self.daemon.run_job({**PHOTONS, "seed": seed}) for seed in (1, 2)]
        scene, image = self.upload()
        finished.append(self.daemon.run_job(small_job(scene=scene, size=16)))
        expected = hash_of(self.daemon.run_job(small_job(**LONGER)))
        running = self.daemon.submit(small_job(**LONGER))
        waiting = self.daemon.submit(small_job(scene=scene, size=16, seed=4))
        self.daemon.wait_for_kept_film(running["id"])
        backup = self.folder / "backup"
        said = self.photonctl("backup", backup)
        self.assertIn("files", said.stdout)
        self.assertEqual(self.daemon.job(running["id"])["state"], "running", "too fast to be met: make it longer")
        self.assertEqual(list((self.data / "spool").iterdir()), [], "nothing is left of it here")
        self.assertEqual({path for path in [backup, *backup.rglob("*")] if stat.S_IMODE(path.stat().st_mode) & 0o077},
                         set())
        images = {job["id"]: self.daemon.request("GET", f"/v1/jobs/{job['id']}/image.exr").body for job in finished}
        maps = {job["id"]: self.daemon.request("GET", job["links"]["photon_map"]).body for job in finished[:2]}
        # What happens afterwards is not in it.
        self.daemon.request("DELETE", f"/v1/jobs/{finished[0]['id']}?purge=true")
        later = self.daemon.submit(small_job(seed=9))
        self.daemon.close()

        restored = self.folder / "restored"
        self.photonctl("restore", backup, restored)
        self.check(data=restored)
        other = self.start(restored)
        for job in finished:
            self.assertEqual(other.job(job["id"]), job)
            self.assertEqual(other.request("GET", f"/v1/jobs/{job['id']}/image.exr").body, images[job["id"]])
        for job_id, photon_map in maps.items():
            self.assertEqual(other.request("GET", f"/v1/jobs/{job_id}/photon_map.glb").body, photon_map)
        self.assertEqual(other.request("GET", f"/v1/images/{image}/file").body, HDR)
        went_on = other.wait_for_job(running["id"])
        self.assertEqual((went_on["state"], hash_of(went_on)), ("succeeded", expected))
        self.assertGreater(went_on["statistics"]["resumed_passes"], 0)
        self.assertEqual(other.wait_for_job(waiting["id"])["state"], "succeeded")
        self.assertEqual(other.request("GET", f"/v1/jobs/{later['id']}").status, 404)
        self.assertFalse((restored / "quarantine").exists())

    def test_what_is_refused(self):
        self.daemon.run_job(small_job())
        backup = self.folder / "backup"
        backup.mkdir()
        (backup / "notes").write_text("mine")
        self.assertIn("not empty", self.photonctl("backup", backup, status=7).stderr)
        self.photonctl("restore", backup, self.folder / "restored", status=7)
        (backup / "notes").unlink()
        self.photonctl("backup", backup)
        self.assertIn("not empty", self.photonctl("restore", backup, self.data, status=7).stderr)
        (backup / "films" / "J1-1.film").unlink()
        self.assertIn("J1-1.film is missing",
                      self.photonctl("restore", backup, self.folder / "restored", status=7).stderr)
        self.assertFalse((self.folder / "restored").exists())
        made = self.daemon.request("POST", "/v1/backups")
        self.assertEqual(made.status, 201, made)
        files = f"{made.headers['location']}/file?path="
        for path in ("../store.sqlite", "/etc/passwd", "films", "", "films/../store.sqlite", "photond.lock"):
            self.assertEqual(self.daemon.request("GET", files + path).status, 404, path)
        self.assertEqual(self.daemon.request("GET", files + "films/J1-1.film").status, 200)
        # A purged job's film is in the backup as long as that is there; a later backup takes its place.
        self.assertEqual(self.daemon.request("DELETE", "/v1/jobs/J1?purge=true").status, 200)
        self.assertEqual(self.daemon.request("GET", files + "films/J1-1.film").body[:8], b"PHOTFILM")
        time.sleep(0.002)  # ids are of the moment
        later = self.daemon.request("POST", "/v1/backups").json
        self.assertEqual([file["path"] for file in later["files"]], ["store.sqlite"])
        gone = self.daemon.request("GET", files + "films/J1-1.film")
        self.assertEqual(gone.status, 404)
        self.assertIn("a later one took its place", gone.json["detail"])

    def test_it_needs_a_token_that_may_write(self):
        tokens = self.folder / "tokens"
        lines, secrets = [], {}
        for role in ("read", "write"):
            told = self.photond("--new-token", f"{role}er:{role}", status=OK).stdout.splitlines()
            secrets[role] = told[0].split()[1]
            lines.append(told[1].split(None, 1)[1])
        tokens.write_text("\n".join(lines) + "\n")
        tokens.chmod(0o600)
        with Daemon("--tokens", tokens) as daemon:
            def ask(method, path, role):
                return daemon.request(method, path, headers={"Authorization": "Bearer " + secrets[role]})
            self.assertEqual(ask("POST", "/v1/backups", "read").status, 403)
            made = ask("POST", "/v1/backups", "write")
            self.assertEqual(made.status, 201, made)
            for path in (made.headers["location"], made.headers["location"] + "/file?path=store.sqlite"):
                self.assertEqual((ask("GET", path, "read").status, ask("GET", path, "write").status), (403, 200))


del DataCase  # a base, not a test case
if __name__ == "__main__":
    unittest.main()
