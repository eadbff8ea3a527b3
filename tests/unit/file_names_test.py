"""Comments, docstrings, pages and what goes out over HTTP name only files that are here, sections that their page has, and
identifiers that the file linked beside them has. The tree is walked as it lies: it may be a copy without a repository.
"""

import fnmatch
import os
import pathlib
import posixpath
import re
import tempfile
import unittest

import include_rules_test

SOURCE = pathlib.Path(os.environ.get("PHOTOND_SOURCE", pathlib.Path(__file__).resolve().parents[2]))
LEFT_OUT = {".git", ".cache", "build", "node_modules", "dist", "__pycache__"}  # the build's, npm's and Python's

# A name with such an end is a source's or a page's wherever it stands. Other ends are those of files that users have, of
# a job's results and of examples, unless a folder of this repository is named before them.
SOURCE_ENDS = "md|h|hpp|cpp|glsl|comp|vert|frag|py|pyi|ts|tsx|mjs|css|cmake|sh|toml"
FOLDERS = "protocol|renderer|server|clients|tests|docs|deploy|papers|shared|design"
NAME = re.compile(rf"(?<![\w./*$%}}-])(?:((?:[\w.*-]+/)*[\w*-][\w.*-]*\.(?:{SOURCE_ENDS}))(?![\w(/*]|\.\w)"
                  rf"|((?:\.\./)*(?:{FOLDERS})/[\w./*-]*[\w*]))")
SECTION = re.compile(r'\b([\w-]+\.md)[`)]{0,2},\s*(?:(?://+|#|\*)\s*)?"([^"]+)"')
LINK = re.compile(r"\[([^\]\n]*)\]\(([^)\s]+)\)")
LINE_BREAK = re.compile(r"\s*\n\s*(?:(?://+|#|\*)\s?)?\s*")

# What is no file of ours though it is called like one, each with its reason.
ELSEWHERE = {
    "uplot/dist/uPlot.min.css": "a package's, which npm installs",
    **dict.fromkeys(["_svo.comp", "_rays.comp", "_maps.comp", "_none.comp"], "ends of a shader's variants: CMakeLists.txt"),
}

# Syntax -> its comments and its strings. In tests strings are what they feed to programs: nobody reads them.
C_LIKE = re.compile(r"""(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<string>"(?:\\.|[^"\\\n])*"|`(?:\\.|[^`\\])*`)|(?<!\w)'(?:\\.|[^'\\\n])*'""",
                    re.DOTALL)
PYTHON = re.compile(r'''(?P<comment>#[^\n]*|""".*?""")|(?P<string>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')''', re.DOTALL)
HASHES = re.compile(r"(?P<comment>(?<!\S)#[^\n]*)")
PAGE = re.compile(r"(?P<comment>.+)", re.DOTALL)
SYNTAX = {**dict.fromkeys([".h", ".cpp", ".glsl", ".comp", ".vert", ".frag", ".ts", ".tsx", ".mjs", ".js", ".css"], C_LIKE),
          ".py": PYTHON, ".md": PAGE, **dict.fromkeys(["", ".txt", ".cmake", ".toml", ".in"], HASHES)}

QUESTIONS = ["Where is a glossy photon refused?", "Who gives back what the clamp takes?", "Which thread serves an event stream?",
             "Who decides whether a job is tried again?", "How does a layer reach the dashboard?"]


def outside_header(name):
    """Whether it is a header of a library or of the system that the table of includes knows."""
    known = [header for header, _ in include_rules_test.LIBRARIES] + include_rules_test.SYSTEM
    return any(fnmatch.fnmatchcase(name, pattern) or fnmatch.fnmatchcase(name, "*/" + pattern) or
               pattern.endswith("/" + name) for pattern in known)


class Tree:
    """The files below a root, and what may be called by a name."""

    def __init__(self, root):
        self.root = root
        self.files = []
        for folder, folders, files in os.walk(root):
            folders[:] = sorted(set(folders) - LEFT_OUT)
            place = os.path.relpath(folder, root)
            self.files += [posixpath.normpath(f"{place}/{file}") for file in sorted(files)]
        self.known = set()  # every end of a path, and of a folder's
        self.headings = {}
        for file in self.files:
            self.known |= self.ends(file)
            while file := posixpath.dirname(file):
                if file in self.known:
                    break
                self.known |= self.ends(file)

    @staticmethod
    def ends(path):
        return {path} | {path[at + 1:] for at, letter in enumerate(path) if letter == "/"}

    def has(self, name, place):
        """`place`: the folder of the file that names it. An asterisk and a word in capitals stand for any name."""
        name = name.rstrip("/.")
        if name in self.known or posixpath.normpath(posixpath.join(place, name)) in self.known:
            return True
        if "*" in name or re.search(r"\b[A-Z]{3,}\b|\b[A-Z]{3,}_", name):
            pattern = re.compile(fnmatch.translate(re.sub(r"(?<![A-Za-z])[A-Z]{3,}(?![A-Za-z])", "*", name)))
            return any(pattern.match(known) for known in self.known)
        return any(known.startswith(name) for known in self.known) if "." not in name else False  # a shader's stem

    def sections(self, page):
        """Titles in the pages of that name."""
        if page not in self.headings:
            texts = [(self.root / file).read_text() for file in self.files if posixpath.basename(file) == page]
            self.headings[page] = {title for text in texts for title in re.findall(r"^#+ (.+)$", text, re.MULTILINE)}
        return self.headings[page]


def spoken(text, syntax, strings):
    """Spans of a text that somebody reads."""
    for match in syntax.finditer(text):
        if match.lastgroup == "comment" or (strings and match.lastgroup == "string"):
            yield match.span()


def faults_of(tree, file):
    """(offset, what) for each wrong name in one file."""
    suffix = posixpath.splitext(file)[1]
    if suffix not in SYNTAX:
        return
    try:
        text = (tree.root / file).read_text()
    except UnicodeDecodeError:
        return
    place = posixpath.dirname(file)
    unknown = []
    for match in NAME.finditer(text):
        name = match[1] or match[2]
        if tree.has(name, place) or name in ELSEWHERE or outside_header(name):
            continue
        unknown.append((match.start(), f"there is no file {name}"))
    for match in SECTION.finditer(text):
        title = LINE_BREAK.sub(" ", match[2])
        if title not in tree.sections(match[1]):
            unknown.append((match.start(), f'{match[1]} has no section "{title}"'))
    if unknown:  # most files name only what is there, so that few are taken apart
        spans = list(spoken(text, SYNTAX[suffix], not file.startswith("tests/")))
        yield from ((at, what) for at, what in unknown if any(first <= at < end for first, end in spans))
    if suffix == ".md":
        yield from link_faults(tree, text, place)


def link_faults(tree, text, place):
    for match in LINK.finditer(text):
        words, target = match.groups()
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        linked = posixpath.normpath(posixpath.join(place, path)) if path else None
        if linked and not (tree.root / linked).exists():
            yield match.start(), f"the link to {target} leads nowhere"
        elif anchor and linked and anchor not in {slug(title) for title in tree.sections(posixpath.basename(linked))}:
            yield match.start(), f"{path} has no section for the link to {target}"
        elif linked and re.fullmatch(r"`[\w:]+(\(\))?`", words):
            identifier = words.strip("`()").split("::")[-1]
            if not re.search(rf"\b{identifier}\b", (tree.root / linked).read_text()):
                yield match.start(), f"{path} has no {identifier}"


def slug(title):
    return re.sub(r"[^\w -]", "", title).strip().lower().replace(" ", "-")


def faults(root):
    tree = Tree(root)
    found = []
    for file in tree.files:
        wrong = list(faults_of(tree, file))
        if wrong:
            text = (root / file).read_text()
            found += [f"{file}:{text.count(chr(10), 0, at) + 1}: {what}" for at, what in wrong]
    return found


class FileNames(unittest.TestCase):
    def test_every_file_section_and_identifier_that_is_named_is_there(self):
        found = faults(SOURCE)
        self.assertEqual(found, [], "\n" + "\n".join(found))

    def test_there_is_something_to_look_at(self):
        tree = Tree(SOURCE)
        self.assertGreater(len(tree.files), 1000)
        named = sum(len(NAME.findall((SOURCE / file).read_text())) for file in tree.files if file.endswith((".md", ".h")))
        self.assertGreater(named, 500)

    def test_the_architecture_answers_five_questions(self):
        text = (SOURCE / "ARCHITECTURE.md").read_text()
        parts = re.split(r"^### (.+)$", text[text.index("## Five questions"):], flags=re.MULTILINE)
        self.assertEqual(parts[1::2], QUESTIONS)
        for question, answer in zip(parts[1::2], parts[2::2]):
            links = [words for words, target in LINK.findall(answer) if ".md" not in target]
            self.assertTrue(links and all(re.fullmatch(r"`[\w:]+(\(\))?`", words) for words in links), question)


class PlantedFaults(unittest.TestCase):
    """The test of the test."""

    HERE = {"renderer/core/here.h": "struct Here {};", "docs/page.md": "# A page\n\n## A section\n"}

    def found(self, **files):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {**self.HERE, **files}.items():
                (pathlib.Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
                (pathlib.Path(folder) / name).write_text(text)
            return faults(pathlib.Path(folder))

    def test_missing_files(self):
        for text in ("// gone.h", "/* as\n gone.h */", "// (core/gone.h).", 'char* s = "gone.md";', "// papers/gone.txt",
                     "// renderer/gone/", "// gone_*.h", "// renderer/core/there.h"):
            found = self.found(**{"server/a.cpp": "\n" + text})
            self.assertEqual(len(found), 1, text)
            self.assertRegex(found[0], r"^server/a.cpp:[23]: there is no file ")

    def test_files_that_are_there_or_elsewhere(self):
        text = ("// here.h, core/here.h, renderer/core/here.h, renderer/core/, core/*.h, renderer/NAME/here.h, page.md\n"
                "// httplib.h; image.exr, scene.glb, curve.csv, /proc/self/stat, /v1/jobs/ID/log.txt, https://a.org/b.md\n"
                "const int a = some.h + other.md;\n")
        self.assertEqual(self.found(**{"server/a.cpp": text}), [])

    def test_strings_are_read_but_in_tests(self):
        text = "NAME = 'gone.py'\n"
        self.assertEqual(len(self.found(**{"clients/a.py": text})), 1)
        self.assertEqual(self.found(**{"tests/a.py": text}), [])
        self.assertEqual(len(self.found(**{"tests/a.py": '"""As gone.py."""'})), 1)

    def test_sections(self):
        self.assertEqual(self.found(**{"server/a.h": '// (page.md, "A\n// section").'}), [])
        self.assertEqual(self.found(**{"server/a.h": '\n// (page.md, "A\n// paragraph").'}),
                         ['server/a.h:2: page.md has no section "A paragraph"'])

    def test_links(self):
        links = ("[`Here`](../renderer/core/here.h) [x](page.md#a-section) [y](https://a.org)\n"
                 "[`There`](../renderer/core/here.h)\n[x](page.md#nowhere)\n[z](gone.png)\n")
        self.assertEqual(self.found(**{"docs/links.md": links}), [
            "docs/links.md:2: ../renderer/core/here.h has no There",
            "docs/links.md:3: page.md has no section for the link to page.md#nowhere",
            "docs/links.md:4: the link to gone.png leads nowhere"])


if __name__ == "__main__":
    unittest.main()
