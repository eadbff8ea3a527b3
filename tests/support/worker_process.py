"""Drives one photond-worker over its socket pair, as the daemon does."""

import json
import os
import socket
import subprocess

BIN = os.environ.get("PHOTOND_BIN", "build/bin")


class WorkerProcess:
    """A worker process; `kind` is "cpu" or "none" (the helper). It may open the files of `folders` and no others."""

    def __init__(self, kind, *folders, threads=2, memory_limit=2 << 30):
        ours, theirs = socket.socketpair()

        def hand_over():
            os.dup2(theirs.fileno(), 3)  # the duplicate is inherited
            if theirs.fileno() != 3:
                os.close(theirs.fileno())

        arguments = [os.path.join(BIN, "photond-worker"), "--device", kind, "--threads", str(threads),
                     "--memory-limit", str(memory_limit), *(f"--write={folder}" for folder in folders)]
        self.process = subprocess.Popen(arguments, preexec_fn=hand_over, close_fds=False, stdin=subprocess.DEVNULL)
        theirs.close()
        self.socket = ours
        self.buffer = b""
        self.requests = 0

    def send(self, **message):
        self.socket.sendall(json.dumps(message).encode() + b"\n")

    def receive(self):
        """The next message, None at the end of the stream, which comes when the worker has ended."""
        while b"\n" not in self.buffer:
            try:
                chunk = self.socket.recv(1 << 16)
            except ConnectionResetError:
                chunk = b""
            if not chunk:
                return None
            self.buffer += chunk
        line, self.buffer = self.buffer.split(b"\n", 1)
        return json.loads(line)

    def wait_for(self, kind):
        """The next message of a type, and all that came before it."""
        before = []
        while True:
            message = self.receive()
            assert message is not None, f"the worker ended before {kind}, with status {self.process.wait()}; {before[-3:]}"
            if message["type"] == kind:
                return message, before
            before.append(message)

    def ask(self, task, **fields):
        """A helper's task: its reply."""
        self.requests += 1
        self.send(type=task, request=self.requests, **fields)
        reply, _ = self.wait_for("reply")
        assert reply["request"] == self.requests
        return reply

    def close(self):
        self.socket.close()
        self.process.wait()
