"""What a method, a layer and an error measure are is said in one place and travels on the wire from there: whoever adds
one touches its own files and no list elsewhere (CONTRIBUTING.md, "To add something"). Comments do not count.
"""

import os
import pathlib
import re
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
TREES = ("renderer", "server", "protocol", "clients")
SUFFIXES = {".h", ".cpp", ".glsl", ".comp", ".vert", ".frag", ".ts", ".tsx", ".py"}
# Path tracing is the reference that every part may name. These are presets, and examples in help and documentation.
REFERENCE = "path_tracing"
CHOOSE_METHODS = ("clients/cli/compare_preset", "clients/dashboard/src/studies/plan.ts", "clients/cli/compare_command.cpp",
                  "clients/cli/hard_cases_command.cpp", "clients/python/")
# The parts of the beauty, and what the film makes of the passes: every film has them.
LAYERS_OF_ALL = {"Emitted", "Direct", "Indirect", "StandardError"}
# Who fills layers, and the way back from the device, where positions get the scene's origin.
FILL_LAYERS = ("renderer/film/layers.h", "renderer/eye/", "renderer/gbuffer/", "renderer/many_lights/", "renderer/gathering/",
               "renderer/progressive/", "renderer/bidirectional/", "renderer/methods/")
FILL_ONE_LAYER = {("renderer/frame/device_image.cpp", "Position")}
# Measures that are sums over pixels like any other: nobody outside asks for them by number.
PLAIN_METRICS = ("Mse", "Mae", "Smape", "Rmse8bit", "FittedRmse", "FittedRelativeMse")


def code_of(file):
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        return re.sub(r"#.*", "", text)
    return re.sub(r"#include.*|//.*", "", re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL))


def sources(root):
    for tree in TREES:
        for file in sorted((root / tree).rglob("*")):
            name = file.relative_to(root).as_posix()
            if file.suffix in SUFFIXES and "node_modules" not in name and ".test" not in name:
                yield name, code_of(file)


def faults(root):
    """"file names what" for each place that names what it should not know."""
    rooms = [row.parent.name for row in sorted((root / "renderer/methods").glob("*/row.cpp")) if row.parent.name != REFERENCE]
    found = []
    for name, code in sources(root):
        for room in rooms:
            own = name.startswith(f"renderer/methods/{room}/") or name == "renderer/methods/registry.cpp"
            if not own and not name.startswith(CHOOSE_METHODS) and re.search(rf"\b{room}\b", code):
                found.append(f"{name} names the method {room}")
        if not name.startswith(FILL_LAYERS):
            for layer in sorted(set(re.findall(r"\bLayer::([A-Z]\w+)", code)) - LAYERS_OF_ALL):
                if (name, layer) not in FILL_ONE_LAYER:
                    found.append(f"{name} names the layer {layer}")
        if not name.startswith("renderer/error/"):
            found += [f"{name} names the metric {metric}" for metric in PLAIN_METRICS
                      if re.search(rf"\bMetric::{metric}\b", code)]
    return found


class SaidOnceTest(unittest.TestCase):
    def test_nobody_knows_a_method_layer_or_measure_but_its_own_files(self):
        self.assertEqual(faults(SOURCE), [])

    def test_there_is_something_to_look_at(self):
        self.assertGreater(len(list((SOURCE / "renderer/methods").glob("*/row.cpp"))), 5)
        self.assertGreater(sum("Layer::" in code for _, code in sources(SOURCE)), 20)

    def test_planted_faults_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            files = {
                "renderer/methods/glow/row.cpp": "// room of glow\nMethodInfo glow_row();",
                "renderer/methods/registry.cpp": "METHOD(glow)",
                "renderer/methods/path_tracing/row.cpp": "glow",
                "renderer/eye/eye.h": "image.of<Layer::Albedo>()",
                "renderer/film/film.cpp": "keep(Layer::Albedo); keep(Layer::Direct);  // not Layer::Depth",
                "server/list.cpp": 'name == "glow"; Metric::Mae; Metric::RelativeMse',
                "clients/cli/compare_preset_glow.cpp": '"glow"',
                "clients/dashboard/src/form.ts": "// glow\nconst lines = { glow: 1 };",
                "protocol/job.cpp": 'name == "path_tracing"',
            }
            for name, text in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text, encoding="utf-8")
            self.assertEqual(sorted(faults(root)), [
                "clients/dashboard/src/form.ts names the method glow",
                "renderer/film/film.cpp names the layer Albedo",
                "renderer/methods/path_tracing/row.cpp names the method glow",
                "server/list.cpp names the method glow",
                "server/list.cpp names the metric Mae",
            ])


if __name__ == "__main__":
    unittest.main()
