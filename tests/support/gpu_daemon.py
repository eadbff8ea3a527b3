"""What tests of GPUs in the service share: is there one, and a daemon that has it."""

import functools
import json
import os
import pathlib
import re
import socket
import subprocess
import unittest

from photond_daemon import BIN, Daemon

LAYERS = BIN.parent / "vulkan_layers"


@functools.cache
def listed_devices():
    """What the process says that lists devices."""
    ours, theirs = socket.socketpair()
    with ours:
        with theirs:
            command = ["sh", "-c", 'exec "$0" --device list 3<&"$1"', str(BIN / "photond-worker"), str(theirs.fileno())]
            process = subprocess.Popen(command, pass_fds=[theirs.fileno()])
        message = ours.makefile().readline()
        process.wait()
    return json.loads(message)["items"]


def able_gpus():
    return [device for device in listed_devices() if device["kind"] == "gpu" and not device["lacks"]]


def needs_gpu(test):
    """For tests and their classes: skipped where no Vulkan device can render."""
    return unittest.skipUnless(able_gpus(), "no Vulkan device that can render")(test)


def gpu_daemon(*extra, devices="cpu,gpu", environment=None, **more):
    """A daemon with a GPU, ready."""
    daemon = Daemon("--devices", devices, *extra, environment=environment, **more)
    try:
        daemon.wait_ready()
    except BaseException:
        daemon.close()
        raise
    return daemon


def validation_messages(daemon):
    """What Vulkan's validation layers had to say, where PHOTOND_GPU_VALIDATION=1 was in its environment."""
    return re.findall(r".*Vulkan validation.*", daemon.log())


def fault_environment(folder, call, at=None, result="lost", once=True):
    """Of a process whose `at`-th call of Vulkan's function `call` fails (tests/support/vulkan_fault_layer.cpp); with
    `once` only of the first process that gets so far. counted_calls() tells how many there were."""
    folder = pathlib.Path(folder)
    for name in ("once", "counts"):
        (folder / name).unlink(missing_ok=True)
    environment = {"VK_LAYER_PATH": str(LAYERS), "VK_INSTANCE_LAYERS": "VK_LAYER_PHOTOND_fault",
                   "PHOTOND_FAULT_CALL": call, "PHOTOND_FAULT_RESULT": result,
                   "PHOTOND_FAULT_COUNTS": str(folder / "counts"),
                   "CUDA_CACHE_PATH": str(folder)}  # where a driver, and so the layer, may write
    if at is not None:
        environment["PHOTOND_FAULT_AT"] = str(at)
    if once:
        environment["PHOTOND_FAULT_ONCE"] = str(folder / "once")
    return environment


def counted_calls(folder):
    counts = pathlib.Path(folder) / "counts"
    return len(counts.read_text().splitlines()) if counts.exists() else 0


def thread_states(pid, *keys):
    """Of every thread of a process the values of those lines of /proc/PID/task/TID/status."""
    states = []
    for task in os.listdir(f"/proc/{pid}/task"):
        text = pathlib.Path(f"/proc/{pid}/task/{task}/status").read_text()
        states.append(tuple(re.search(rf"^{key}:\s*(\S+)", text, re.MULTILINE).group(1) for key in keys))
    return states
