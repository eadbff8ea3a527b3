"""Manual pages and shell completions: all that --help says is in them, and --help says every default."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from photond_daemon import BIN

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
# Options with a value that nothing stands for: without one the daemon does something else.
WITHOUT_DEFAULT = {"--new-token"}


def run(*command, **more):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True, **more).stdout


def options_in(text):
    """name -> what stands behind it, of the lines of --help."""
    return dict(re.findall(r"^  (?:-\w,)?(--[\w-]+)(?: (\S+))?", text, re.MULTILINE))


class ManualPages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="photond-pages-test-"))
        run("/usr/bin/python3", SOURCE / "deploy/manual_pages.py", BIN, cls.folder)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    def page(self, name):
        return (self.folder / "man/man1" / f"{name}.1").read_text().replace("\\-", "-")

    def test_the_daemons_help_says_every_default(self):
        options = options_in(run(BIN / "photond", "--help"))
        self.assertGreater(len(options), 25)
        for name, value in options.items():
            if value and not value.endswith(":") and name not in WITHOUT_DEFAULT and name not in ("--check", "--repair"):
                self.assertIn("=", value, name)

    def test_pages_have_what_help_has(self):
        page = self.page("photond")
        for name, value in options_in(run(BIN / "photond", "--help")).items():
            self.assertIn(f"\\fB{name}\\fR", page)
        self.assertIn("\\fB--max-queue\\fR \\fIINT\\fR\nJobs waiting. Default: 100000.", page)
        page = self.page("photonctl")
        for command in (["render"], ["repeat"], ["jobs", "priority"], ["comparisons", "remove"], ["completion"]):
            self.assertIn(f"\n.SS {' '.join(command)}\n", page)
            for name in options_in(run(BIN / "photonctl", *command, "--help", "--server", "http://127.0.0.1:1")):
                if name != "--help":
                    self.assertIn(f"\\fB{name}\\fR", page.split(f"\n.SS {' '.join(command)}\n")[1].split("\n.SS ")[0])
        self.assertIn("\\fB--set\\fR \\fINAME=VALUE\\fR", page)
        self.assertIn("the daemon refused", page)  # the exit codes
        self.assertNotIn(os.environ.get("HOME", "/root") + "/", page + self.page("photond"))

    def test_bash_completes_the_daemons_options(self):
        def completed(*words):
            script = ('source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _photond; '
                      'printf "%s\\n" "${COMPREPLY[@]}"')
            return run("bash", "-c", script, "bash", self.folder / "bash-completion/completions/photond", "photond", *words,
                       cwd=self.folder).split()

        self.assertEqual(completed("--max-q"), ["--max-queue"])
        self.assertEqual(completed("--log-level", "w"), ["warning"])
        self.assertEqual(completed("--data", "bash"), ["bash-completion"])
        self.assertEqual(completed("--threads", ""), [])

    def test_every_shell_has_both_programs(self):
        for path, said in (("bash-completion/completions/photonctl", "photonctl complete --line"),
                           ("zsh/site-functions/_photonctl", "#compdef photonctl"),
                           ("fish/vendor_completions.d/photonctl.fish", "photonctl complete --words"),
                           ("zsh/site-functions/_photond", "'--devices[one worker process each]:DEVICE,DEVICE:'"),
                           ("fish/vendor_completions.d/photond.fish", "-l log-level -x -a 'debug info warning error'")):
            with self.subTest(path=path):
                self.assertIn(said, (self.folder / path).read_text())


if __name__ == "__main__":
    unittest.main()
