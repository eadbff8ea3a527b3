"""Runs clang-tidy over our own sources, and remembers what passed.

    tests/support/tidy.py BUILD PASSED SOURCE...

A source is done when clang-tidy has nothing to say of it. It is not looked at again while the preprocessed text, the
comments that silence a check in the files of this text, the checks and clang-tidy itself are the same. PASSED is a file of
the repository: it has a line for each source that passed, with a digest of all these and the commit at which it passed.
So a run that is interrupted goes on where it was, in another session or on another machine too, and a change costs the
sources that it reaches. Each source's verdict is also a line of BUILD/verdicts.tsv (verdicts.py); it took no time where it
was remembered.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import threading

from verdicts import FAILED, PASSED, STOPPED, Children, Ledger, heed_signals, state_of_tree

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXTRA = ["-Wno-unknown-warning-option", "-Wno-unused-command-line-argument", "-Wno-ignored-optimization-argument"]
WITH_VALUE = {"-o", "-MF", "-MT", "-MQ"}  # options of the compile commands that say where output goes
ALONE = {"-c", "-MD", "-MMD"}


class Passed:
    """The file of what passed: by source its digest and the commit."""

    def __init__(self, path):
        self.path = path
        lines = path.read_text().splitlines() if path.exists() else []
        self._rows = {source: (digest, commit) for source, digest, commit in (line.split("\t") for line in lines)}
        self._lock = threading.Lock()

    def has(self, source, digest):
        return self._rows.get(source, ("",))[0] == digest

    def add(self, source, digest, commit):
        with self._lock:
            self._rows[source] = (digest, commit)
            lines = (f"{name}\t{digest}\t{commit}\n" for name, (digest, commit) in sorted(self._rows.items())
                     if (ROOT / name).exists())
            new = self.path.with_name(self.path.name + ".new")
            new.write_text("".join(lines))
            new.replace(self.path)


def seen_by_compiler(entry):
    """The preprocessed text without blank lines and without the repository's place, and the comments in its files that silence a check."""
    words = shlex.split(entry["command"])
    while words and (pathlib.Path(words[0]).name in ("cmake", "ccache", "compile_cached") or words[0] in ("-E", "env") or
                     "=" in words[0]):
        words.pop(0)
    command, skip = [], False
    for word in words:
        if skip or word in WITH_VALUE or word in ALONE:
            skip = word in WITH_VALUE and not skip
            continue
        command.append(word)
    text = subprocess.run([*command, "-E"], cwd=entry["directory"], check=True, capture_output=True).stdout
    lines, files = [], {pathlib.Path(entry["file"])}
    for line in text.splitlines():
        marker = re.match(rb'# \d+ "([^<"]+)"', line)
        if marker:
            files.add(pathlib.Path(entry["directory"], os.fsdecode(marker[1])).resolve())
        elif line.strip():
            lines.append(line.strip())
    own = sorted(file for file in files if file.is_relative_to(ROOT) and file.is_file())
    comments = [comment for file in own for comment in re.findall(rb"NOLINT.*", file.read_bytes())]
    return b"\n".join([*lines, *comments]).replace(os.fsencode(ROOT), b"")


def main():
    build, passed = pathlib.Path(sys.argv[1]), Passed(pathlib.Path(sys.argv[2]))
    sources = [pathlib.Path(path).resolve() for path in sys.argv[3:]]
    entries = {pathlib.Path(entry["file"]).resolve(): entry
               for entry in json.loads((build / "compile_commands.json").read_text())}
    told = subprocess.run(["clang-tidy", "--version"], check=True, capture_output=True).stdout
    tool = b"".join(line for line in told.splitlines() if b"version" in line)  # it tells of this machine's processor too
    checks = (ROOT / ".clang-tidy").read_bytes()

    heed_signals()
    ledger, children = Ledger(build, state_of_tree()), Children()

    def note(name, verdict, seconds=0.0, processor_seconds=0.0):
        if seconds > 0 or verdict != PASSED or not ledger.has_passed(name):
            ledger.add(name, verdict, seconds, processor_seconds)

    def check(source):
        """Prints what clang-tidy says of it. True where that is nothing."""
        name = source.relative_to(ROOT).as_posix()
        if source not in entries:
            print(f"{source}: no compile command: it belongs to no target", flush=True)
            note(name, FAILED)
            return False
        digest = hashlib.sha256(tool + checks + seen_by_compiler(entries[source])).hexdigest()[:16]
        if passed.has(name, digest):
            note(name, PASSED)
            return True
        with tempfile.TemporaryFile("w+") as said:
            status, seconds, used = children.run(
                ["clang-tidy", "-p", build, "--quiet", *(f"--extra-arg={word}" for word in EXTRA), source], said)
            if children.stopped:
                return False
            said.seek(0)
            if status:
                print(said.read(), end="", flush=True)
            else:
                passed.add(name, digest, ledger.state)
            note(name, FAILED if status else PASSED, seconds, used)
        return status == 0

    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        futures = [pool.submit(check, source) for source in sources]
        try:
            for number, future in enumerate(concurrent.futures.as_completed(futures), 1):
                failed += not future.result()
                if number % 20 == 0 or number == len(sources):
                    print(f"{number} of {len(sources)} sources looked at, {failed} with faults", flush=True)
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            children.stop()
            print("stopped: the same command goes on from here")
            return STOPPED
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
