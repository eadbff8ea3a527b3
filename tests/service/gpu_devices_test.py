"""Which devices there are, which of them a daemon renders on, and what it refuses: without rendering anything on them."""

import os
import signal
import unittest

from gpu_daemon import able_gpus, gpu_daemon, listed_devices, needs_gpu, thread_states
from jsonschema import Draft202012Validator
from photond_daemon import Daemon, needs_root, small_job

NO_DRIVER = {"VK_ICD_FILENAMES": "/nowhere/icd.json", "VK_DRIVER_FILES": "/nowhere/icd.json"}


def validator(daemon, name):
    document = daemon.request("GET", "/v1/openapi.json").json
    return Draft202012Validator({"$ref": f"#/components/schemas/{name}", "components": document["components"]})


def devices_of(daemon):
    page = daemon.request("GET", "/v1/devices").json
    validator(daemon, "DevicePage").validate(page)
    return {device["id"]: device for device in page["items"]}


class WithoutGpuTest(unittest.TestCase):
    """The daemon as it starts by default: it serves the CPU, and says what else the machine has."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.close)
        cls.daemon.wait_ready()

    def test_the_cpu_is_served_and_gpus_are_listed(self):
        devices = devices_of(self.daemon)
        self.assertEqual(list(devices), [device["id"] for device in listed_devices()])
        cpu = devices["cpu"]
        self.assertEqual((cpu["kind"], cpu["served"], cpu["state"], cpu["lacks"]), ("cpu", True, "ready", []))
        for device in listed_devices():
            if device["kind"] != "gpu":
                continue
            shown = devices[device["id"]]
            self.assertFalse(shown["served"])
            self.assertEqual(shown["state"], "failed" if device["lacks"] else "ready")
            self.assertEqual(shown["limits"], device["limits"])

    def test_a_job_for_a_gpu_is_refused_and_never_moved(self):
        for device in ("gpu", "gpu:0"):
            for query in ("", "?dry_run=true"):
                job = small_job()
                job["method"]["device"] = device
                reply = self.daemon.request("POST", "/v1/jobs" + query, json_body=job)
                self.assertEqual(reply.status, 422, reply)
                self.assertEqual(reply.json["code"], "device_unavailable", reply)
                self.assertEqual([error["pointer"] for error in reply.json["errors"]], ["/method/device"], reply)
        self.assertEqual(self.daemon.request("GET", "/v1/jobs").json["items"], [])

    @needs_root
    def test_the_daemon_loads_no_driver(self):
        devices_of(self.daemon)
        with open(f"/proc/{self.daemon.process.pid}/maps") as maps:
            loaded = maps.read()
        for library in ("libvulkan", "libvulkan_lvp", "libLLVM", "nvidia"):
            self.assertNotIn(library, loaded)


class RefusedStartTest(unittest.TestCase):
    def refused(self, devices, expected, environment=None):
        with self.assertRaisesRegex(RuntimeError, expected):
            Daemon("--devices", devices, environment=environment).close()

    def test_devices_that_are_not_there(self):
        self.refused("teapot", "device 'teapot' is unavailable")
        self.refused("cpu,gpu:99", "device 'gpu:99' is unavailable; this machine has: cpu")
        self.refused("cpu,cpu", "cpu is named twice")

    @needs_gpu
    def test_a_gpu_by_two_names(self):
        self.refused("gpu," + able_gpus()[0]["id"], "is named twice")

    def test_without_a_driver(self):
        self.refused("gpu", "device 'gpu' is unavailable; this machine has: cpu", environment=NO_DRIVER)
        with Daemon(environment=NO_DRIVER) as daemon:
            daemon.wait_ready()
            self.assertEqual(list(devices_of(daemon)), ["cpu"])
            self.assertEqual(daemon.run_job(small_job())["state"], "succeeded")


@needs_gpu
class WithGpuTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.daemon = gpu_daemon()
        cls.addClassCleanup(cls.daemon.close)
        cls.gpu = able_gpus()[0]["id"]

    def test_it_is_served_by_a_worker_of_its_own(self):
        device = devices_of(self.daemon)[self.gpu]
        self.assertEqual((device["served"], device["state"], device["kind"]), (True, "ready", "gpu"))
        self.assertGreater(device["memory_bytes"], 1 << 28)
        self.assertTrue(device["driver"])
        self.assertGreaterEqual(device["limits"]["storage_buffer_bytes"], 1 << 27)
        self.assertEqual(set(self.daemon.workers()), {"cpu", self.gpu})

    def test_every_thread_of_it_is_in_the_sandbox(self):
        pid = self.daemon.workers()[self.gpu]
        states = thread_states(pid, "Seccomp", "NoNewPrivs")
        self.assertGreater(len(states), 1)
        self.assertEqual(set(states), {("2", "1")}, "2: a filter")
        with open(f"/proc/{pid}/limits") as file:
            limits = {line[:26].strip(): line[26:].split()[0] for line in file}
        self.assertEqual(limits["Max core file size"], "0")

    def test_a_killed_worker_is_replaced(self):
        pid = self.daemon.workers()[self.gpu]
        os.kill(pid, signal.SIGKILL)
        self.daemon.wait_until(lambda: self.daemon.workers()[self.gpu] not in (pid, None), "it is replaced")
        self.daemon.wait_ready()


if __name__ == "__main__":
    unittest.main()
