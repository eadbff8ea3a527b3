#!/usr/bin/env python3
"""Manual pages and shell completions of the programs, from what their --help says: no option is described twice.

    deploy/manual_pages.py FOLDER_OF_PROGRAMS FOLDER    # FOLDER/man/man1/photond.1, FOLDER/bash-completion/completions/photond ...
"""

import collections
import pathlib
import re
import subprocess
import sys

Option = collections.namedtuple("Option", "names value default text")  # value: what kind it takes, empty for a flag
Page = collections.namedtuple("Page", "about usage options commands notes")

NOWHERE = ["--server", "http://127.0.0.1:1"]  # a page is the same whether a daemon runs or not
# Programs -> what their pages point at, and the arguments that keep --help to the program alone.
PROGRAMS = {"photond": ("photonctl", []), "photonctl": ("photond", NOWHERE)}
VERSION = re.compile(r"^\S+ (\S+)")


def run(program, *arguments):
    return subprocess.run([str(program), *arguments], capture_output=True, text=True, check=True).stdout


def option_of(term, text):
    """"--listen ADDRESS:PORT=127.0.0.1:8080" and what stands beside it."""
    term = re.sub(r" (Excludes|Needs|REQUIRED).*", "", term)
    names, _, value = term.partition(" ")
    names = re.sub(r"\{.*?\}", "", names)  # what a flag stands for
    value = re.sub(r" (\.\.\.|x \d+)$", "", value)
    default = re.search(r"^[^=\[]+=(?!VALUE)(.*)$", value)  # NAME=VALUE is what it takes, INT=50 what it is
    value = value[:default.start(1) - 1] if default else value
    return Option(names.split(","), value, default[1] if default else "", text)


def parsed(text):
    """The page that CLI11 prints: sections of lines "  TERM   TEXT", of which each may go on below."""
    about, usage, options, commands, notes = [], "", [], [], []
    section = "about"
    for line in text.splitlines():
        if line.startswith("Usage: "):
            usage, section = line.removeprefix("Usage: "), ""
        elif re.fullmatch(r"[A-Z][\w ]*:", line) and line != "Exit codes:":
            section = "commands" if line == "Subcommands:" else "positionals" if line == "Positionals:" else "options"
        elif section == "about":
            about += [line] * bool(line)
        elif section and (row := re.match(r"  (\S.*?)(?:  +(.*))?$", line)) and not line.startswith("     "):
            rows = commands if section == "commands" else options
            rows.append([row[1], row[2] or ""])
        elif section and line.startswith("     ") and (commands if section == "commands" else options):
            rows = commands if section == "commands" else options
            rows[-1][1] = f"{rows[-1][1]} {line.strip()}".strip()
        elif line or notes:
            section = ""
            notes.append(line)
    while notes and not notes[-1]:
        notes.pop()
    return Page(" ".join(about), usage, [option_of(*row) for row in options], [tuple(row) for row in commands], notes)


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def option_lines(page):
    for option in page.options:
        value = f" \\fI{roff(option.value)}\\fR" if option.value else ""
        default = f" Default: {option.default}." if option.default else ""
        yield ".TP"
        yield ", ".join(f"\\fB{roff(name)}\\fR" for name in option.names) + value
        text = option.text[:1].upper() + option.text[1:]
        yield roff(text + ("" if text.endswith((".", "?")) else ".") + default)


def note_lines(page):
    return [".nf", *map(roff, page.notes), ".fi"] if page.notes else []


def command_lines(program, arguments, page, before=()):
    """A section for each command, of those below a command too."""
    for name, _ in page.commands:
        words = [*before, name]
        inner = parsed(run(program, *words, *arguments, "--help"))
        yield f".SS {roff(' '.join(words))}"
        yield roff(inner.about)
        yield from option_lines(Page("", "", [option for option in inner.options if "--help" not in option.names], [], []))
        if inner.notes and inner.notes != page.notes:
            yield from [".PP", *note_lines(inner)]
        yield from command_lines(program, arguments, inner, words)


def manual_page(program, arguments, see_also):
    name = program.name
    page = parsed(run(program, *arguments, "--help"))
    version = VERSION.match(run(program, "--version"))[1]
    about = re.sub(rf"^{name}: ", "", page.about)
    lines = [f'.TH {name.upper()} 1 "" "photond {version}" "photond"', ".SH NAME", f"{name} \\- {roff(about)}",
             ".SH SYNOPSIS", f".B {name}", roff(page.usage.removeprefix(name).strip()), ".SH OPTIONS", *option_lines(page)]
    if page.commands:
        lines += [".SH COMMANDS", *command_lines(program, arguments, page)]
    if page.notes:
        lines += [".SH NOTES", *note_lines(page)]
    return "\n".join([*lines, ".SH SEE ALSO", f".BR {see_also} (1)", ""])


def words_of(option):
    return option.value.split("|") if "|" in option.value else []


def takes_a_path(option):
    return option.value in ("FILE", "FOLDER")


def bash_completion(name, page):
    cases = []
    for option in page.options:
        values = (f'compgen -W "{" ".join(words_of(option))}" -- "$current"' if words_of(option) else
                  f'compgen -{"d" if option.value == "FOLDER" else "f"} -- "$current"' if takes_a_path(option) else "")
        if option.value:
            cases.append(f"        {'|'.join(option.names)}) mapfile -t COMPREPLY < <({values or ':'}); return ;;")
    names = " ".join(name for option in page.options for name in option.names if name.startswith("--"))
    return "\n".join([
        f"# Completion of {name} for bash", f"_{name}() {{", '    local current="${COMP_WORDS[COMP_CWORD]}"',
        '    case "${COMP_WORDS[COMP_CWORD - 1]}" in', *cases, "    esac",
        f'    mapfile -t COMPREPLY < <(compgen -W "{names}" -- "$current")', "}", f"complete -F _{name} {name}", ""])


def zsh_completion(name, page):
    def quoted(text):
        return re.sub(r"([\[\]:\\])", r"\\\1", text).replace("'", "'\\''")

    rows = []
    for option in page.options:
        action = f"({' '.join(words_of(option))})" if words_of(option) else "_files" if takes_a_path(option) else ""
        value = f":{quoted(option.value)}:{action}" if option.value else ""
        rows += [f"    '{long}[{quoted(option.text)}]{value}'" for long in option.names if long.startswith("--")]
    return "\n".join([f"#compdef {name}", "_arguments \\", " \\\n".join(rows), ""])


def fish_completion(name, page):
    lines = []
    for option in page.options:
        text = option.text.replace("\\", "\\\\").replace("'", "\\'")
        values = (f" -x -a '{' '.join(words_of(option))}'" if words_of(option) else
                  " -r -F" if takes_a_path(option) else " -x" if option.value else "")
        lines += [f"complete -c {name} -l {long[2:]}{values} -d '{text}'" for long in option.names if long.startswith("--")]
    return "\n".join([f"complete -c {name} -f", *lines, ""])


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def main(programs, folder):
    for name, (see_also, arguments) in PROGRAMS.items():
        program = programs / name
        write(folder / "man/man1" / f"{name}.1", manual_page(program, arguments, see_also))
        page = parsed(run(program, *arguments, "--help"))
        # photonctl has scripts of its own, which ask the daemon for what it knows.
        has_own = "completion" in dict(page.commands)
        for shell, make, place in (("bash", bash_completion, f"bash-completion/completions/{name}"),
                                   ("zsh", zsh_completion, f"zsh/site-functions/_{name}"),
                                   ("fish", fish_completion, f"fish/vendor_completions.d/{name}.fish")):
            write(folder / place, run(program, "completion", shell) if has_own else make(name, page))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*map(pathlib.Path, sys.argv[1:]))
