"""Runs clang-tidy over our own sources, and remembers what passed.

    tests/support/tidy.py BUILD SOURCE...

A source is done when clang-tidy has nothing to say of it; it is not looked at again while the preprocessed text (comments
do not count, but for those that silence a check), the checks and clang-tidy itself are the same: BUILD/tidy/ has a file
for each such state. A run that is interrupted goes on
where it was, and a change costs the sources that it reaches.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXTRA = ["-Wno-unknown-warning-option", "-Wno-unused-command-line-argument", "-Wno-ignored-optimization-argument"]
WITH_VALUE = {"-o", "-MF", "-MT", "-MQ"}  # options of the compile commands that say where output goes
ALONE = {"-c", "-MD", "-MMD"}


def silencing_comments():
    """Those of all our sources and headers, whichever file they are in."""
    found = subprocess.run(["grep", "-rho", "--include=*.h", "--include=*.cpp", "--exclude-dir=node_modules", "NOLINT.*",
                            "protocol", "renderer", "server", "clients"], cwd=ROOT, capture_output=True, check=False)
    return b"\n".join(sorted(found.stdout.splitlines()))


def preprocessed(entry):
    """The text that the compiler sees."""
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
    return subprocess.run([*command, "-E", "-P"], cwd=entry["directory"], check=True, capture_output=True).stdout


def main():
    build, sources = pathlib.Path(sys.argv[1]), [pathlib.Path(path).resolve() for path in sys.argv[2:]]
    entries = {pathlib.Path(entry["file"]).resolve(): entry
               for entry in json.loads((build / "compile_commands.json").read_text())}
    passed = build / "tidy"
    passed.mkdir(exist_ok=True)
    tool = subprocess.run(["clang-tidy", "--version"], check=True, capture_output=True).stdout
    checks = (ROOT / ".clang-tidy").read_bytes() + silencing_comments()

    def check(source):
        """What clang-tidy says of it; nothing when it passes."""
        if source not in entries:
            return f"{source}: no compile command: it belongs to no target\n"
        state = passed / hashlib.sha256(tool + checks + preprocessed(entries[source])).hexdigest()
        if state.exists():
            state.touch()
            return ""
        run = subprocess.run(["clang-tidy", "-p", build, "--quiet", *(f"--extra-arg={word}" for word in EXTRA), source],
                             capture_output=True, text=True, check=False)
        if run.returncode != 0:
            return run.stdout + run.stderr
        state.write_text(f"{source}\n")
        return ""

    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for number, (source, said) in enumerate(zip(sources, pool.map(check, sources)), 1):
            failed += bool(said)
            sys.stdout.write(said)
            if number % 20 == 0 or number == len(sources):
                print(f"{number} of {len(sources)} sources looked at, {failed} with faults", flush=True)
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
