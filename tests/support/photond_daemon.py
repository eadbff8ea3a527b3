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
import time
import unittest

BIN = pathlib.Path(os.environ.get("PHOTOND_BIN", pathlib.Path(__file__).resolve().parents[2] / "build" / "bin"))
LISTENING = re.compile(r"^photond listening on http://(\S+):(\d+)\s*$")
OVER = ("succeeded", "failed", "cancelled")
LONGEST_WAIT_S = 600  # that a request may ask the daemon for; who waits longer asks again
# How many times as long as usual programs take: those under a sanitizer are slow. The daemon's own limits are that much longer.
PATIENCE = float(os.environ.get("PHOTOND_TEST_PATIENCE", "1"))
UNDER_SANITIZER = "PHOTOND_UNDER_SANITIZER" in os.environ
LOG_SHOWN = 4000  # characters of a daemon's log that a failure shows, its last

# The daemon is not dumpable, so that its files in /proc are root's.
needs_root = unittest.skipUnless(os.geteuid() == 0, "only root sees into the daemon's process")


class Ended(ConnectionError):
    """What a test waits for does not come any more, because the process or the job has ended that would bring it."""


def wait_until(condition, what, *sources, look_every_s=0.01):
    """What `condition` gives once that is true. `sources` are the daemons and processes that bring it about: the wait ends
    with the words of `what`, and with a daemon's log, when one of them has ended before. There is no time-out but ctest's:
    a busy machine makes every wait longer.
    """
    while not (value := condition()):
        ended = [source for source in sources if has_ended(source)]
        if ended:
            if value := condition():  # the last thing that it did
                return value
            raise Ended(f"{what}: it never comes, for {', '.join(map(account_of, ended))}")
        time.sleep(look_every_s)
    return value


def has_ended(source):
    """Whether a Daemon, or a subprocess.Popen, runs no more."""
    return not source.running() if isinstance(source, Daemon) else source.poll() is not None


def account_of(source):
    """How a Daemon or a subprocess.Popen has ended."""
    if not isinstance(source, Daemon):
        return f"{source.args} has ended with status {source.returncode}"
    if source.process is None:
        return "the daemon was not started"
    return f"the daemon has ended with status {source.process.returncode}\n{source.log()[-LOG_SHOWN:]}"


def fields_of(stat):
    """The fields of one of the kernel's files named stat, from the state of the process or thread on."""
    return pathlib.Path(stat).read_text().rsplit(")", 1)[1].split()


def processor_ticks(pid):
    """What a process has computed, in the kernel's ticks."""
    fields = fields_of(f"/proc/{pid}/stat")
    return int(fields[11]) + int(fields[12])


def is_waiting(pid):
    """Whether no thread of a process wants a processor: one that gets none on a busy machine wants it nevertheless."""
    return all(fields_of(stat)[0] not in "RD" for stat in pathlib.Path(f"/proc/{pid}/task").glob("*/stat"))


def wait_until_at_rest(pids):
    """Returns once those processes, `pids()`, are the same at five looks within two seconds, and neither compute nor want
    to meanwhile. One that has ended raises FileNotFoundError.
    """
    looks = []
    while len(looks) < 5 or any(look != looks[-1] for look in looks[-5:]):
        time.sleep(0.5)
        now = sorted((pid, processor_ticks(pid)) for pid in pids())
        looks = [*looks, now] if all(is_waiting(pid) for pid, _ in now) else []


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

    def __init__(self, *extra, data_dir=None, start=True, environment=None, open_files=None, address_space=None):
        self.extra = [str(argument) for argument in extra]
        if PATIENCE > 1:
            for option, seconds in (("--helper-timeout", 120), ("--heartbeat-timeout", 30)):
                if option not in self.extra:
                    self.extra += [option, str(PATIENCE * seconds)]
        if "--repeats" not in self.extra:  # how busy the machine is decides nothing but where a test is about that
            self.extra += ["--repeats", "0"]
        self.own_data = data_dir is None
        self.data_dir = pathlib.Path(data_dir or tempfile.mkdtemp(prefix="photond-test-"))
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
        line = self.process.stdout.readline()  # empty once it has ended
        match = LISTENING.match(line.decode())
        if not match:
            self.kill()
            raise RuntimeError(f"photond did not start: {' '.join(command)}\nstdout: {line}\n{self.log()[-LOG_SHOWN:]}")
        self.address, self.port = match.group(1), int(match.group(2))

    def wait_ready(self):
        """Until /readyz answers 200."""
        self.wait_until(lambda: self.request("GET", "/readyz").status == 200, "the daemon is ready", look_every_s=0.02)

    def wait_until(self, condition, what, job=None, look_every_s=0.01):
        """What `condition` gives once that is true, as the function wait_until() does with this daemon. Where `job` is an
        id, the wait ends with that job too.
        """
        def fulfilled():
            value = condition()
            if value or not job:
                return value
            found = self.job(job)
            if found["state"] not in OVER:
                return None
            if value := condition():  # the last thing that it did
                return value
            raise Ended(f"{what}: it never comes, for {self.account_of_job(found)}")
        return wait_until(fulfilled, what, self, look_every_s=look_every_s)

    def running(self):
        return self.process is not None and self.process.poll() is None

    def stop(self):
        """SIGTERM and wait; returns the exit status."""
        if self.process is None:
            return None
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait()
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
    def request(self, method, path, body=None, headers=None, json_body=None):
        """One request over its own connection. Raises Ended with the log where the daemon has ended."""
        headers = dict(headers or {})
        if json_body is not None:
            body = json.dumps(json_body).encode()
            headers.setdefault("Content-Type", "application/json")
        connection = http.client.HTTPConnection(self.address, self.port)
        try:
            connection.request(method, path, body=body, headers=headers)
            response = connection.getresponse()
            return Reply(response.status, {k.lower(): v for k, v in response.getheaders()}, response.read())
        except (OSError, http.client.HTTPException) as error:
            if not has_ended(self):
                raise
            raise Ended(f"{method} {path}: {error!r}, for {account_of(self)}") from error
        finally:
            connection.close()

    def submit(self, job, idempotency_key=None):
        """Posts a job and returns its object; raises when it is not accepted."""
        headers = {"Idempotency-Key": idempotency_key} if idempotency_key else {}
        reply = self.request("POST", "/v1/jobs", json_body=job, headers=headers)
        if reply.status != 202:
            raise AssertionError(f"job not accepted: {reply!r}")
        return reply.json

    def job(self, job_id, query=""):
        """The job's object."""
        reply = self.request("GET", f"/v1/jobs/{job_id}{query}")
        if reply.status != 200:
            raise AssertionError(f"job {job_id}: {reply!r}")
        return reply.json

    def account_of_job(self, job):
        """What became of a job that is over, by its object."""
        return f"job {job['id']} is {job['state']} after {job['passes_done']} passes: {job['failure']}\n{self.log()[-LOG_SHOWN:]}"

    def wait_for_job(self, job_id, states=OVER):
        """The job's object once it is in one of `states`; raises Ended when it is over in another one. The daemon itself
        says when a job is over: looks would take processor time from it.
        """
        if not set(OVER) <= set(states):
            return self.wait_for_job_that(lambda job: job["state"] in states, f"to be {' or '.join(states)}", job_id)
        while (job := self.job(job_id, f"?wait={LONGEST_WAIT_S}"))["state"] not in states:
            pass
        return job

    def wait_for_passes(self, job_id, passes=1):
        """The job's object once it has done that many passes; raises Ended when it is over with fewer."""
        return self.wait_for_job_that(lambda job: job["passes_done"] >= passes, f"to have done {passes} passes", job_id)

    def wait_for_job_that(self, fits, what, job_id):
        """The job's object once `fits` is true of it; raises Ended, with the words of `what`, when it is over before."""
        def fitting():
            job = self.job(job_id)
            if fits(job):
                return job
            if job["state"] in OVER:
                raise Ended(f"waited for {job_id} {what}: {self.account_of_job(job)}")
            return None
        return self.wait_until(fitting, f"{job_id} {what}")

    def wait_for_kept_film(self, job_id, attempt=1):
        """Until the store names the film that a job's attempt saves while it runs, which is a little after the film is there.
        A backup tells what the store names.
        """
        film = f"films/{job_id}-{attempt}.film"
        self.wait_until(lambda: film in [file["path"] for file in self.request("POST", "/v1/backups").json["files"]],
                        f"the store names {film}", job=job_id, look_every_s=0.05)

    def wait_for_state(self, path, states=OVER):
        """The comparison or sequence at `path` once it is in one of `states`; raises Ended when it is over in another one."""
        def fitting():
            found = self.request("GET", path).json
            if found["state"] in states:
                return found
            if found["state"] in OVER:
                raise Ended(f"waited for {path} to be {' or '.join(states)}: it is {found['state']}\n{self.log()[-LOG_SHOWN:]}")
            if set(states) <= set(OVER):  # not before its last job is over, which the daemon tells who waits for that
                jobs = found.get("jobs") or found.get("frames")
                self.request("GET", f"/v1/jobs/{jobs[-1]['id']}?wait={LONGEST_WAIT_S}")
            return None
        return self.wait_until(fitting, f"{path} is {' or '.join(states)}", look_every_s=0.02)

    def run_job(self, job):
        """Submits a job and returns its object once it has succeeded."""
        job = self.wait_for_job(self.submit(job)["id"])
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
