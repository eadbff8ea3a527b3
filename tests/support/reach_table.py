"""The table tests/reach.txt: which entries of ctest a change of a file chooses, and which files use which others, where the
graph of files cannot see it."""

import dataclasses
import fnmatch
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
EVERYTHING, NOTHING = "everything", "nothing"


def expand(patterns, names):
    """The names that one of the patterns fits, each pattern's in its order."""
    found = {}
    for pattern in patterns:
        expression = re.compile(fnmatch.translate(pattern))
        found |= dict.fromkeys(name for name in names if expression.match(name))
    return list(found)


@dataclasses.dataclass(frozen=True)
class Row:
    """One line. `chooses`: its right side names entries; otherwise it names files that those on the left use."""
    line: int
    left: tuple
    right: tuple
    chooses: bool

    @property
    def for_every_change(self):
        return self.left == ("*",)


def read_table(text):
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        signs = [word for word in words if word in ("->", "uses")]
        if len(signs) != 1 or words[0] in signs or words[-1] in signs:
            raise ValueError(f"reach.txt:{number}: not PATTERN ... -> ENTRY ... nor PATTERN ... uses PATTERN ...: {line}")
        at = words.index(signs[0])
        rows.append(Row(number, tuple(words[:at]), tuple(words[at + 1:]), signs[0] == "->"))
    return rows


def table_of(root=ROOT):
    return read_table((root / "tests/reach.txt").read_text())
