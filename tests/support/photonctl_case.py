"""photonctl as a person and as a script use it, against a daemon of its own.

    def setUpModule():
        cli.start()
    def tearDownModule():
        cli.stop()
    class Something(Case):
        def test_it(self):
            self.run_ok("render", "furnace", *SMALL)
"""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from photond_daemon import BIN, Daemon

PHOTONCTL = str(BIN / "photonctl")
SMALL = ["--width", "24", "--height", "16", "--passes", "2"]
NO_LIMIT_S = 86_400  # more than any test takes
OK, FAILED, USAGE, UNREACHABLE, REFUSED, CANCELLED, TIMED_OUT, LOCAL_FILE, INTERRUPTED = 0, 1, 2, 3, 4, 5, 6, 7, 130


class Cli:
    """The daemon and the folder that the commands run in."""

    def __init__(self):
        self.daemon = self.folder = None

    def start(self, *daemon_options):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="photonctl-test-"))
        self.daemon = Daemon(*daemon_options)
        self.daemon.wait_ready()

    def stop(self):
        self.daemon.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def url(self):
        return f"http://127.0.0.1:{self.daemon.port}"

    def environment(self, **more):
        variables = {k: v for k, v in os.environ.items() if not k.startswith("PHOTOND_") and k != "NO_COLOR"}
        return {**variables, "PHOTOND_URL": self.url(), **more}

    def run(self, *arguments, input=None, **variables):
        return subprocess.run([PHOTONCTL, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder,
                              env=self.environment(**variables), input=input)

    def popen(self, *arguments):
        return subprocess.Popen([PHOTONCTL, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                cwd=self.folder, env=self.environment())

    def bash_completion(self, line):
        """What bash would offer after `line`."""
        words = bash_words(line)
        script = (f'source <("{PHOTONCTL}" completion bash); compopt() {{ :; }}; COMP_LINE="$1"; COMP_POINT=${{#1}}; shift; '
                  'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _photonctl; printf "%s\\n" "${COMPREPLY[@]}"')
        environment = self.environment(PATH=f"{BIN}:{os.environ['PATH']}", PHOTOND_COMPLETION_SECONDS=str(NO_LIMIT_S))
        return subprocess.run(["bash", "-c", script, "bash", line, *words], capture_output=True, text=True, cwd=self.folder,
                              env=environment)


def bash_words(line):
    """As COMP_WORDBREAKS cuts a line: '=' and ':' stand alone."""
    words = []
    for part in line.split(" "):
        word = ""
        for c in part:
            if c in "=:":
                words += [word] * bool(word) + [c]
                word = ""
            else:
                word += c
        words += [word] * bool(word)
    return words + ([""] if line.endswith(" ") else [])


cli = Cli()


def json_lines(result):
    return [json.loads(line) for line in result.stdout.splitlines()]


class Case(unittest.TestCase):
    def run_ok(self, *arguments, **more):
        return self.run_for(OK, *arguments, **more)

    def run_for(self, code, *arguments, **more):
        result = cli.run(*arguments, **more)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}\n{result.stderr}")
        return result

    def completed(self, line):
        cli.daemon.request("GET", "/v1/scenes")  # the first list may take longer than who completes a word waits
        result = cli.bash_completion(line)
        self.assertEqual(result.stderr, "")
        return result.stdout.split()
