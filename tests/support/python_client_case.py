"""The Python client against a daemon of its own.

    setUpModule, tearDownModule = fixture.start, fixture.stop
    class Something(Case):
        def test_it(self):
            self.client.render("furnace", **SMALL)
"""

import os
import pathlib
import shutil
import sys
import tempfile
import unittest

import tiny_scene
from photond_daemon import Daemon

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = SOURCE / "clients" / "python"
sys.path.insert(0, str(PACKAGE))

import photond  # noqa: E402  from the checkout, as PYTHONPATH=clients/python would have it

SMALL = {"width": 24, "height": 16, "passes": 2}


class Fixture:
    """The daemon, a client of it, and a folder to write into."""

    def start(self):
        for name in ("PHOTOND_URL", "PHOTOND_TOKEN"):
            os.environ.pop(name, None)
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="photond-python-test-"))
        self.daemon = Daemon("--threads", 1)  # its endless jobs take what they get
        self.daemon.wait_ready()
        self.client = photond.Client(url_of(self.daemon))

    def stop(self):
        self.client.close()
        self.daemon.close()
        shutil.rmtree(self.folder, ignore_errors=True)


fixture = Fixture()


def url_of(daemon):
    return f"http://127.0.0.1:{daemon.port}"


def gltf_folder(folder, seed=0, name="data of it"):
    """A .gltf with its buffer beside it; the .gltf's path. The buffer's URI is percent-encoded."""
    for path, content in tiny_scene.gltf_files(seed, name).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content.replace(name.encode(), name.replace(" ", "%20").encode()))
    return folder / "scene.gltf"


class Case(unittest.TestCase):
    @property
    def client(self):
        return fixture.client

    @property
    def daemon(self):
        return fixture.daemon

    @property
    def folder(self):
        return fixture.folder

    def long_job(self, client=None, **more):
        """One that ends when the test does."""
        job = (client or self.client).submit("cornell-box", width=32, height=32, seconds=600, **more)
        self.addCleanup(self.daemon.request, "DELETE", f"/v1/jobs/{job.id}?purge=true")
        return job


__all__ = ["PACKAGE", "SMALL", "SOURCE", "Case", "fixture", "photond", "gltf_folder", "url_of"]
