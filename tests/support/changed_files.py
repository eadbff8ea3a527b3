"""The files that a change touches: what differs between the working tree and a base, untracked files included.

The base is the merge base of HEAD and the main branch: origin/main, main or master, the first that is there. Where HEAD is
that branch itself, it is its upstream; where nothing differs from that, it is the commit before HEAD.
"""

import pathlib
import subprocess

MAIN_BRANCHES = ("origin/main", "main", "master")
NO_COMMIT = "4b825dc642cb6eb9a060e54bf8d69288fbee4904"  # git's name of the empty tree


class NoBase(Exception):
    """Nothing says what changed; the text says why."""


class Repository:
    def __init__(self, root):
        self.root = pathlib.Path(root).resolve()
        top = self.ask("rev-parse", "--show-toplevel")
        if not top or pathlib.Path(top).resolve() != self.root:
            raise NoBase(f"{self.root} is no git repository, so nothing says what changed")

    def run(self, *arguments):
        """The bytes that a git command prints."""
        run = subprocess.run(["git", "-C", str(self.root), *arguments], capture_output=True, check=False)
        if run.returncode != 0:
            raise NoBase(f"git {arguments[0]}: {run.stderr.decode(errors='replace').strip()}")
        return run.stdout

    def ask(self, *arguments):
        """What a git command prints in one line, None where it fails."""
        try:
            return self.run(*arguments).decode().strip()
        except NoBase:
            return None

    def commit_of(self, name):
        return self.ask("rev-parse", "--verify", "--quiet", name + "^{commit}")

    def base(self, asked=None):
        """(the commit that a change is measured from, where it comes from in words)"""
        if asked:
            if not self.commit_of(asked):
                raise NoBase(f"there is no commit {asked}")
            return self.run("merge-base", "HEAD", asked).decode().strip(), f"the merge base with {asked}"
        branch = self.ask("symbolic-ref", "--quiet", "--short", "HEAD")
        main = next((name for name in MAIN_BRANCHES if self.commit_of(name)), None)
        if main and main == branch:  # it is its own merge base
            main = self.ask("rev-parse", "--abbrev-ref", "--symbolic-full-name", "@{upstream}")
        base = main and self.ask("merge-base", "HEAD", main)
        if base and (base != self.commit_of("HEAD") or self.files_since(base)):
            return base, f"the merge base with {main}"
        reason = f"HEAD is part of {main}" if base else "there is no other branch to compare with"
        return self.commit_of("HEAD~1") or NO_COMMIT, f"the commit before HEAD, for {reason}"

    def files_since(self, base):
        tracked = self.run("diff", "--name-only", "--no-renames", "-z", base, "--")
        untracked = self.run("ls-files", "-z", "--others", "--exclude-standard")
        return sorted({name for name in (tracked + untracked).decode(errors="replace").split("\0") if name})

    def texts_gone_since(self, base, files):
        """File -> its text in the base, of those files that are there no more."""
        return {name: self.run("show", f"{base}:{name}").decode(errors="replace")
                for name in files if not (self.root / name).exists()}
