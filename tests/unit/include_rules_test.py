"""Who may include whom: the table of the architecture, checked on every #include of protocol/, renderer/, server/ and
clients/. Each row is also proved to bite: a planted violation of it must be found, and a permitted include must not be.

    include_rules_test.py --draw folders   # Graphviz's text of the renderer's folders and who includes whom
    include_rules_test.py --draw files     # of its files
"""

import fnmatch
import os
import pathlib
import re
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
TREES = ("protocol", "renderer", "server", "clients")
SHADERS = {".glsl", ".comp", ".vert", ".frag"}
SUFFIXES = {".h", ".cpp"} | SHADERS

# What of protocol/ the renderer may see; each of these headers includes the standard library only (checked below).
PLAIN_PROTOCOL = ["protocol/error.h", "protocol/nearest_name.h", "protocol/param_info.h",
                  "protocol/scene_families.h"]

# From the ground up: a folder sees those of the storeys below its own, and itself.
STOREYS = [
    ["core"],
    ["scene", "film", "error"],
    ["transport"],
    ["backends/gpu"],  # one scene upload for all shaders: lights and tables among it, which transport makes
    ["photons", "voxels", "frame"],
    ["eye"],
    ["gbuffer"],
    ["splats"],
    ["many_lights"],
    ["gathering"],
    ["progressive"],
    ["bidirectional"],
]


def below(storey):
    """The folders of the storeys below one."""
    return [f"renderer/{folder}/*" for folders in STOREYS[:storey] for folder in folders]


BELOW_METHODS = [*below(len(STOREYS)), "renderer/backends/*"]

# Files (the first pattern that fits counts) -> what of our own they may include, besides files of their own pattern's
# folder. `{room}` stands for the folder a method lives in: no room sees another.
MAY_INCLUDE = [
    ("protocol/*", ["protocol/*"]),
    *((f"renderer/{folder}/*", [f"renderer/{folder}/*", *below(storey), *PLAIN_PROTOCOL])
      for storey, folders in enumerate(STOREYS) for folder in folders),
    ("renderer/backends/{room}/*", ["renderer/backends/{room}/*", "renderer/scene/*", "renderer/core/*",
                                    *PLAIN_PROTOCOL]),
    # The one list of rooms names them; what each is, its row.cpp says.
    ("renderer/methods/registry.cpp", ["renderer/methods/registry.h", "renderer/gbuffer/temporal_reprojection.h"]),
    ("renderer/methods/registry.h", ["renderer/frame/method_info.h"]),
    ("renderer/methods/{room}/*", ["renderer/methods/{room}/*", *BELOW_METHODS, *PLAIN_PROTOCOL]),
    # The daemon never renders: of the renderer it knows what it needs to judge a request and to name files.
    ("server/worker/*", ["server/*", "protocol/*", "renderer/methods/registry.h", *BELOW_METHODS]),
    ("server/*", ["server/*", "protocol/*", "renderer/methods/registry.h", "renderer/frame/render_context.h",
                  "renderer/frame/left_out.h", "renderer/core/*", "renderer/film/*.h", "renderer/error/*.h", "renderer/scene/*.h"]),
    ("clients/{room}/*", ["clients/{room}/*", "protocol/*"]),
]

# A shader reads the scene and traces rays where it is needed: what C++ is given as an argument.
SHADERS_MAY_INCLUDE = ["renderer/backends/gpu/*"]

# Outside headers -> the only files that may include them.
LIBRARIES = [
    ("httplib.h", ["server/routes/*", "clients/cli/http_client.cpp"]),
    ("sqlite3.h", ["server/store/*"]),
    ("embree3/*", ["renderer/backends/cpu/*", "renderer/backends/gpu/bvh*.cpp"]),
    ("meshoptimizer.h", ["renderer/scene/gltf*.cpp"]),
    ("tiny_gltf.h", ["renderer/scene/gltf_document.h"]),
    ("OpenImageIO/*", ["renderer/film/exr_codec.cpp", "renderer/film/png_codec.cpp",
                       "renderer/scene/texture_codec.cpp"]),
    # JSON on the wire, and the judge of glTF.
    ("nlohmann/*", ["protocol/*", "server/*", "clients/*", "renderer/scene/gltf*"]),
    ("openssl/evp.h", ["renderer/core/sha256.cpp"]),
    ("openssl/*", ["server/auth.cpp"]),
    # The worker sets the number of threads.
    ("tbb/*", ["renderer/core/*", "server/worker/*", "renderer/precompiled.h"]),
    ("glm/*", ["renderer/*"]),
    ("vulkan/*", ["renderer/backends/gpu/*"]),
    ("volk.h", ["renderer/backends/gpu/*"]),
    ("glslang/*", ["renderer/backends/gpu/*"]),
    ("spirv-tools/*", ["renderer/backends/gpu/shader_specialization.cpp"]),
    ("nanoflann.hpp", ["renderer/photons/*"]),
    ("spdlog/*", ["server/*"]),
    ("prometheus/*", ["server/metrics.cpp"]),
    ("CLI/*", ["server/main.cpp", "server/worker/worker_main.cpp", "clients/cli/*"]),
    ("zip.h", ["server/worker/*"]),
    ("seccomp.h", ["server/worker/*"]),
]

# The C library and the system: never a third party.
SYSTEM = [
    "unistd.h", "fcntl.h", "poll.h", "signal.h", "spawn.h", "sched.h", "netdb.h", "malloc.h", "dlfcn.h", "pthread.h",
    "termios.h", "dirent.h", "gnu/*", "sys/*", "linux/*", "netinet/*", "arpa/*", "immintrin.h", "experimental/simd",
]
STANDARD = re.compile(r"[a-z_0-9]+")  # <vector>, <cstdint>: no dot, no slash
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"\n]*)"|<([^>\n]*)>|(\S+))', re.MULTILINE)


def fits(pattern, path, room=None):
    """`*` crosses folders; `{room}` is one folder name (the given one, if any); `{file}` is one file name."""
    expression = fnmatch.translate(pattern.replace("{room}", "@R").replace("{file}", "@F"))
    expression = expression.replace("@R", f"(?P<room>{re.escape(room) if room else '[^/]+'})").replace("@F", "[^/]+")
    return re.match(expression, path)


def may_include(path):
    """The patterns for one file with its room filled in; None where the table has no row for it."""
    for files, allowed in MAY_INCLUDE:
        match = fits(files, path)
        if match:
            everywhere = SHADERS_MAY_INCLUDE if pathlib.PurePosixPath(path).suffix in SHADERS else []
            return [(pattern, match.groupdict().get("room")) for pattern in allowed + everywhere]
    return None


def check_include(root, path, ours, outside, computed):
    """What is wrong with one #include of `path`; None when nothing is."""
    if computed:
        return f"includes {computed}, a macro: the table cannot be checked"
    if ours:
        if not (root / ours).is_file():
            return f'includes "{ours}", which is no file of the repository written from its root'
        allowed = may_include(path)
        if allowed is None:
            return "lies in a folder the table does not know"
        if not any(fits(pattern, ours, room) for pattern, room in allowed):
            return f'may not include "{ours}"'
        return None
    if any(fnmatch.fnmatchcase(outside, pattern) for pattern in SYSTEM) or STANDARD.fullmatch(outside):
        return None
    rows = [files for header, files in LIBRARIES if fnmatch.fnmatchcase(outside, header)]
    if not rows:
        return f"includes <{outside}>: no row says who may use this library"
    if not any(fnmatch.fnmatchcase(path, pattern) for files in rows for pattern in files):
        return f"may not include <{outside}>: only {', '.join(rows[0])}"
    return None


def violations(root):
    """Every wrong #include below `root`, as "file:line: what"."""
    found = []
    for tree in TREES:
        for file in sorted((root / tree).rglob("*")):
            if file.suffix not in SUFFIXES or not file.is_file():
                continue
            path = file.relative_to(root).as_posix()
            text = re.sub(r"/\*.*?\*/", lambda comment: "\n" * comment[0].count("\n"), file.read_text(), flags=re.DOTALL)
            for match in INCLUDE.finditer(text):
                wrong = check_include(root, path, *match.groups())
                if wrong:
                    found.append(f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {wrong}")
    return found


def python_imports(folder):
    """Module -> the modules of the same package that it imports, those for type checkers alone among them."""
    imports = {}
    for file in sorted(folder.glob("*.py")):
        found = re.findall(r"^\s*from \.(\w*) import (.+)", file.read_text(), re.MULTILINE)
        imports[file.stem] = {module or name.strip() for module, names in found for name in names.split(",")}
    return imports


def circle_in(imports):
    """What is left when modules are taken away whose own imports are all gone: empty where there is no circle."""
    left = {module: set(others) & imports.keys() for module, others in imports.items()}
    while gone := {module for module, others in left.items() if not others}:
        left = {module: others - gone for module, others in left.items() if module not in gone}
    return sorted(left)


def includes_by_file(root, trees=TREES):
    """File -> those of our own that it includes."""
    return {file.relative_to(root).as_posix(): {ours for ours, _, _ in INCLUDE.findall(file.read_text()) if ours}
            for tree in trees for file in sorted((root / tree).rglob("*")) if file.suffix in SUFFIXES}


def includes_by_folder(by_file):
    """Folder -> the others that its C++ files include: shaders see the device's, which is a storey above some."""
    folders = {}
    for file, others in by_file.items():
        folder = os.path.dirname(file)
        mine = folders.setdefault(folder, set())
        if pathlib.PurePosixPath(file).suffix not in SHADERS:
            mine |= {os.path.dirname(other) for other in others} - {folder}
    return folders


def drawing(graph):
    arrows = (f'  "{one}" -> "{other}";' for one, others in sorted(graph.items()) for other in sorted(others))
    return "\n".join(["digraph includes {", "  rankdir=BT;", *arrows, "}"])


class Circles(unittest.TestCase):
    def test_no_file_includes_what_includes_it(self):
        by_file = includes_by_file(SOURCE)
        self.assertGreater(sum(map(len, by_file.values())), 2000)
        self.assertEqual(circle_in(by_file), [])

    def test_no_folder_of_the_renderer_includes_what_includes_it(self):
        by_folder = includes_by_folder(includes_by_file(SOURCE, ["renderer"]))
        by_folder.pop("renderer", None)  # precompiled.h, which the build alone includes
        self.assertGreater(len(by_folder), 15)
        self.assertEqual(circle_in(by_folder), [])


class PythonPackage(unittest.TestCase):
    def test_no_module_imports_what_imports_it(self):
        imports = python_imports(SOURCE / "clients/python/photond")
        self.assertGreater(sum(map(len, imports.values())), 50)
        self.assertEqual(circle_in(imports), [])

    def test_a_circle_would_be_found(self):
        self.assertEqual(circle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}), ["a", "b", "c"])


class IncludeRules(unittest.TestCase):
    def test_every_include_keeps_to_the_table(self):
        self.assertEqual(violations(SOURCE), [])

    def test_there_is_something_to_check(self):
        counted = sum(len(INCLUDE.findall(file.read_text()))
                      for tree in TREES for file in (SOURCE / tree).rglob("*.h"))
        self.assertGreater(counted, 100)

    def test_what_the_renderer_sees_of_the_protocol_is_standard_library_only(self):
        for header in PLAIN_PROTOCOL:
            for ours, outside, _ in INCLUDE.findall((SOURCE / header).read_text()):
                self.assertTrue(not ours and STANDARD.fullmatch(outside), f"{header} includes {ours or outside}")


# File, its #include, and whether the table permits it. Every row of both tables is refused here at least once.
PLANTED = [
    ("protocol/a.h", '"renderer/core/b.h"', False),
    ("protocol/a.h", '"server/b.h"', False),
    ("protocol/a.h", "<nlohmann/json.hpp>", True),
    ("protocol/a.h", "<spdlog/spdlog.h>", False),
    ("renderer/core/a.h", '"renderer/scene/b.h"', False),
    ("renderer/core/a.h", '"protocol/error.h"', True),
    ("renderer/core/a.h", '"protocol/job.h"', False),
    ("renderer/core/a.h", "<nlohmann/json.hpp>", False),
    ("renderer/core/a.h", "<tbb/parallel_for.h>", True),
    ("renderer/core/a.h", "<sys/mman.h>", True),
    ("renderer/core/a.h", "<openssl/evp.h>", False),
    ("renderer/core/sha256.cpp", "<openssl/evp.h>", True),
    ("renderer/scene/a.h", '"renderer/transport/b.h"', False),
    ("renderer/scene/a.h", '"renderer/backends/cpu/b.h"', False),
    ("renderer/scene/a.cpp", "<tiny_gltf.h>", False),
    ("renderer/scene/a.cpp", "<meshoptimizer.h>", False),
    ("renderer/scene/texture.cpp", "<OpenImageIO/imageio.h>", False),
    ("renderer/scene/texture_codec.cpp", "<OpenImageIO/imageio.h>", True),
    ("renderer/scene/a.cpp", "<embree3/rtcore.h>", False),
    ("renderer/film/a.h", '"renderer/scene/b.h"', False),
    ("renderer/error/a.h", '"renderer/film/b.h"', False),
    ("renderer/transport/a.h", '"renderer/scene/b.h"', True),
    ("renderer/transport/a.h", '"renderer/frame/method.h"', False),
    ("renderer/transport/a.h", '"renderer/backends/cpu/b.h"', False),
    ("renderer/transport/a.h", "<nanoflann.hpp>", False),
    ("renderer/backends/cpu/a.cpp", "<embree3/rtcore.h>", True),
    ("renderer/backends/cpu/a.cpp", '"renderer/backends/gpu/b.h"', False),
    ("renderer/backends/cpu/a.cpp", '"renderer/transport/b.h"', False),
    ("renderer/backends/cpu/a.cpp", "<vulkan/vulkan.h>", False),
    ("renderer/backends/cpu/a.cpp", "<volk.h>", False),
    ("renderer/backends/cpu/a.cpp", "<glslang/Include/glslang_c_interface.h>", False),
    ("renderer/backends/gpu/a.cpp", "<spirv-tools/optimizer.hpp>", False),
    ("renderer/backends/gpu/shader_specialization.cpp", "<spirv-tools/optimizer.hpp>", True),
    ("renderer/transport/a.glsl", '"renderer/backends/gpu/b.glsl"', True),
    ("renderer/transport/a.glsl", '"renderer/methods/b.glsl"', False),
    ("renderer/scene/a.glsl", '"renderer/transport/b.glsl"', False),
    ("renderer/backends/gpu/a.cpp", "<volk.h>", True),
    ("renderer/backends/gpu/a.h", '"renderer/transport/b.h"', True),
    ("renderer/backends/gpu/a.h", '"renderer/photons/b.h"', False),
    ("renderer/backends/gpu/a.h", '"renderer/backends/cpu/b.h"', False),
    ("renderer/backends/gpu/bvh_build.cpp", "<embree3/rtcore.h>", True),
    ("renderer/backends/gpu/a.cpp", "<embree3/rtcore.h>", False),
    ("renderer/photons/a.h", '"renderer/many_lights/b.h"', False),
    ("renderer/gbuffer/a.h", '"renderer/backends/cpu/b.h"', False),
    ("renderer/many_lights/a.h", '"renderer/backends/gpu/b.h"', True),
    ("renderer/photons/a.h", '"renderer/voxels/b.h"', False),
    ("renderer/frame/a.h", '"renderer/photons/b.h"', False),
    ("renderer/frame/a.h", '"renderer/backends/gpu/b.h"', True),
    ("renderer/eye/a.h", '"renderer/gbuffer/b.h"', False),
    ("renderer/eye/a.h", '"renderer/frame/b.h"', True),
    ("renderer/gbuffer/a.h", '"renderer/many_lights/b.h"', False),
    ("renderer/gbuffer/a.h", '"renderer/eye/b.h"', True),
    ("renderer/many_lights/a.h", '"renderer/photons/b.h"', True),
    ("renderer/many_lights/a.h", '"renderer/methods/registry.h"', False),
    ("renderer/gathering/a.h", '"renderer/methods/one/b.h"', False),
    ("renderer/splats/a.h", '"renderer/methods/one/b.h"', False),
    ("renderer/splats/a.h", '"renderer/eye/b.h"', True),
    ("renderer/gathering/a.h", '"renderer/photons/b.h"', True),
    ("renderer/eye/a.h", '"renderer/gathering/b.h"', False),
    ("renderer/gathering/a.h", '"renderer/progressive/b.h"', False),
    ("renderer/progressive/a.h", '"renderer/methods/one/b.h"', False),
    ("renderer/progressive/a.h", '"renderer/gathering/b.h"', True),
    ("renderer/progressive/a.h", '"renderer/bidirectional/b.h"', False),
    ("renderer/bidirectional/a.h", '"renderer/methods/one/b.h"', False),
    ("renderer/bidirectional/a.h", '"renderer/progressive/b.h"', True),
    ("renderer/voxels/a.h", '"renderer/frame/method.h"', False),
    ("renderer/methods/one/a.h", '"renderer/methods/two/b.h"', False),
    ("renderer/methods/one/a.h", '"renderer/methods/one/b.h"', True),
    ("renderer/methods/one/a.h", '"renderer/frame/method.h"', True),
    ("renderer/methods/one/a.h", '"renderer/film/b.h"', True),
    ("renderer/methods/one/a.h", '"renderer/methods/registry.h"', False),
    ("renderer/methods/registry.h", '"renderer/methods/one/b.h"', False),
    ("renderer/methods/registry.h", '"renderer/photons/b.h"', False),
    ("renderer/methods/stray.h", '"renderer/core/b.h"', False),
    ("renderer/methods/one/a.h", '"protocol/job.h"', False),
    ("renderer/methods/one/a.h", "<embree3/rtcore.h>", False),
    ("renderer/methods/one/a.h", "<tbb/parallel_for.h>", False),
    ("renderer/frame/method.h", '"renderer/methods/one/b.h"', False),
    ("renderer/methods/registry.cpp", '"renderer/methods/registry.h"', True),
    ("renderer/methods/registry.cpp", '"renderer/methods/one/b.h"', False),
    ("renderer/methods/registry.h", '"renderer/frame/method_info.h"', True),
    ("server/a.cpp", '"renderer/methods/one/b.h"', False),
    ("server/a.cpp", '"renderer/methods/registry.h"', True),
    ("server/a.cpp", '"renderer/frame/piece_queue.h"', False),
    ("server/a.cpp", '"renderer/transport/b.h"', False),
    ("server/a.cpp", '"clients/cli/b.h"', False),
    ("server/a.cpp", "<httplib.h>", False),
    ("server/a.cpp", "<openssl/rand.h>", False),
    ("server/a.cpp", "<CLI/CLI.hpp>", False),
    ("server/a.cpp", "<prometheus/counter.h>", False),
    ("server/a.cpp", "<zip.h>", False),
    ("server/a.cpp", "<seccomp.h>", False),
    ("server/routes/a.cpp", "<httplib.h>", True),
    ("server/routes/a.cpp", "<sqlite3.h>", False),
    ("server/store/a.cpp", "<sqlite3.h>", True),
    ("server/worker/a.cpp", '"renderer/methods/one/b.h"', False),
    ("server/worker/a.cpp", '"renderer/backends/cpu/b.h"', True),
    ("server/worker/a.cpp", "<OpenImageIO/imageio.h>", False),
    ("clients/cli/a.cpp", '"protocol/job.h"', True),
    ("clients/cli/a.cpp", '"renderer/core/b.h"', False),
    ("clients/cli/a.cpp", '"server/b.h"', False),
    ("clients/cli/a.cpp", '"clients/other/b.h"', False),
    ("clients/cli/a.cpp", "<httplib.h>", False),
    ("clients/cli/a.cpp", "<glm/glm.hpp>", False),
    ("clients/cli/http_client.cpp", "<httplib.h>", True),
    ("renderer/core/a.h", "<boost/any.hpp>", False),
    ("renderer/core/a.h", '"b.h"', False),
    ("renderer/core/a.h", '"../core/b.h"', False),
    ("renderer/core/a.h", "SOME_HEADER", False),
    ("renderer/unknown/a.h", '"renderer/core/b.h"', False),
]


class PlantedIncludes(unittest.TestCase):
    """The test of the test."""

    def planted(self, file, include):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            target = include.strip('"')
            if include.startswith('"') and "/" in target and ".." not in target:
                (root / target).parent.mkdir(parents=True, exist_ok=True)
                (root / target).write_text("")
            (root / file).parent.mkdir(parents=True, exist_ok=True)
            (root / file).write_text(f"#pragma once\n// a comment\n  #  include {include}\n")
            return violations(root)

    def test_each_planted_include_is_judged_rightly(self):
        for file, include, permitted in PLANTED:
            with self.subTest(file=file, include=include):
                found = self.planted(file, include)
                if permitted:
                    self.assertEqual(found, [])
                else:
                    self.assertEqual(len(found), 1, found)
                    self.assertTrue(found[0].startswith(f"{file}:3: "), found)

    def test_every_row_has_a_planted_violation(self):
        refused = [(file, include) for file, include, permitted in PLANTED if not permitted]
        for files, _ in MAY_INCLUDE:
            self.assertTrue(any(fits(files, file) and include.startswith('"') for file, include in refused), files)
        for header, _ in LIBRARIES:
            self.assertTrue(any(fnmatch.fnmatchcase(include.strip("<>"), header) for _, include in refused), header)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--draw"]:
        files = includes_by_file(SOURCE, ["renderer"])
        print(drawing(files if sys.argv[2:] == ["files"] else includes_by_folder(files)))
    else:
        unittest.main()
