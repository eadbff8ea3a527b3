"""The guide for those who run the daemon says what is there: its commands on tokens and backups run as they stand, its
metrics are those that are measured, its options those that the programs have.
"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from photond_daemon import BIN, wait_until

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
GUIDE = (SOURCE / "docs/operating.md").read_text()


def commands_of(section):
    return re.search(r"```sh\n(.*?)```", GUIDE.split(f"\n## {section}\n")[1], re.DOTALL)[1]


class OperatingGuide(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="photond-guide-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.variables = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
        self.variables.pop("PHOTOND_URL", None)

    def shell(self, script, **variables):
        script = script.replace("/var/lib/photond", f"{self.folder}/data").replace("/backup/", f"{self.folder}/backup-")
        return subprocess.Popen(["bash", "-ec", script], cwd=self.folder, env={**self.variables, **variables}, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def run_ok(self, script, **variables):
        process = self.shell(script, **variables)
        output, _ = process.communicate()
        self.assertEqual(process.returncode, 0, f"{script}\n{output}")
        return output

    def start(self, options):
        """A daemon by the guide's own line, on a port of its own; its address."""
        log = self.folder / "listening"
        process = self.shell(f"exec photond --data /var/lib/photond {options} --listen 127.0.0.1:0 > '{log}'")
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        wait_until(lambda: log.exists() and "http" in log.read_text(), "a daemon listens", process)
        return process, log.read_text().split()[-1]

    def test_tokens_backup_and_restore_as_they_stand(self):
        tokens = commands_of("Tokens")
        daemon_line = "photond --data /var/lib/photond --tokens tokens &\n"
        self.assertIn(daemon_line, tokens)
        before, after = tokens.split(daemon_line)
        self.run_ok(before)
        process, url = self.start("--tokens tokens")
        self.assertIn("ready", self.run_ok(after, PHOTOND_URL=url))
        token = (self.folder / "token-of-alice").read_text().strip()

        backup, restore, check, start = commands_of("Backup and restore").splitlines()
        self.run_ok("photonctl render furnace --width 8 --height 8 --passes 1", PHOTOND_URL=url, PHOTOND_TOKEN=token)
        self.assertIn("files,", self.run_ok(backup, PHOTOND_URL=url, PHOTOND_TOKEN=token))
        process.terminate()
        self.assertEqual(process.wait(), 0)
        self.run_ok(restore)
        self.assertEqual(self.run_ok(check), "")
        self.assertIn("photond --data /var/lib/photond-new", start)

    def test_its_metrics_are_those_that_are_measured(self):
        measured = set(re.findall(r'Name\("(photond_\w+)"\)', (SOURCE / "server/metrics.cpp").read_text()))
        table = GUIDE.split("| metric |")[1].split("\n\n")[0]
        self.assertEqual(set(re.findall(r"photond_\w+", table)), measured)
        self.assertLessEqual(set(re.findall(r"\b(photond_\w+)[{\[ ]", GUIDE.split("# photond.rules.yml")[1])), measured)

    def test_its_options_are_there(self):
        known = "".join(subprocess.run([str(BIN / program), "--help"], capture_output=True, text=True, check=True).stdout
                        for program in ("photond", "photonctl"))
        lines = re.findall(r"(?:photond|photonctl) [^\n`]*", GUIDE)
        options = {option for line in lines for option in re.findall(r"--[a-z][\w-]+", line)}
        self.assertGreater(len(options), 5)
        for option in options:
            self.assertIn(option, known)


if __name__ == "__main__":
    unittest.main()
