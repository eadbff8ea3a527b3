"""Runs clang-tidy over our own sources, and remembers what passed.

    tests/support/tidy.py BUILD SOURCE...

A source is done when clang-tidy has nothing to say of it; it is not looked at again while the preprocessed text (comments
do not count, but for those that silence a check), the checks and clang-tidy itself are the same: BUILD/tidy/ has a file
for each such state. A run that is interrupted goes on where it was, and a change costs the sources that it reaches. Each
source's verdict is a line of BUILD/verdicts.tsv with the commit (verdicts.py); it took no time where it was remembered.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

from verdicts import FAILED, PASSED, STOPPED, Children, Ledger, heed_signals, state_of_tree

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

    heed_signals()
    ledger, children = Ledger(build, state_of_tree()), Children()

    def note(source, verdict, seconds=0.0, processor_seconds=0.0):
        name = source.relative_to(ROOT).as_posix()
        if seconds > 0 or verdict != PASSED or not ledger.has_passed(name):
            ledger.add(name, verdict, seconds, processor_seconds)

    def check(source):
        """Prints what clang-tidy says of it. True where that is nothing."""
        if source not in entries:
            print(f"{source}: no compile command: it belongs to no target", flush=True)
            note(source, FAILED)
            return False
        state = passed / hashlib.sha256(tool + checks + preprocessed(entries[source])).hexdigest()
        if state.exists():
            state.touch()
            note(source, PASSED)
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
                state.write_text(f"{source}\n")
            note(source, FAILED if status else PASSED, seconds, used)
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
