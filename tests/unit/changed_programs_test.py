"""What `tests/run --changed` chooses: every file is known to the graph of files or to the table tests/reach.txt, the table
names only what is there, and planted changes choose what they must.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

from changed_files import NO_COMMIT, NoBase, Repository  # noqa: E402
from changed_programs import Reach, reach_of_tree  # noqa: E402
from file_graph import ROOT, FileGraph  # noqa: E402
from reach_table import EVERYTHING, NOTHING, expand, read_table, table_of  # noqa: E402

RULES = {"unit.include_rules_test", "unit.said_once_test", "unit.file_names_test", "unit.repeated_lines_test",
         "unit.changed_programs_test"}
REACH = reach_of_tree()


def chosen(*names):
    return set(REACH.of_all(names))


class Table(unittest.TestCase):
    def test_every_file_of_the_repository_is_known(self):
        known = REACH.graph.reached_from(REACH.sources)
        for row in REACH.rows:
            if not row.for_every_change:
                known |= set(expand(row.left, REACH.files))
        self.assertGreater(len(REACH.files), 2000)
        self.assertEqual(sorted(set(REACH.files) - known), [])

    def test_every_entry_that_is_named_exists(self):
        for row in REACH.rows:
            for word in set(row.right) - {EVERYTHING, NOTHING}:
                self.assertTrue(expand([word], REACH.entries), f"reach.txt:{row.line}: {word}")

    def test_every_pattern_fits_a_file(self):
        for row in table_of():
            for pattern in row.left if row.chooses else row.left + row.right:
                self.assertTrue(expand([pattern], REACH.files), f"reach.txt:{row.line}: {pattern}")

    def test_the_entries_are_those_of_ctest(self):
        listed = pathlib.Path(os.environ.get("PHOTOND_BIN", "build/bin")).parent / "tests/CTestTestfile.cmake"
        if not listed.exists():
            self.skipTest(f"there is no {listed}")
        entries = {name for name in re.findall(r"^add_test\([\[=]*([\w.]+)", listed.read_text(), re.MULTILINE)
                   if not name.startswith("long.")}
        if "PHOTOND_UNDER_SANITIZER" in os.environ:  # whose builds leave statistics and browsers out
            self.assertEqual(entries - REACH.of_ctest(REACH.entries), set())
        else:
            self.assertEqual(entries, REACH.of_ctest(REACH.entries))

    def test_a_line_that_is_no_row_is_refused(self):
        for line in ("a/*.h", "a -> b -> c", "-> b", "a uses", "a -> b uses c"):
            with self.assertRaises(ValueError, msg=line):
                read_table(line)


class PlantedChanges(unittest.TestCase):
    def test_a_change_of_nothing_chooses_nothing(self):
        self.assertEqual(chosen(), set())

    def test_a_file_that_nobody_knows_chooses_everything(self):
        for name in ("renderer/nowhere.xyz", "new_folder/file.cpp", "tests/data/new.bin"):
            self.assertEqual(chosen(name), REACH.entries.keys(), name)

    def test_what_all_programs_are_built_with_chooses_everything(self):
        for name in ("CMakeLists.txt", "tests/CMakeLists.txt", "renderer/precompiled.h", "tests/support/test_main.cpp"):
            self.assertEqual(chosen(name), REACH.entries.keys(), name)

    def test_the_room_of_a_method(self):
        names = chosen("renderer/methods/photon_splatting/photon_splatting.cpp")
        self.assertLessEqual(RULES | {"unit.photon_splatting", "unit.gpu_photon_splatting", "statistical.photon_splatting",
                                      "statistical.gpu_photon_splatting", "hard_cases.hard_cases_test", "unit.methods",
                                      "service.photon_splatting_test", "service.thesis_preset_test"}, names)
        for name in ("unit.voxels", "unit.photon_mapping", "unit.cli", "service.api_test", "service.svo_preset_test"):
            self.assertNotIn(name, names)
        self.assertFalse([name for name in names if name.startswith("dashboard.")])

    def test_every_method_is_judged_from_outside(self):
        for room, row in REACH.graph.rooms.items():
            names = chosen(row)
            self.assertIn("unit.methods", names, room)
            self.assertTrue([name for name in names if name.startswith(("service.", "hard_cases."))], room)

    def test_what_a_method_declares_reaches_the_scripts_that_name_it(self):
        names = chosen("renderer/methods/photon_splatting/params.h")
        self.assertLessEqual({"service.openapi_test", "service.older_versions_test", "dashboard.render"}, names)
        self.assertNotIn("service.older_versions_test", chosen("renderer/methods/photon_splatting/splat_depth.comp"))

    def test_what_all_renderers_stand_on_chooses_nearly_all(self):
        names = chosen("renderer/core/rng.h")
        self.assertGreater(len(names), 0.8 * len(REACH.entries))
        self.assertLessEqual({name for name in REACH.entries if name.startswith("statistical.")}, names)

    def test_a_shader_chooses_the_programs_of_the_gpu(self):
        names = chosen("renderer/methods/photon_splatting/splat_gain.glsl")
        self.assertLessEqual({"unit.gpu_photon_splatting", "statistical.gpu_photon_splatting"}, names)
        self.assertFalse({"unit.photon_splatting", "statistical.photon_splatting", "unit.gpu_voxels"} & names)

    def test_a_header_that_c_and_shaders_share(self):
        names = chosen("renderer/voxels/svo_shared.h")
        self.assertLessEqual({"unit.gpu_voxels", "unit.gpu_svo_many_lights"}, names)
        self.assertFalse({"unit.gpu_photon_mapping", "unit.cli"} & names)

    def test_a_header_of_the_tests_chooses_who_includes_it(self):
        names = chosen("tests/support/statistics.h")
        self.assertLessEqual({"unit.core", "statistical.transport"}, names)
        self.assertFalse({"unit.film", "unit.server", "service.api_test"} & names)

    def test_a_library_below_the_programs(self):
        names = chosen("server/routes/comparisons.cpp")
        self.assertLessEqual({"service.comparisons_test", "dashboard.study"}, names)
        self.assertFalse({"service.worker_test", "unit.photons", "unit.worker"} & names)
        names = chosen("clients/cli/text_table.cpp")
        self.assertLessEqual({"unit.cli", "service.photonctl_test", "hard_cases.hard_cases_test"}, names)
        self.assertFalse({"service.api_test", "unit.server"} & names)

    def test_a_room_of_the_dashboard(self):
        names = chosen("clients/dashboard/src/scenes/orbit.ts")
        self.assertLessEqual({"dashboard.scenes", "dashboard.logic", "dashboard.types"}, names)
        self.assertFalse({"dashboard.jobs", "service.api_test", "unit.server"} & names)
        shared = chosen("clients/dashboard/src/ui/dialog.tsx")
        self.assertLessEqual({"dashboard.scenes", "dashboard.jobs", "dashboard.study"}, shared)
        self.assertLessEqual({name for name in REACH.entries if name.startswith("dashboard.")} - {"dashboard.packages"},
                             chosen("clients/dashboard/src/app/shell.tsx"))

    def test_scripts_choose_who_imports_them(self):
        self.assertEqual(chosen("tests/service/api_test.py") - RULES,
                         {"service.api_test", "service.http_load_test", "service.job_priority_test", "service.status_test"})
        self.assertEqual(chosen("tests/dashboard/tiny_glb.mjs") - RULES,
                         {"dashboard.render", "dashboard.scenes", "dashboard.widths"})
        self.assertIn("service.python_client_test", chosen("clients/python/photond/bias.py"))

    def test_texts(self):
        self.assertEqual(chosen("ARCHITECTURE.md"), RULES)
        self.assertEqual(chosen("docs/operating.md"), RULES | {"service.operating_guide_test"})

    def test_a_test_that_is_gone_chooses_the_rest_of_its_program(self):
        rest = Reach(["tests/unit/a/one_test.cpp"], {}, [], ["tests/unit/a/two_test.cpp", "tests/unit/b/one_test.cpp"])
        self.assertEqual(rest.of("tests/unit/a/two_test.cpp").keys(), {"unit.a"})
        self.assertEqual(rest.of("tests/unit/b/one_test.cpp").keys(), set())

    def test_each_planted_defect_chooses_what_catches_it(self):
        patches = [name for name in REACH.files if re.fullmatch(r"tests/defects/\w+\.patch", name)]
        if not patches:
            self.skipTest("there are none")
        for name in patches:
            text = (ROOT / name).read_text()
            catches = re.search(r"^Caught by: (\S+)", text, re.MULTILINE)[1]
            names = chosen(*re.findall(r"^\+\+\+ b/(\S+)", text, re.MULTILINE))
            self.assertIn(catches, names | REACH.of_ctest(names), name)

    def test_browser_tests_that_one_program_runs(self):
        files = ["tests/dashboard/a.test.mjs", "tests/dashboard/b.test.mjs", "tests/unit/x/x_test.cpp"]
        alone = Reach(files, {}, [])
        self.assertEqual(alone.of_ctest(alone.entries), {"dashboard.a", "dashboard.b", "unit.x"})
        self.assertEqual(alone.cases(["dashboard.a"]), [])
        together = Reach([*files, "tests/dashboard/run_tests.mjs"], {}, [])
        self.assertEqual(together.of_ctest(together.entries), {"dashboard.browser", "unit.x"})
        self.assertEqual(together.cases(["dashboard.b", "unit.x"]), ["b", "*-*Long*"])
        self.assertEqual(together.cases(["unit.x"]), [])
        self.assertEqual(together.cases(together.entries), [])

    def test_what_must_be_built(self):
        self.assertEqual(REACH.targets("unit.gpu_voxels"), {"unit_gpu_voxels"})
        self.assertEqual(set().union(*map(REACH.targets, RULES)), set())
        self.assertEqual(REACH.targets("service.api_test"), {"photond", "photond-worker"})
        self.assertEqual(REACH.targets("service.worker_test"), {"photond-worker"})
        self.assertEqual(REACH.targets("service.gpu_bench_test"), {"photond-gpu-bench"})
        self.assertEqual(REACH.targets("hard_cases.hard_cases_test"), {"photond", "photond-worker", "photonctl"})
        self.assertIn("photond_vulkan_fault_layer", REACH.targets("service.gpu_faults_test"))


class Graph(unittest.TestCase):
    """The edges of small trees."""

    def takes(self, texts, name):
        return FileGraph(texts, texts).takes[name]

    def test_a_header_takes_the_sources_that_define_what_it_declares(self):
        texts = {"a/x.h": "class X {\n    void go();\n};\nint free(int);\nclass Other;\n", "b/far.h": "int free(int);\n",
                 "a/x.cpp": '#include "a/x.h"\n', "a/part.h": '#include "a/x.h"\n'}
        for text, takes in (('#include "a/x.h"\nvoid X::go() {', True), ('#include "a/part.h"\nint free(int i) {', True),
                            ('#include "a/x.h"\nint other() { return free(1); }', False), ("int free(int i) {", False),
                            ('#include "a/x.h"\nvoid Other::go() {', False)):
            taken = self.takes(texts | {"a/y.cpp": text}, "a/x.h")
            self.assertEqual(taken, {"a/x.cpp", "a/y.cpp"} if takes else {"a/x.cpp"}, text)
        self.assertEqual(self.takes(texts | {"a/y.cpp": '#include "b/far.h"\nint free(int i) {'}, "b/far.h"), set())

    def test_includes_of_shaders_and_of_code(self):
        texts = {"a/x.cpp": '#include "a/x.h"\n', "a/x.h": '#include "a/y.glsl"\n#include <vector>\n', "a/y.glsl": ""}
        self.assertEqual(FileGraph(texts, texts).reached_from(["a/x.cpp"]), texts.keys())
        self.assertEqual(self.takes(texts, "a/x.h"), {"a/y.glsl", "a/x.cpp"})

    def test_shaders_are_named_whole_by_their_names_or_by_how_their_paths_begin(self):
        texts = {"renderer/a/one.comp": "", "renderer/a/two_x.comp": "", "renderer/a/two_y.frag": "", "renderer/b/three.vert": ""}
        for literal, found in (('"renderer/a/one.comp"', {"renderer/a/one.comp"}), ('"three.vert"', {"renderer/b/three.vert"}),
                               ('"renderer/a/two_"', {"renderer/a/two_x.comp", "renderer/a/two_y.frag"}), ('"ne.comp"', set()),
                               ('"renderer/a/"', set())):
            source = {"renderer/a/s.cpp": f"f({literal});"}
            self.assertEqual(self.takes(texts | source, "renderer/a/s.cpp"), found, literal)

    def test_a_method_that_is_named_counts_beside_the_registry(self):
        rooms = {"renderer/methods/m/row.cpp": "", "renderer/methods/n/row.cpp": "", "renderer/methods/registry.h": "",
                 "renderer/methods/registry.cpp": '#include "renderer/methods/registry.h"'}
        asks = '#include "renderer/methods/registry.h"\n'
        for text, found in ((asks + 'find_method("m")', {"m"}), ('f("m")', set()), (asks + "all_methods()", {"m", "n"})):
            texts = rooms | {"tests/unit/a/a_test.cpp": text}
            self.assertEqual({name.split("/")[2] for name in self.takes(texts, "tests/unit/a/a_test.cpp")
                              if name.endswith("row.cpp")}, found, text)

    def test_imports(self):
        texts = {"tests/service/a_test.py": "import helper, os\nfrom other import x\nimport photond\n",
                 "tests/support/helper.py": 'run("photond-worker")', "tests/support/other.py": "",
                 "server/worker/worker_main.cpp": "", "clients/python/photond/__init__.py": "from .shape import y\nfrom . import work\n",
                 "clients/python/photond/shape.py": "", "clients/python/photond/work.py": "", "clients/python/photond/alone.py": ""}
        self.assertEqual(texts.keys() - FileGraph(texts, texts).reached_from(["tests/service/a_test.py"]),
                         {"clients/python/photond/alone.py"})
        texts = {"a/one.tsx": 'import "./one.css";\nimport { x } from "../b/two";\nimport { y } from "preact";\n', "a/one.css": "",
                 "b/two.ts": 'export { z } from "./three";\nvoid import("./four");\n', "b/three.ts": "", "b/four.tsx": ""}
        self.assertEqual(FileGraph(texts, texts).reached_from(["a/one.tsx"]), texts.keys())


@unittest.skipUnless(shutil.which("git"), "there is no git")
class ChangedFiles(unittest.TestCase):
    """What differs from which commit, in a repository of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def git(self, *arguments):
        return subprocess.run(["git", "-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false", *arguments],
                              cwd=self.root, check=True, capture_output=True, text=True).stdout.strip()

    def commit(self, **files):
        for name, text in files.items():
            (self.root / name).write_text(text)
        self.git("add", "-A")
        self.git("commit", "-q", "--allow-empty", "-m", "m")
        return self.git("rev-parse", "HEAD")

    def test_a_tree_without_a_repository_is_refused(self):
        with self.assertRaisesRegex(NoBase, "is no git repository"):
            Repository(self.root)

    def test_a_branch_is_compared_with_where_it_left_the_main_branch(self):
        self.git("init", "-q", "-b", "main")
        left = self.commit(kept="a", changed="a", gone="was here")
        self.git("checkout", "-q", "-b", "work")
        self.commit(committed="a")
        self.git("checkout", "-q", "main")
        self.commit(elsewhere="a")
        self.git("checkout", "-q", "work")
        (self.root / "changed").write_text("b")
        (self.root / "staged").write_text("b")
        self.git("add", "staged")
        (self.root / "not tracked").write_text("b")
        (self.root / "gone").unlink()
        repository = Repository(self.root)
        base, reason = repository.base()
        self.assertEqual((base, reason), (left, "the merge base with main"))
        changed = repository.files_since(base)
        self.assertEqual(changed, ["changed", "committed", "gone", "not tracked", "staged"])
        self.assertEqual(repository.texts_gone_since(base, changed), {"gone": "was here"})
        self.assertEqual(repository.base("HEAD")[0], self.git("rev-parse", "HEAD"))
        with self.assertRaisesRegex(NoBase, "no commit nosuch"):
            repository.base("nosuch")

    def test_the_main_branch_alone_is_compared_with_the_commit_before(self):
        self.git("init", "-q", "-b", "main")
        first = self.commit(a="a")
        self.assertEqual(Repository(self.root).base(), (NO_COMMIT, "the commit before HEAD, for there is no other branch to compare with"))
        self.assertEqual(Repository(self.root).files_since(NO_COMMIT), ["a"])
        self.commit(b="b")
        self.assertEqual(Repository(self.root).base()[0], first)

    def test_the_main_branch_is_compared_with_what_was_pushed(self):
        self.git("init", "-q", "-b", "main")
        first = self.commit(a="a")
        pushed = self.commit(b="b")
        self.git("update-ref", "refs/remotes/origin/main", pushed)
        repository = Repository(self.root)
        self.assertEqual(repository.base(), (first, "the commit before HEAD, for HEAD is part of origin/main"))
        (self.root / "c").write_text("c")
        self.assertEqual(repository.base(), (pushed, "the merge base with origin/main"))
        self.commit(d="d")
        self.assertEqual(repository.base(), (pushed, "the merge base with origin/main"))


if __name__ == "__main__":
    unittest.main()
