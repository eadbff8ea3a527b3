"""The graph of the repository's files: which file takes something from which other. It is read from their text alone, so
that no build is needed.

A C++ file takes what it includes. A header takes the sources that define what it declares. A source takes the shaders
that it names. A test takes the rooms of the methods that it names, and the programs that it starts. Scripts take what they
import.

The registry of methods and the frame of the dashboard know all rooms, and take none here: otherwise each room would reach
each other one.
"""

import os
import pathlib
import posixpath
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEFT_OUT = {"build", "node_modules", "__pycache__", ".cache", "dist"}  # folders, where no git says what is made
SHADERS = (".comp", ".vert", ".frag", ".glsl")
CODE = (".cpp", ".h", *SHADERS)
SCRIPTS = (".ts", ".tsx", ".mjs")

# The source of each program's main().
PROGRAMS = {"photond": "server/main.cpp", "photond-worker": "server/worker/worker_main.cpp", "photonctl": "clients/cli/main.cpp",
            "photond-gpu-bench": "tests/benchmarks/gpu_bench/photond_gpu_bench.cpp"}
OWN_FILES = ("tests/support/file_graph.py", "tests/support/changed_programs.py")  # which name programs and start none
REGISTRY = "renderer/methods/registry.cpp"
ROW = re.compile(r"renderer/methods/(\w+)/row\.cpp")
DASHBOARD_FRAME = re.compile(r"clients/dashboard/src/(app/|main\.tsx$)")
IMAGE_MODULE = "renderer/core/image_module.cpp"  # loads the codecs while the program runs

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"\n]+)"', re.MULTILINE)
LITERAL = re.compile(r'"([\w./-]+)"')
QUOTED = re.compile(r"""["'`]([\w./-]+)["'`]""")
PYTHON_IMPORT = re.compile(r"^\s*(?:from (\.*[\w.]*) import ([\w, ]+|\()|import ([\w., ]+))", re.MULTILINE)
SCRIPT_IMPORT = re.compile(r"""(?:\bfrom|\bimport\(?|\bnew URL\()\s*["'](\.[^"'\n]+)["']""")


def repository_files(root=ROOT):
    """The tracked files and those that git does not ignore. A copy without a repository is walked."""
    if (root / ".git").exists():
        listed = subprocess.run(["git", "-C", root, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                                capture_output=True, text=True, check=True).stdout.split("\0")
        return sorted({name for name in listed if name and (root / name).is_file()})
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = set(folders) - LEFT_OUT
        found += [os.path.relpath(os.path.join(folder, name), root) for name in names if name != ".npm_install.lock"]
    return sorted(found)


def read_texts(files, root=ROOT):
    """File -> its text, of those that have edges."""
    return {name: (root / name).read_text() for name in files if name.endswith((*CODE, *SCRIPTS, ".py"))}


class Names:
    """The functions and classes that a header declares, or that a source defines outside of any class. The code is laid out
    by clang-format: what is of no class or function begins its line."""

    LINE = r"^(?!namespace\b|using\b|static_assert\b|return\b)[A-Za-z][\w:<>,&*\[\] ]*?"
    DECLARED_FUNCTION = re.compile(LINE + r"[ &*](\w+)\(", re.MULTILINE)
    DECLARED_CLASS = re.compile(r"^(?:class|struct) (?:\[\[\w+\]\] )?(\w+)[^;()]*?\{", re.MULTILINE)
    DEFINED = re.compile(LINE + r"\b((?:\w+::)*~?\w+|(?:\w+::)+operator\W+)\(", re.MULTILINE)

    @classmethod
    def declared(cls, text):
        return set(cls.DECLARED_FUNCTION.findall(text)) | {name + "::" for name in cls.DECLARED_CLASS.findall(text)}

    @classmethod
    def defined(cls, text):
        """Of a member the class alone, with its colons."""
        return {name.split("::")[-2] + "::" if "::" in name else name for name in cls.DEFINED.findall(text)}


class FileGraph:
    """takes[FILE] is the set of the files that FILE takes something from."""

    def __init__(self, files, texts):
        self.files = set(files)
        self.rooms = {match[1]: match[0] for match in map(ROW.fullmatch, self.files) if match}
        self.shaders = [name for name in self.files if name.endswith(SHADERS[:3])]
        self.support = {posixpath.basename(name): name for name in self.files if name.startswith("tests/support/")}
        self.takes = {name: set() for name in self.files}
        self.includes = {}
        self.named_rooms = {}
        for name, text in texts.items():
            if name.endswith(CODE):
                self.read_code(name, text)
            elif name.endswith(".py"):
                self.read_python(name, text)
            elif not DASHBOARD_FRAME.match(name):
                self.read_script(name, text)
        self.add_implementations(texts)
        self.add_named_rooms()
        self.add(PROGRAMS["photond"], {PROGRAMS["photond-worker"]})
        self.add(IMAGE_MODULE, {name for name in self.files if name.endswith("_codec.cpp")})

    def add(self, name, others):
        if name in self.files:
            self.takes[name] |= {other for other in others if other in self.files and other != name}

    def read_code(self, name, text):
        self.includes[name] = INCLUDE.findall(text)
        self.add(name, self.includes[name])
        if name.endswith((".cpp", ".h")):
            literals = set(LITERAL.findall(text))
            self.add(name, self.shaders_named(name, literals))
            if name.startswith("tests/"):
                self.named_rooms[name] = self.rooms_named(literals, text)

    def read_python(self, name, text):
        for whence, what, plain in PYTHON_IMPORT.findall(text):
            package = whence.startswith(".")
            modules = [whence.lstrip(".")] if whence.strip(".") else [part.strip() for part in (what or plain).split(",")]
            for module in modules:
                module = module.split(" ")[0].replace(".", "/")
                places = [posixpath.dirname(name)] if package else [posixpath.dirname(name), "tests/support", "clients/python"]
                for place in places:
                    self.add(name, {f"{place}/{module}.py", f"{place}/{module}/__init__.py"})
        self.read_names(name, text)

    def read_script(self, name, text):
        for path in SCRIPT_IMPORT.findall(text):
            target = posixpath.normpath(posixpath.join(posixpath.dirname(name), path))
            self.add(name, {target, *(target + end for end in (".ts", ".tsx", "/index.ts"))})
        self.read_names(name, text)

    def read_names(self, name, text):
        """A test from outside takes what it calls by a name: a program, a file of tests/support, a file by its path."""
        if name.startswith("tests/") and not name.startswith("tests/unit/") and name not in OWN_FILES:
            quoted = set(QUOTED.findall(text))
            self.add(name, {source for program, source in PROGRAMS.items() if program in quoted})
            self.add(name, {self.support[word] for word in quoted if word in self.support})
            self.add(name, quoted)

    def shaders_named(self, name, literals):
        """A literal names a shader by its path, by its file name, or by how its path begins."""
        found = set()
        for literal in literals:
            if literal.endswith(SHADERS):
                found |= {shader for shader in self.shaders if shader == literal or shader.endswith("/" + literal)}
            elif literal.startswith(("renderer/", "tests/gpu/")) and not literal.endswith("/"):
                found |= {shader for shader in self.shaders if shader.startswith(literal)}
        return found

    def rooms_named(self, literals, text):
        if re.search(r"\ball_methods\(", text):
            return set(self.rooms.values())
        return {row for room, row in self.rooms.items() if room in literals}

    def add_implementations(self, texts):
        """A header takes the sources of its folder that define what it declares."""
        declared = {name: Names.declared(text) for name, text in texts.items() if name.endswith(".h")}
        for source, text in texts.items():
            if source.endswith(".cpp"):
                defined = Names.defined(text)
                own = posixpath.splitext(source)[0] + ".h"
                for header in self.headers_beside(source):
                    if header == own or defined & declared.get(header, set()):
                        self.add(header, {source})

    def headers_beside(self, source):
        """The headers of a source's folder that it includes, directly or through others of them."""
        folder, seen, left = posixpath.dirname(source), set(), [source]
        while left:
            found = {name for name in self.includes.get(left.pop(), ()) if name.endswith(".h") and
                     posixpath.dirname(name) == folder} - seen
            seen |= found
            left += found
        return seen

    def add_named_rooms(self):
        """A source takes a method that it names where it can ask the registry for it. A header may be a part of one."""
        for name, rows in self.named_rooms.items():
            if rows and (name.endswith(".h") or REGISTRY in self.reached_from([name])):
                self.add(name, rows)

    def reached_from(self, sources):
        """The files that sources take from, directly or through others, and the sources themselves."""
        seen, left = set(), [name for name in sources if name in self.files]
        while left:
            name = left.pop()
            if name not in seen:
                seen.add(name)
                left += self.takes[name] - seen
        return seen
