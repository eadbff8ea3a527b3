"""What a start makes of the data folder as it finds it: nothing that was rendered or uploaded is ever deleted, whatever
became of the store or of the daemon meanwhile.
"""

import os
import pathlib
import signal
import socket
import sqlite3
import stat
import subprocess
import time
import unittest

import tiny_scene
from film_versions import as_version, passes_of
from photond_daemon import BIN, Daemon, small_job, wait_until

ENDLESS = 100_000_000  # passes: over long after the test
LONGER = {"size": 64, "passes": 400}  # most of a second, in which SAVES saves often
SAVES = ("--save-seconds", 0.05)


def hash_of(job):
    return job["statistics"]["pixel_hash"]


class StoreCase(unittest.TestCase):
    def start(self, *options):
        daemon = Daemon("--threads", 1, *options)  # its endless jobs take what they get
        self.addCleanup(daemon.close)
        self.addCleanup(self.let_go_on)  # first, for a halted one does not end
        daemon.wait_ready()
        self.daemon = daemon
        self.films = daemon.data_dir / "films"
        return daemon

    def let_go_on(self):
        if self.daemon.running():
            os.kill(self.daemon.process.pid, signal.SIGCONT)

    def store(self):
        return self.daemon.request("GET", "/v1/status").json["store"]

    def quarantined(self):
        """{path below its folder DATE-REASON: bytes} of what lies in quarantine."""
        root = self.daemon.data_dir / "quarantine"
        return {str(pathlib.Path(*file.relative_to(root).parts[1:])): file.read_bytes()
                for file in root.rglob("*") if file.is_file()}


class LostStoreTest(StoreCase):
    def filled(self):
        """A daemon that has a film, a scene and an image, stopped; what lies there."""
        self.start()
        self.daemon.run_job(small_job())
        self.daemon.add_scene(self.scene_file())
        hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + bytes([128, 128, 128, 129]) * 2
        reply = self.daemon.request("POST", "/v1/images", body=hdr, headers={"Content-Type": "image/vnd.radiance"})
        self.assertEqual(reply.status, 201, reply)
        self.id = self.store()["id"]
        self.assertEqual(self.daemon.stop(), 0)
        files = [file for folder in ("films", "scenes", "images")
                 for file in (self.daemon.data_dir / folder).rglob("*") if file.is_file()]
        self.assertEqual(len(files), 3)
        return {str(file.relative_to(self.daemon.data_dir)): file.read_bytes() for file in files}

    def scene_file(self):
        path = pathlib.Path(self.daemon.log_path).with_suffix(".glb")
        path.write_bytes(tiny_scene.glb(7))
        self.addCleanup(path.unlink)
        return path

    def check_all_in_quarantine(self, before):
        (self.daemon.data_dir / "spool" / "u1").write_bytes(b"an upload that the lost store's daemon had under way")
        self.daemon.start()
        self.daemon.wait_ready()
        kept = self.quarantined()
        self.assertEqual(kept.pop("spool/u1", None), b"an upload that the lost store's daemon had under way")
        self.assertEqual(kept, before)
        told = self.store()
        self.assertEqual(told["quarantine"]["files"], len(before) + 1)
        self.assertEqual(told["quarantine"]["bytes"], sum(map(len, before.values())) + 52)
        for path in before:
            name = "/".join(path.split("/")[:2])
            self.assertEqual(self.daemon.log().count(f"quarantine: {name} "), 1, "the log says each once")
        # It goes on with a store of its own, and nothing of the old one is taken for its own or touched again.
        self.assertNotEqual(told["id"], self.id)
        job = self.daemon.run_job(small_job(seed=2))
        self.daemon.kill()
        self.daemon.start()
        self.assertEqual(self.daemon.job(job["id"])["state"], "succeeded")
        self.assertEqual([film.name for film in self.films.iterdir()], [job["id"] + "-1.film"])
        self.assertEqual({path: data for path, data in self.quarantined().items() if path != "spool/u1"}, before)
        self.assertEqual(self.store()["quarantine"], told["quarantine"])

    def test_a_missing_store(self):
        before = self.filled()
        (self.daemon.data_dir / "store.sqlite").unlink()
        self.check_all_in_quarantine(before)

    def test_a_store_of_no_bytes(self):
        before = self.filled()
        os.truncate(self.daemon.data_dir / "store.sqlite", 0)
        self.check_all_in_quarantine(before)

    def test_rows_that_are_gone(self):
        before = self.filled()
        store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
        for table in ("jobs", "scenes", "images"):
            store.execute(f"DELETE FROM {table}")
        store.commit()
        store.close()
        self.daemon.start()
        self.daemon.wait_ready()
        self.assertEqual(self.quarantined(), before)
        self.assertEqual((self.store()["id"], self.store()["quarantine"]["files"]), (self.id, len(before)))


class StrayFilesTest(StoreCase):
    def test_only_its_own_temporary_files_are_swept(self):
        self.start()
        done = self.daemon.run_job(small_job())
        self.daemon.kill()
        film = (self.films / f"{done['id']}-1.film").read_bytes()
        data = self.daemon.data_dir
        own = [data / "spool" / "u7.exr", data / "cache" / "a9", self.films / f"{done['id']}-1.film.part",
               self.films / f"{done['id']}-1.film.s3", self.films / f"{done['id']}-1.film.photon_map.glb.part"]
        strange = {"spool/notes.txt": b"mine", "cache/keep": b"mine too", "films/J99-1.film": film,
                   f"films/{done['id']}-2.film": film, "films/half": b"PHOTFILM", "images/x.exr": b"no image",
                   "scenes/folder/a/b.glb": b"no scene"}
        for path in own:
            path.write_bytes(b"left by a killed process")
        for path, content in strange.items():
            (data / path).parent.mkdir(parents=True, exist_ok=True)
            (data / path).write_bytes(content)
        self.daemon.start()
        self.daemon.wait_ready()
        self.assertEqual(self.quarantined(), strange)
        self.assertEqual([path for path in own if path.exists()], [])
        self.assertEqual(self.store()["quarantine"], {"files": len(strange), "bytes": sum(map(len, strange.values()))})
        self.assertEqual(self.daemon.job(done["id"]), done)

    def test_files_whose_removal_was_under_way_are_removed(self):
        """As a daemon leaves them that is killed between the row and the file."""
        self.start()
        film = (self.films / f"{self.daemon.run_job(small_job())['id']}-1.film").read_bytes()
        self.daemon.stop()
        for name in ("J50-1.film", "J50-1.film.photon_map.glb"):
            (self.films / name).write_bytes(film)
        store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
        store.execute("INSERT INTO unnamed_files VALUES ('films/J50-1.film')")
        store.commit()
        store.close()
        self.daemon.start()
        self.assertEqual([path.name for path in self.films.iterdir()], ["J1-1.film"])
        self.assertEqual(self.quarantined(), {})

    def test_a_deleted_and_uploaded_again_scene_stays(self):
        self.start()
        path = self.daemon.data_dir / "spool" / "scene"
        path.write_bytes(tiny_scene.glb(3))
        scene = self.daemon.add_scene(path)
        path.unlink()
        self.assertEqual(self.daemon.request("DELETE", f"/v1/scenes/{scene['id']}").status, 200)
        reply = self.daemon.request("POST", "/v1/scenes", body=tiny_scene.glb(3),
                                    headers={"Content-Type": "model/gltf-binary"})
        self.assertEqual(reply.status, 201)
        self.daemon.kill()
        self.daemon.start()
        self.daemon.wait_ready()
        self.daemon.run_job(small_job(scene=scene["id"], size=8))

    def test_a_film_without_an_origin_is_its_rows(self):
        """Films of older versions say nothing of their store: a row that names them says it."""
        self.start()
        job = self.daemon.run_job(small_job())
        path = self.films / f"{job['id']}-1.film"
        content = as_version(path.read_bytes(), 4)
        self.daemon.kill()
        path.write_bytes(content)
        self.daemon.start()
        self.daemon.wait_ready()
        self.assertEqual(self.quarantined(), {})
        extended = self.daemon.request("POST", f"/v1/jobs/{job['id']}/extend", json_body={"stop": {"passes": 2}})
        self.assertEqual(extended.status, 202)
        self.assertEqual(self.daemon.wait_for_job(job["id"])["statistics"]["resumed_passes"], 1)


class SavedFilmTest(StoreCase):
    """A film that is complete on the disk is the job's, whoever is killed before the daemon has heard of it."""

    def stop_hearing(self):
        """The daemon stops; what its workers do meanwhile it has not heard of when it is killed."""
        os.kill(self.daemon.process.pid, signal.SIGSTOP)

    def film_saved_unheard(self, job):
        """Halts the daemon and waits until its worker has saved a film after that; its passes."""
        self.daemon.wait_for_passes(job["id"])
        self.stop_hearing()
        film = self.films / f"{job['id']}-1.film"
        known = film.stat().st_mtime_ns if film.exists() else 0
        wait_until(lambda: film.exists() and film.stat().st_mtime_ns != known, "a film is saved", self.daemon)
        return film

    def test_a_killed_daemon_has_not_heard_of_it(self):
        self.start(*SAVES)
        expected = hash_of(self.daemon.run_job(small_job(**LONGER)))
        for round_ in range(2):
            with self.subTest(round=round_):
                job = self.daemon.submit(small_job(**LONGER))
                film = self.film_saved_unheard(job)
                self.daemon.kill()
                passes = passes_of(film.read_bytes())
                self.daemon.start()
                found = self.daemon.job(job["id"])
                self.assertGreaterEqual(found["passes_done"], passes)
                self.assertIn(f"{passes} passes, was saved before the daemon ended",
                              self.daemon.request("GET", job["links"]["log"]).text)
                job = self.daemon.wait_for_job(job["id"])
                self.assertEqual((job["state"], hash_of(job)), ("succeeded", expected))
                self.assertGreaterEqual(job["statistics"]["resumed_passes"], passes)
        self.assertEqual(self.quarantined(), {})

    def test_the_last_film_of_a_job_and_its_artefacts(self):
        """Nothing is left to be rendered: the photon map of the attempt that rendered it all is the job's."""
        body = {**small_job(size=16, passes=3), "method": {"name": "photon_mapping", "parameters": {
            "photons": 1000, "gather": "direct", "keep_photon_map": True}}}
        self.start()
        expected = self.daemon.run_job(body)
        photon_map = self.daemon.request("GET", expected["links"]["photon_map"]).body
        blocker = self.daemon.submit(small_job(size=64, passes=ENDLESS))
        job = self.daemon.submit({**body, "priority": 50})
        self.daemon.request("DELETE", f"/v1/jobs/{blocker['id']}")
        film = self.films / f"{job['id']}-1.film"
        while not film.exists():
            pass
        self.daemon.kill()
        self.daemon.start()
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual((job["state"], hash_of(job)), ("succeeded", hash_of(expected)))
        self.assertEqual(self.daemon.request("GET", job["links"]["photon_map"]).body, photon_map)

    def test_a_killed_worker_has_not_told_it(self):
        self.start(*SAVES)
        expected = hash_of(self.daemon.run_job(small_job(**LONGER)))
        worker = self.daemon.workers()["cpu"]
        job = self.daemon.submit(small_job(**LONGER))
        film = self.film_saved_unheard(job)
        os.kill(worker, signal.SIGKILL)
        passes = passes_of(film.read_bytes())
        os.kill(self.daemon.process.pid, signal.SIGCONT)
        job = self.daemon.wait_for_job(job["id"])
        self.assertEqual([a["outcome"] for a in job["attempts"]], ["lost", "succeeded"])
        self.assertEqual(hash_of(job), expected)
        self.assertGreaterEqual(job["statistics"]["resumed_passes"], passes)

    def test_a_film_with_another_fence_or_damage_is_not_taken(self):
        self.start(*SAVES)
        expected = hash_of(self.daemon.run_job(small_job(**LONGER)))
        for fault in ("origin", "damage"):
            with self.subTest(fault=fault):
                job = self.daemon.submit(small_job(**LONGER))
                film = self.film_saved_unheard(job)
                self.daemon.kill()
                store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
                store.execute("UPDATE jobs SET film = '', passes_done = 0 WHERE seq = ?", (int(job["id"][1:]),))
                store.commit()
                store.close()
                content = bytearray(film.read_bytes())
                if fault == "damage":
                    content[-100] ^= 1
                else:  # of another job, put in this one's place
                    content = bytearray((self.films / "J1-1.film").read_bytes())
                film.write_bytes(content)
                self.daemon.start()
                job = self.daemon.wait_for_job(job["id"])
                self.assertEqual((job["state"], hash_of(job)), ("succeeded", expected))
                self.assertEqual(job["statistics"]["resumed_passes"], 0)
                self.assertEqual(self.quarantined().get(f"films/{film.name}"), bytes(content))


class FolderTest(StoreCase):
    def test_nobody_else_may_read_it(self):
        self.start()
        self.daemon.run_job(small_job())
        data = self.daemon.data_dir
        self.assertEqual(self.daemon.request("POST", "/v1/scenes", body=tiny_scene.glb(5),
                                             headers={"Content-Type": "model/gltf-binary"}).status, 201)
        modes = {path: stat.S_IMODE(path.lstat().st_mode) for path in [data, *data.rglob("*")] if not path.is_symlink()}
        self.assertEqual({path for path, mode in modes.items() if mode & 0o077}, set())
        # Folders of older versions are closed too.
        self.daemon.stop()
        for path, mode in ((data, 0o755), (data / "films", 0o755), (data / "store.sqlite", 0o644)):
            path.chmod(mode)
        self.daemon.start()
        for path, mode in ((data, 0o700), (data / "films", 0o700), (data / "store.sqlite", 0o600)):
            self.assertEqual(stat.S_IMODE(path.stat().st_mode), mode, path)

    def test_a_busy_port_is_found_before_anything_is_touched(self):
        self.start(*SAVES)
        job = self.daemon.submit(small_job(size=64, passes=ENDLESS))
        self.daemon.wait_until(lambda: list(self.films.glob("*.film")), "a film is saved", job=job["id"])
        self.daemon.kill()
        (self.films / "half").write_bytes(b"a stray")
        (self.daemon.data_dir / "spool" / "u1").write_bytes(b"an upload under way")

        def lying_there():
            return {str(path): path.read_bytes() for path in self.daemon.data_dir.rglob("*") if path.is_file()}
        before = lying_there()
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            address = f"127.0.0.1:{taken.getsockname()[1]}"
            for folder in (self.daemon.data_dir, self.daemon.data_dir / "not-there-yet"):
                ended = subprocess.run([BIN / "photond", "--data", folder, "--listen", address], capture_output=True,
                                       check=False)
                self.assertEqual(ended.returncode, 1)
                self.assertIn(b"Address already in use", ended.stderr)
        self.assertEqual(lying_there(), before)
        self.assertFalse((self.daemon.data_dir / "not-there-yet").exists())
        self.daemon.start()
        self.assertEqual(self.daemon.job(job["id"])["attempts"][0]["outcome"], "lost")


class WholeCheckTest(StoreCase):
    """SQLite is checked whole beside the serving, above the 64 MB that a start waits for too."""

    PADDING = 80 << 20

    def pad(self):
        """Makes the store larger than what is checked before it is served; the page of some of that."""
        self.daemon.stop()
        store = sqlite3.connect(self.daemon.data_dir / "store.sqlite")
        store.execute("CREATE TABLE padding (x)")
        store.execute("INSERT INTO padding VALUES (zeroblob(?))", (self.PADDING,))
        store.execute("CREATE TABLE other (x)")
        store.executemany("INSERT INTO other VALUES (?)", [(i,) for i in range(10_000)])
        store.execute("CREATE INDEX other_by_x ON other (x)")
        store.commit()
        (page,) = store.execute("SELECT rootpage FROM sqlite_schema WHERE name = 'other_by_x'").fetchone()
        (size,) = store.execute("PRAGMA page_size").fetchone()
        store.close()
        return (page - 1) * size

    def checked(self):
        self.daemon.wait_until(lambda: self.store()["check"]["state"] not in ("waiting", "running"), "the check ends")
        return self.store()["check"]

    def test_it_is_told_in_the_status(self):
        self.start()
        self.assertEqual(self.checked(), {"state": "ok", "detail": None})
        at = self.pad()
        self.daemon.start()
        self.daemon.wait_ready()
        begun = time.monotonic()
        job = self.daemon.run_job(small_job())
        self.assertEqual(self.checked(), {"state": "ok", "detail": None})
        print(f"{self.store()['bytes'] >> 20} MiB of store checked within {time.monotonic() - begun:.2f} s")
        self.assertGreater(self.store()["bytes"], self.PADDING)
        # What was written meanwhile is in the store, and it is still served and written when it is damaged elsewhere.
        self.daemon.stop()
        with open(self.daemon.data_dir / "store.sqlite", "r+b") as file:
            file.seek(at)
            file.write(b"\xff" * 64)
        self.daemon.start()
        self.daemon.wait_ready()
        found = self.checked()
        self.assertEqual(found["state"], "damaged", found)
        self.assertTrue(found["detail"])
        self.assertIn("the store is damaged", self.daemon.log())
        self.assertEqual(self.daemon.job(job["id"])["state"], "succeeded")
        self.daemon.run_job(small_job(seed=3))


del StoreCase  # a base, not a test case
if __name__ == "__main__":
    unittest.main()
