"""Processes of nobody's, that take processors from a daemon's jobs."""

import os
import subprocess
import sys

CORES = os.cpu_count()


class BusyLoops:
    """While it is entered, that many run. They outrank the workers, which are nice."""

    def __init__(self, count=CORES):
        self.count = count

    def __enter__(self):
        command = [sys.executable, "-c", "print(flush=True)\nwhile True: pass"]
        self.processes = [subprocess.Popen(command, stdout=subprocess.PIPE) for _ in range(self.count)]
        for process in self.processes:
            process.stdout.readline()
        return self

    def __exit__(self, *_):
        for process in self.processes:
            process.kill()
            process.wait()
            process.stdout.close()
