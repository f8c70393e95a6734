#!/usr/bin/env python3
"""Writes what a shell wants to know of the program from its own --help: a man page and completions.

usage: command_line_files.py PROGRAM FOLDER

Writes into FOLDER:
  occlude.1      a manual page, of all commands
  occlude.bash   completions for bash
  _occlude       ... for zsh
  occlude.fish   ... for fish

The date of the manual page is that of SOURCE_DATE_EPOCH, if it is set: then the files do not depend
on when they are made.
"""

import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

ENTRY = re.compile(r"^  (\S.*?)(?:  +(\S.*))?$")


@dataclass
class Group:
    """A heading of a help text and the entries below it: name and description."""

    title: str
    entries: list[tuple[str, str]] = field(default_factory=list)


@dataclass
class Help:
    """The help text of the program or of one of its commands."""

    name: str
    summary: str
    usage: str
    groups: list[Group]

    def options(self) -> list[tuple[str, str, str]]:
        """Every option: its long name, what it takes ("" for a flag), its description."""
        found = []
        for group in self.groups:
            for name, description in group.entries:
                option = re.match(r"(?:-\w,)?(--[\w-]+)(?: (\S+))?", name)
                if option:
                    found.append((option.group(1), option.group(2) or "", description))
        return found


def parse(name: str, text: str) -> Help:
    lines = text.splitlines()
    parsed = Help(name, lines[0], "", [])
    for line in lines[1:]:
        if line.startswith("Usage: "):
            parsed.usage = line.removeprefix("Usage: ")
        elif line.startswith("    "): # a long name has its description below it
            name_above, description = parsed.groups[-1].entries[-1]
            parsed.groups[-1].entries[-1] = (name_above, f"{description} {line.strip()}".strip())
        elif entry := ENTRY.match(line):
            parsed.groups[-1].entries.append((entry.group(1), entry.group(2) or ""))
        elif line.endswith(":"):
            parsed.groups.append(Group(line.removesuffix(":")))
        elif line.strip():
            sys.exit(f"command_line_files.py: the help of '{name}' has a line of no known form: {line}")
    return parsed


def read_help(program: str) -> tuple[Help, list[Help]]:
    def run(*arguments: str) -> str:
        return subprocess.run([program, *arguments, "--help"], check=True, text=True,
                              stdout=subprocess.PIPE, timeout=60).stdout

    whole = parse("occlude", run())
    commands = [name for group in whole.groups if group.title == "Subcommands" for name, _ in group.entries]
    if not commands:
        sys.exit("command_line_files.py: the help of the program names no subcommands")
    return whole, [parse(name, run(name)) for name in commands]


# --- the manual page ---------------------------------------------------------------------------


def roff(text: str) -> str:
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + escaped if escaped.startswith((".", "'")) else escaped


def man_page(whole: Help, commands: list[Help], version: str) -> str:
    moment = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time())))
    page = [
        f'.TH OCCLUDE 1 "{time.strftime("%Y-%m-%d", moment)}" "occlude {version}" "User Commands"',
        ".SH NAME",
        "occlude \\- occlusion culling: what a renderer need not draw, and the proof of it",
        ".SH SYNOPSIS",
        ".B occlude",
        ".I COMMAND",
        "[OPTIONS] ...",
        ".SH DESCRIPTION",
        "Measures occlusion culling algorithms on scenes, compares every pixel with drawing everything,",
        "and shows what is hidden and why.",
        "A scene is a file of any format that Assimp reads, or a generated one of",
        ".BR \"occlude list scenes\" .",
        ".SH COMMANDS",
    ]
    for command in commands:
        page += [".SS " + roff(command.name), roff(command.summary) + ".", ".PP", ".B " + roff(command.usage)]
        for group in command.groups:
            if group.title not in ("Positionals", "Options"):
                page += [".PP", roff(group.title) + ":"]
            for name, description in group.entries:
                if "--help" not in name:
                    page += [".TP", ".B " + roff(name), roff(description) or "\\&"]
    page += [
        ".SH EXIT STATUS",
        ".TP", ".B 0", "Done.",
        ".TP", ".B 1", "An exact algorithm's image differs, or a replay decides differently.",
        ".TP", ".B 2", "The command could not be carried out; the reason is on standard error.",
        ".TP", ".B 3", "What was verified proves nothing: nothing was in view, or nothing hidden.",
        ".SH ENVIRONMENT",
        ".TP", ".B OCCLUDE_ASSETS", "The folder of the scenes that the program brings along.",
    ]
    return "\n".join(page) + "\n"


# --- completions -------------------------------------------------------------------------------

# Options whose value is a file or a folder; the help calls these values so.
FILES = ("FILE", "DIR")


def bash(commands: list[Help]) -> str:
    lines = [
        "# Completions of occlude for bash.",
        "_occlude()",
        "{",
        "    local current=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]:-} options=",
        "    if ((COMP_CWORD == 1)); then",
        f"        COMPREPLY=($(compgen -W '{' '.join(c.name for c in commands)} --help --version' -- \"$current\"))",
        "        return",
        "    fi",
        "    case $command in",
    ]
    for command in commands:
        names = " ".join(name for name, _, _ in command.options())
        lines.append(f"    {command.name}) options='{names}' ;;")
    lines += [
        "    esac",
        "    if [[ $command == list ]] && ((COMP_CWORD == 2)); then",
        "        options='algorithms hierarchies devices scenes paths'",
        "        COMPREPLY=($(compgen -W \"$options\" -- \"$current\"))",
        "    elif [[ $current == -* ]]; then",
        "        COMPREPLY=($(compgen -W \"$options\" -- \"$current\"))",
        "    else",
        "        COMPREPLY=($(compgen -f -- \"$current\"))",
        "    fi",
        "}",
        "complete -o filenames -F _occlude occlude",
    ]
    return "\n".join(lines) + "\n"


def quoted(text: str) -> str:
    return text.replace("'", "").replace("[", "(").replace("]", ")").replace(":", ";")


def zsh(commands: list[Help]) -> str:
    lines = ["#compdef occlude", "# Completions of occlude for zsh.", "local -a commands", "commands=("]
    lines += [f"    '{c.name}:{quoted(c.summary)}'" for c in commands]
    lines += [
        ")",
        "if ((CURRENT == 2)); then",
        "    _describe command commands",
        "    return",
        "fi",
        "case $words[2] in",
    ]
    for command in commands:
        lines.append(f"{command.name})")
        lines.append("    _arguments '*:file:_files' \\")
        for name, value, description in command.options():
            takes = f"={value.split('=')[0].lower()}" if value else ""
            action = f":{takes[1:]}:{'_files' if value in FILES else ' '}" if value else ""
            lines.append(f"        '{name}[{quoted(description)}]{action}' \\")
        lines[-1] = lines[-1].removesuffix(" \\")
        lines.append("    ;;")
    lines.append("esac")
    return "\n".join(lines) + "\n"


def fish(commands: list[Help]) -> str:
    lines = ["# Completions of occlude for fish."]
    for command in commands:
        lines.append(f"complete -c occlude -n __fish_use_subcommand -a {command.name} -d '{quoted(command.summary)}'")
    for command in commands:
        for name, value, description in command.options():
            takes = " -r" if value else ""
            lines.append(
                f"complete -c occlude -n '__fish_seen_subcommand_from {command.name}' "
                f"-l {name[2:]}{takes} -d '{quoted(description)}'")
    return "\n".join(lines) + "\n"


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, folder = sys.argv[1], Path(sys.argv[2])
    version = subprocess.run([program, "--version"], check=True, text=True, stdout=subprocess.PIPE,
                             timeout=60).stdout.split()[-1]
    whole, commands = read_help(program)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "occlude.1").write_text(man_page(whole, commands, version))
    (folder / "occlude.bash").write_text(bash(commands))
    (folder / "_occlude").write_text(zsh(commands))
    (folder / "occlude.fish").write_text(fish(commands))


if __name__ == "__main__":
    main()
