"""Starts photond for a test, talks to it as a client would, and stops it.

    with Daemon() as daemon:
        reply = daemon.request("POST", "/v1/jobs", json_body={...})
        assert reply.status == 202, reply.text
        job = daemon.wait_for_job(reply.json["id"])

The programs are taken from the folder PHOTOND_BIN (default: build/bin of this checkout). Every daemon listens on
127.0.0.1 with a port of its own and keeps its data in a temporary folder, removed at the end unless `data_dir` was given
or the environment names PHOTOND_KEEP_DATA.
"""

import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest

BIN = pathlib.Path(os.environ.get("PHOTOND_BIN", pathlib.Path(__file__).resolve().parents[2] / "build" / "bin"))
LISTENING = re.compile(r"^photond listening on http://(\S+):(\d+)\s*$")
OVER = ("succeeded", "failed", "cancelled")
# How many times as long as usual programs take: those under a sanitizer are slow.
PATIENCE = float(os.environ.get("PHOTOND_TEST_PATIENCE", "1"))
# Nothing is given up sooner than that. CI's machine may be several times slower than the one that a test was written on,
# and nobody but who waits in vain notices how long it is.
LEAST_PATIENCE_S = 400
UNDER_SANITIZER = "PHOTOND_UNDER_SANITIZER" in os.environ

# The daemon is not dumpable, so that its files in /proc are root's.
needs_root = unittest.skipUnless(os.geteuid() == 0, "only root sees into the daemon's process")


def patience(seconds=LEAST_PATIENCE_S):
    """How long is waited for what is expected within so many seconds."""
    return PATIENCE * max(seconds, LEAST_PATIENCE_S)


def deadline_after(seconds=LEAST_PATIENCE_S):
    """Of time.monotonic()."""
    return time.monotonic() + patience(seconds)


def wait_until(condition, what, timeout_s=LEAST_PATIENCE_S):
    """What `condition` gives once that is true; raises with the words of `what` when it does not come to that."""
    deadline = deadline_after(timeout_s)
    while not (value := condition()):
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.01)
    return value


def processor_ticks(pid):
    """What a process has computed, in the kernel's ticks."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return int(fields[11]) + int(fields[12])


def wait_until_at_rest(pids, what, timeout_s=LEAST_PATIENCE_S):
    """Until those processes, `pids()`, are the same for two seconds and compute nothing meanwhile."""
    deadline = deadline_after(timeout_s)
    looks = [None]
    while len(looks) < 5 or any(look != looks[-1] for look in looks[-5:]):
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.5)
        looks.append(sorted((pid, processor_ticks(pid)) for pid in pids()))


class Reply:
    """status (int), headers (dict, lower-case names), body (bytes); text and json are read from the body."""

    def __init__(self, status, headers, body):
        self.status = status
        self.headers = headers
        self.body = body

    @property
    def text(self):
        return self.body.decode("utf-8", "replace")

    @property
    def json(self):
        return json.loads(self.body)

    def __repr__(self):
        return f"<Reply {self.status} {self.text[:500]!r}>"


class Daemon:
    """A running photond. `extra` are further command-line arguments, `environment` variables beside this process',
    `open_files` the file descriptors that the system grants it, `address_space` the bytes that it grants each process.
    """

    def __init__(self, *extra, data_dir=None, start=True, start_timeout_s=LEAST_PATIENCE_S, environment=None, open_files=None,
                 address_space=None):
        self.extra = [str(argument) for argument in extra]
        if PATIENCE > 1:
            for option, seconds in (("--helper-timeout", 120), ("--heartbeat-timeout", 30)):
                if option not in self.extra:
                    self.extra += [option, str(PATIENCE * seconds)]
        if "--repeats" not in self.extra:  # how busy the machine is decides nothing but where a test is about that
            self.extra += ["--repeats", "0"]
        self.own_data = data_dir is None
        self.data_dir = pathlib.Path(data_dir or tempfile.mkdtemp(prefix="photond-test-"))
        self.start_timeout_s = start_timeout_s
        self.environment = environment or {}
        self.granted = [f"--{name}={value}" for name, value in (("nofile", open_files), ("as", address_space)) if value]
        self.process = None
        self.address = self.port = None
        self.log_path = self.data_dir.parent / (self.data_dir.name + ".log")
        if start:
            self.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # --- life ---------------------------------------------------------------------------------------------------------
    def start(self):
        """Starts it and waits for its line; raises with the log when it does not come."""
        command = [str(BIN / "photond"), "--data", str(self.data_dir), "--listen", "127.0.0.1:0", *self.extra]
        if self.granted:
            command = ["prlimit", *self.granted, *command]
        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, stdin=subprocess.DEVNULL,
                                            env={**os.environ, **self.environment})
        lines = []
        reader = threading.Thread(target=lambda: lines.append(self.process.stdout.readline()), daemon=True)
        reader.start()
        reader.join(patience(self.start_timeout_s))
        match = LISTENING.match(lines[0].decode()) if lines else None
        if not match:
            self.kill()
            raise RuntimeError(f"photond did not start: {' '.join(command)}\nstdout: {lines}\n{self.log()[-4000:]}")
        self.address, self.port = match.group(1), int(match.group(2))

    def wait_ready(self, timeout_s=LEAST_PATIENCE_S):
        """Until /readyz answers 200; returns the seconds it took."""
        begun = time.monotonic()
        while True:
            reply = self.request("GET", "/readyz")
            if reply.status == 200:
                return time.monotonic() - begun
            if time.monotonic() - begun > patience(timeout_s):
                raise TimeoutError(f"not ready after {timeout_s} s: {reply!r}\n{self.log()[-4000:]}")
            time.sleep(0.02)

    def running(self):
        return self.process is not None and self.process.poll() is None

    def stop(self, timeout_s=LEAST_PATIENCE_S):
        """SIGTERM and wait; returns the exit status."""
        if self.process is None:
            return None
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait(patience(timeout_s))
        except subprocess.TimeoutExpired:
            self.kill()
            raise
        finally:
            self.process.stdout.close()

    def kill(self):
        """SIGKILL: as a power cut for the process."""
        if self.process is not None:
            if self.process.poll() is None:
                self.process.kill()
            self.process.wait()
            self.process.stdout.close()

    def close(self):
        try:
            if self.running():
                self.stop()
        finally:
            self.kill()
            if self.own_data and not os.environ.get("PHOTOND_KEEP_DATA"):
                shutil.rmtree(self.data_dir, ignore_errors=True)
                self.log_path.unlink(missing_ok=True)

    def log(self):
        """What it wrote to standard error."""
        return self.log_path.read_text(errors="replace") if self.log_path.exists() else ""

    def children(self):
        """Process ids of its workers and helper, from /proc."""
        ids = []
        for task in pathlib.Path(f"/proc/{self.process.pid}/task").glob("*/children"):
            ids += [int(word) for word in task.read_text().split()]
        return ids

    def workers(self):
        """{device: pid} of the render workers, from /v1/status."""
        status = self.request("GET", "/v1/status").json
        return {worker["device"]: worker["pid"] for worker in status["workers"] if worker["device"] != "none"}

    # --- talking ------------------------------------------------------------------------------------------------------
    def request(self, method, path, body=None, headers=None, json_body=None, timeout_s=LEAST_PATIENCE_S):
        """One request over its own connection."""
        headers = dict(headers or {})
        if json_body is not None:
            body = json.dumps(json_body).encode()
            headers.setdefault("Content-Type", "application/json")
        connection = http.client.HTTPConnection(self.address, self.port, timeout=PATIENCE * timeout_s)
        try:
            connection.request(method, path, body=body, headers=headers)
            response = connection.getresponse()
            return Reply(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
        finally:
            connection.close()

    def submit(self, job, idempotency_key=None):
        """Posts a job and returns its object; raises when it is not accepted."""
        headers = {"Idempotency-Key": idempotency_key} if idempotency_key else {}
        reply = self.request("POST", "/v1/jobs", json_body=job, headers=headers)
        if reply.status != 202:
            raise AssertionError(f"job not accepted: {reply!r}")
        return reply.json

    def job(self, job_id):
        reply = self.request("GET", f"/v1/jobs/{job_id}")
        if reply.status != 200:
            raise AssertionError(f"job {job_id}: {reply!r}")
        return reply.json

    def wait_for_job(self, job_id, states=OVER, timeout_s=LEAST_PATIENCE_S, look_every_s=0.01):
        """The job's object once it is in one of `states`. Looking costs processor time, which a job that is timed may
        miss: seldom, then."""
        begun = time.monotonic()
        while True:
            job = self.job(job_id)
            if job["state"] in states:
                return job
            if time.monotonic() - begun > patience(timeout_s):
                raise TimeoutError(f"job {job_id} is {job['state']} after {timeout_s} s\n{self.log()[-4000:]}")
            time.sleep(look_every_s)

    def run_job(self, job, **waiting):
        """Submits a job and returns its object once it has succeeded; `waiting` as wait_for_job()'s."""
        job = self.wait_for_job(self.submit(job)["id"], **waiting)
        if job["state"] != "succeeded":
            raise AssertionError(f"job {job['id']}: {job['failure']}")
        return job

    def add_scene(self, path, name=None, media_type="model/gltf-binary"):
        """Uploads a file; returns the scene's object."""
        query = f"?name={name}" if name else ""
        reply = self.request("POST", "/v1/scenes" + query, body=pathlib.Path(path).read_bytes(),
                             headers={"Content-Type": media_type})
        if reply.status not in (200, 201):
            raise AssertionError(f"scene not accepted: {reply!r}")
        return reply.json


class DaemonTestCase(unittest.TestCase):
    """Tests that share one ready daemon, self.daemon, started with `daemon_arguments`."""

    daemon_arguments = ()

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(*cls.daemon_arguments)
        cls.daemon.wait_ready()

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()


def small_job(scene="cornell-box", size=32, passes=1, method="path_tracing", **more):
    """A job that takes a fraction of a second."""
    return {"scene": scene, "image": {"width": size, "height": size}, "method": {"name": method},
            "stop": {"passes": passes}, **more}
