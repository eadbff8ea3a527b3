"""The patches of tests/defects: what their heads say, and which entries of ctest there are to catch them.

A patch is a unified diff with one mistake. Lines before the diff are its head, which `git apply` passes over:

    Defect: what is wrong, in one sentence
    Library: the library that it lies in, or   Method: the method
    Build: the targets that the entries need
    Caught by: ENTRY [CASES]     an entry of ctest, and which of its cases; several lines, the cheapest first
    Kind: statistical | exact | service | browser

CASES is what the entry's own runner takes: GoogleTest's filter, a part of a Python test's name, a part of a browser test's
name, a file for vitest.
"""

import hashlib
import pathlib
import re
from typing import NamedTuple

KINDS = ("statistical", "exact", "service", "browser")
SINGLE = ("Defect", "Library", "Method", "Build", "Kind")

# Libraries that are no folder of renderer/ or server/, and where their sources lie.
OTHER_LIBRARIES = {
    "photond_protocol": r"protocol/",
    "photond_images": r"renderer/\w+/\w+_codec\.cpp",
    "photond_worker_lib": r"server/worker/",
    "photond_cli": r"clients/cli/",
    "clients/python": r"clients/python/photond/",
    "clients/dashboard": r"clients/dashboard/src/",
}
METHODS = "renderer/methods"


class Check(NamedTuple):
    """What is run to catch a defect."""

    entry: str
    cases: str  # empty: all of the entry's

    def __str__(self):
        return f"{self.entry} {self.cases}".strip()


class Patch(NamedTuple):
    path: pathlib.Path
    fields: dict  # of the head, but for the checks
    checks: list
    files: list  # that it changes

    @property
    def name(self):
        return self.path.stem

    @property
    def place(self):
        """The library or method that it is for."""
        return self.fields.get("Library") or self.fields.get("Method", "")

    @property
    def kind(self):
        return self.fields.get("Kind", "")

    @property
    def targets(self):
        return self.fields.get("Build", "").split()

    @property
    def hash(self):
        return hashlib.sha256(self.path.read_bytes()).hexdigest()[:12]


def read_patch(path):
    head, found, diff = path.read_text().partition("diff --git ")
    fields, checks = {}, []
    for line in head.splitlines():
        name, colon, value = line.partition(": ")
        if colon and name == "Caught by":
            entry, _, cases = value.strip().partition(" ")
            checks.append(Check(entry, cases.strip()))
        elif colon:
            fields[name] = value.strip()
    return Patch(path, fields, checks, re.findall(r"^\+\+\+ b/(\S+)", found + diff, re.MULTILINE))


def read_patches(folder):
    return [read_patch(path) for path in sorted(pathlib.Path(folder).glob("*.patch"))]


def faults_of(patch):
    """What is wrong with a patch's head, in words."""
    faults = []
    for name in ("Defect", "Build", "Kind"):
        if not patch.fields.get(name):
            faults.append(f"has no line '{name}: ...'")
    if ("Library" in patch.fields) == ("Method" in patch.fields):
        faults.append("names either a library or a method")
    faults += [f"has a line '{name}: ...' that nobody reads" for name in patch.fields if name not in SINGLE]
    if not patch.checks:
        faults.append("has no line 'Caught by: ...'")
    if patch.kind and patch.kind not in KINDS:
        faults.append(f"is of kind {patch.kind}: one of {', '.join(KINDS)}")
    elif patch.checks and patch.kind not in kinds_of(patch.checks[0].entry):
        faults.append(f"is of kind {patch.kind}, which {patch.checks[0].entry} is not")
    if len(patch.files) != 1:
        faults.append("changes one file")
    elif not re.match(sources_of(patch), patch.files[0]):
        faults.append(f"is for {patch.place} and changes {patch.files[0]}")
    return faults


def kinds_of(entry):
    """Those that the tests of an entry may be of, the usual one first. Some unit tests are statistical."""
    label = entry.split(".")[0]
    if entry in ("dashboard.logic", "dashboard.types"):
        return ("exact",)
    return {"unit": ("exact", "statistical"), "statistical": ("statistical",), "dashboard": ("browser",)}.get(label, ("service",))


def kind_of(entry, patch):
    """The kind of test that an entry is where it catches that patch."""
    kinds = kinds_of(entry)
    return patch.kind if patch.kind in kinds else kinds[0]


def sources_of(patch):
    """An expression for the files that a defect of the patch's library or method lies in."""
    if "Method" in patch.fields:
        return re.escape(f"{METHODS}/{patch.place}/")
    return OTHER_LIBRARIES.get(patch.place, re.escape(patch.place + "/"))


def libraries(root):
    """The names of all libraries in a tree: each is to have a defect."""
    found = set(OTHER_LIBRARIES)
    for folder in (root / "renderer").iterdir():
        if folder.name == "backends":
            found |= {f"renderer/backends/{device.name}" for device in folder.iterdir() if device.is_dir()}
        elif folder.is_dir() and folder.name != "methods":
            found.add(f"renderer/{folder.name}")
    for folder in (root / "server").iterdir():
        if folder.is_dir() and folder.name != "worker":
            found.add(f"server/{folder.name}")
    return found


def methods(root):
    return {folder.name for folder in (root / METHODS).iterdir() if folder.is_dir()}


def known_entries(root):
    """The names of ctest's entries, as tests/CMakeLists.txt makes them of files."""
    tests = root / "tests"
    found = {"dashboard.packages", "dashboard.browser", "dashboard.logic", "dashboard.types"}
    for label in ("unit", "statistical"):
        for file in (tests / label).glob("*/*_test.cpp"):
            gpu = "gpu_" if file.name.startswith("gpu_") else ""
            found.add(f"{label}.{gpu}{file.parent.name}")
    for label in ("unit", "service", "hard_cases"):
        found |= {f"{label}.{file.stem}" for file in (tests / label).glob("*_test.py")}
    return found
