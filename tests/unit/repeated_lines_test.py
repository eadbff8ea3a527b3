"""No six lines of code stand twice in renderer/ and server/: what is needed twice is a function, a class or an included
file. Comments, spaces, includes and lines of mere punctuation do not count. Twins are exempt: what a C++ file and a shader
say alike is one idea for two compilers.
"""

import collections
import itertools
import os
import pathlib
import re
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
TREES = ("renderer", "server")
SHADERS = {".glsl", ".comp", ".vert", ".frag"}
SUFFIXES = {".h", ".cpp"} | SHADERS
MOST_EQUAL = 5
# What every file of a kind begins with, what divides a class, and what is no word.
IDLE = re.compile(r"#\s*(include|version|extension|pragma|endif|else)\b.*|(public|private|protected):|else|namespace\b.*|\W*")


def code_lines(text):
    """(number, line) of the lines that say something, spaces and comments taken out."""
    text = re.sub(r"/\*.*?\*/", lambda comment: "\n" * comment[0].count("\n"), text, flags=re.DOTALL)
    lines = ((number, " ".join(re.sub(r"//.*", "", line).split())) for number, line in enumerate(text.split("\n"), 1))
    return [(number, line) for number, line in lines if not IDLE.fullmatch(line)]


def are_twins(one, other):
    return (pathlib.PurePath(one).suffix in SHADERS) != (pathlib.PurePath(other).suffix in SHADERS)


def repetitions(root):
    """Pairs of places that begin more than MOST_EQUAL equal lines: "file:line ~ file:line"."""
    places = collections.defaultdict(list)
    for tree in TREES:
        for file in sorted((root / tree).rglob("*")):
            if file.suffix not in SUFFIXES:
                continue
            lines = code_lines(file.read_text())
            for first in range(len(lines) - MOST_EQUAL):
                window = tuple(line for _, line in lines[first:first + MOST_EQUAL + 1])
                places[window].append((file.relative_to(root).as_posix(), lines[first][0]))
    return sorted(f"{one}:{line} ~ {other}:{other_line}" for found in places.values()
                  for (one, line), (other, other_line) in itertools.combinations(found, 2) if not are_twins(one, other))


class RepeatedLines(unittest.TestCase):
    def test_nothing_is_written_twice(self):
        self.assertEqual(repetitions(SOURCE), [])


class PlantedRepetitions(unittest.TestCase):
    """The test of the test."""

    SIX = ["int a = 1;", "int b = a + 1;", "call(a, b);", "if (b) call(b, a);", "for (;;) wait();", "return a;"]

    def planted(self, one, other, names=("renderer/core/a.cpp", "server/b.cpp")):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, lines in zip(names, (one, other)):
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text("\n".join(lines))
            return repetitions(root)

    def test_six_equal_lines_are_found_whatever_stands_between(self):
        other = [part for line in self.SIX for part in ("   // why", f"\t{line.replace(' ', '  ')}  // so", "}", "")]
        self.assertEqual(self.planted(self.SIX, other), ["renderer/core/a.cpp:1 ~ server/b.cpp:2"])

    def test_five_are_not(self):
        self.assertEqual(self.planted(self.SIX[:5], self.SIX[:5]), [])

    def test_a_file_is_compared_with_itself_too(self):
        self.assertEqual(len(self.planted([*self.SIX, "int other;", *self.SIX], [])), 1)

    def test_twins_and_preambles_are_exempt(self):
        self.assertEqual(self.planted(self.SIX, self.SIX, ("renderer/a.h", "renderer/a.glsl")), [])
        preamble = ["#pragma once", *(f'#include "{name}.h"' for name in "abcdefg"), "namespace photond {", "public:"]
        self.assertEqual(self.planted(preamble, preamble), [])


if __name__ == "__main__":
    unittest.main()
