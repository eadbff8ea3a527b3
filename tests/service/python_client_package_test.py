"""The Python client as a package: it builds and installs without a network, is typed, needs nothing but the standard
library, and its example draws what it promises."""

import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

from photond_daemon import Daemon
from python_client_case import PACKAGE, SOURCE, url_of

PYTHON = "/usr/bin/python3"


def run(*command, **more):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    if result.returncode != 0:
        raise AssertionError(f"{command}: {result.returncode}\n{result.stdout}\n{result.stderr}")
    return result.stdout


class PackageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="photond-package-test-"))
        cls.source = cls.folder / "source"  # builds leave things behind
        shutil.copytree(PACKAGE, cls.source, ignore=shutil.ignore_patterns("__pycache__", "build", "*.egg-info"))
        cls.daemon = Daemon()
        cls.addClassCleanup(cls.daemon.close)
        cls.daemon.wait_ready()
        cls.environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PHOTOND_", "PIP_"))}

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder, ignore_errors=True)

    def venv(self, name):
        run(PYTHON, "-m", "venv", "--without-pip", self.folder / name)
        return self.folder / name / "bin" / "python3"

    def pip(self, *arguments):
        return run(PYTHON, "-m", "pip", "--disable-pip-version-check", *arguments, env=self.environment)

    def check_installed(self, python):
        """In a bare environment: no numpy, no matplotlib."""
        printed = run(python, "-c", "import photond, importlib.util as u; c = photond.Client(); "
                      "print(photond.__file__, u.find_spec('numpy'), photond.__version__); "
                      "j = c.render('furnace', width=4, height=4, passes=1); "
                      "print(j.state, j.pixels('emitted').at(0, 0))",
                      env={**self.environment, "PHOTOND_URL": url_of(self.daemon)}, cwd=self.folder)
        self.assertRegex(printed, r"^/.*/site-packages/photond/__init__.py None ")
        self.assertIn("succeeded (1.0, 1.0, 1.0)", printed)

    def test_a_wheel_is_built_and_installed_without_a_network(self):
        self.pip("wheel", "--no-build-isolation", "--no-index", "--no-deps", "-w", self.folder / "wheels", self.source)
        [wheel] = (self.folder / "wheels").iterdir()
        self.assertRegex(wheel.name, r"^photond-[\d.]+-py3-none-any\.whl$")
        names = zipfile.ZipFile(wheel).namelist()
        self.assertIn("photond/py.typed", names)
        modules = {f"photond/{file.name}" for file in (PACKAGE / "photond").glob("*.py")}
        self.assertEqual({name for name in names if name.startswith("photond/") and name.endswith(".py")}, modules)
        python = self.venv("from_wheel")
        self.pip("--python", python, "install", "--no-index", wheel)
        self.check_installed(python)

    def test_a_plain_path_installs(self):
        python = self.venv("from_path")
        site = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
        self.pip("install", "--no-build-isolation", "--no-index", "--no-deps", "--target", site, self.source)
        self.check_installed(python)

    def test_the_source_installs_where_there_is_nothing_but_python(self):
        """As in `python3 -m venv`, which has no wheel, without a network: neither setuptools nor wheel is asked for."""
        for options in ([], ["--no-build-isolation"]):
            with self.subTest(options=options):
                python = self.venv("plain" + "".join(options))
                self.pip("--python", python, "install", "--no-index", *options, self.source)
                self.assertIn("site-packages", run(python, "-c", "import photond; print(photond.__file__)", cwd=self.folder))
        self.check_installed(python)

    def test_its_version_is_the_daemons(self):
        declared = re.search(r"project\(photond VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]
        self.assertIn(f'"{declared}"', (PACKAGE / "photond" / "_version.py").read_text())

    def test_types_hold(self):
        run(PYTHON, "-m", "mypy", "--config-file", PACKAGE / "pyproject.toml", "--cache-dir", self.folder / "mypy",
            cwd=PACKAGE, env=self.environment)

    def test_a_users_mistake_is_found_by_its_types(self):
        lines = {"right": 'client.render("furnace", "path_tracing", passes=4).wait()',
                 "type": 'client.render("furnace", passes="4")', "name": 'client.render("furnace", pases=4)'}
        for name, line in lines.items():
            (self.folder / f"uses_{name}.py").write_text(f"import photond\nclient = photond.Client()\n{line}\n")
        result = subprocess.run([PYTHON, "-m", "mypy", "--config-file", PACKAGE / "pyproject.toml", "--strict", "--cache-dir",
                                 self.folder / "mypy", *(self.folder / f"uses_{name}.py" for name in lines)],
                                capture_output=True, text=True, env={**self.environment, "MYPYPATH": str(PACKAGE)})
        said = result.stdout.splitlines()
        found = {name: [line for line in said if f"uses_{name}.py" in line] for name in lines}
        self.assertEqual(found["right"], [], said)
        self.assertIn("arg-type", "".join(found["type"]), said)
        self.assertIn("call-arg", "".join(found["name"]), said)
        self.assertRegex(said[-1], "^Found [0-9]+ errors in 2 files .*checked 3 source files", said)


class ExampleTest(unittest.TestCase):
    def test_a_graph_of_the_thesis_is_drawn_again(self):
        with tempfile.TemporaryDirectory() as folder, Daemon() as daemon:
            daemon.wait_ready()
            out = pathlib.Path(folder) / "graphs.svg"
            printed = run(sys.executable, PACKAGE / "examples" / "thesis_graphs.py", "--width", 48, "--height", 27, "--passes",
                          2, "--reference-passes", 8, "-o", out,
                          env={**os.environ, "PHOTOND_URL": url_of(daemon), "PYTHONPATH": str(PACKAGE)}, cwd=folder)
            self.assertIn("photon mapping", printed)
            self.assertIn("Graph 4", out.read_text())
            with open(out.with_suffix(".csv"), newline="") as file:
                rows = list(csv.DictReader(file))
        self.assertEqual({row["graph"] for row in rows}, {"1", "2", "3", "4"})
        self.assertTrue(all(float(row["error"] or row["below"]) > 0 and float(row["seconds"]) > 0 for row in rows))


if __name__ == "__main__":
    unittest.main()
