#!/usr/bin/env python3
"""Checks that everything that the documentation names exists.

In the Markdown files: links and their #anchors, files, functions and options in `back quotes`, and the commands
of fenced blocks with their options. In the comments of the library's headers: the files that they name.
Each algorithm has a page with its usual headings, and a row in README.md and in docs/algorithms.md.

usage: check_docs.py [ROOT] [--program PROGRAM]
       With PROGRAM, the commands of fenced blocks are also compared with what PROGRAM COMMAND --help offers.

Prints one line per problem. Exit status 0 if there is none, 1 otherwise.
"""

import argparse
import re
import shlex
import subprocess
import sys
from pathlib import Path

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
BLOCK = re.compile(r"^```[^\n]*\n(.*?)^```", re.DOTALL | re.MULTILINE)
QUOTED = re.compile(r"`([^`\n]+)`")
FILE = re.compile(r"[\w./-]*\w\.(?:h|cpp|\{h,cpp\}|py|md|cmake|toml)(?!\w)")
FUNCTION = re.compile(r"(?:\w+::)*\w+\([^()]*\)")
OPTION = re.compile(r"--[a-z][\w-]*")
OWN_OPTION = re.compile(r"\b([a-z_]+)[.:]([a-z_]+)=")

# Names that stand for the reader's own names.
PLACEHOLDER = re.compile(r"\b(my_|x_builder|your[-_])|\bFILE\.|\bNAME\b")
SOURCE_FOLDERS = ("adapters", "occlude", "tools", "examples", "tests", "benchmarks")
# Where the options come from that a page may name: of the program, of ./dev and of the scripts.
OPTION_SOURCES = ("tools/commands/*.cpp", "tools/viewer/*.cpp", "dev", "scripts/*.py")
# Options of other programs that pages speak of.
FOREIGN_OPTIONS = re.compile(r"--(benchmark_\w+|gtest_\w+|preset|build|install|prefix|target|test-dir|cflags|libs|static|help)$")


def anchors(page):
    """The anchors of a page's headings, as GitHub forms them."""
    headings = re.findall(r"^#+ +(.+?) *$", FENCE.sub("", page.read_text("utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in headings}


def pages_of(root):
    """The Markdown files of the repository, but the changelog, which speaks of the past."""
    pages = [*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("examples/**/*.md")]
    return sorted(page for page in pages if page.name != "CHANGELOG.md")


def broken_links(root):
    """One sentence per link below `root` that leads nowhere."""
    for page in [*pages_of(root), *root.glob("CHANGELOG.md")]:
        for link in LINK.findall(FENCE.sub("", page.read_text("utf-8"))):
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = link.partition("#")
            target = page.parent / path if path else page
            if not target.exists():
                yield f"{page.relative_to(root)}: {link} does not exist"
            elif anchor and anchor not in anchors(target):
                yield f"{page.relative_to(root)}: {link} names no heading"


class Sources:
    """What the sources of a repository name, read once."""

    def __init__(self, root):
        self.root = root
        files = [
            path
            for folder in SOURCE_FOLDERS
            for path in (root / folder).rglob("*")
            if path.suffix in (".h", ".cpp", ".c", ".glsl")
        ]
        text = "\n".join(path.read_text("utf-8", errors="replace") for path in files)
        scripts = [path for pattern in OPTION_SOURCES for path in root.glob(pattern)]
        option_text = "\n".join(path.read_text("utf-8", errors="replace") for path in scripts)
        self.words = set(re.findall(r"\w+", text))
        self.own_options = set(re.findall(r'visit\(\s*"(\w+)"', text))
        self.options = set(re.findall(r"--[a-z][\w-]*", option_text))
        skipped = (".git", "build", "out")
        self.file_names = set()  # every path, and every path that it ends with
        for path in root.rglob("*"):
            parts = path.relative_to(root).parts
            if not parts[0].startswith(skipped):
                self.file_names.update("/".join(parts[start:]) for start in range(len(parts)))

    def has_file(self, name, beside):
        """True if a page or header in the folder `beside` may call a file by this name."""
        names = [name.replace("{h,cpp}", end) for end in ("h", "cpp")] if "{h,cpp}" in name else [name]
        return all(one in self.file_names or (beside / one).exists() for one in names)


def unknown_names(root, sources):
    """One sentence per file, function or option that a page names in back quotes and that does not exist."""
    for page in pages_of(root):
        place = page.relative_to(root)
        for quoted in QUOTED.findall(FENCE.sub("", page.read_text("utf-8"))):
            if PLACEHOLDER.search(quoted):
                continue
            if FILE.fullmatch(quoted):
                if not sources.has_file(quoted, page.parent):
                    yield f"{place}: there is no file `{quoted}`"
            elif FUNCTION.fullmatch(quoted):
                unknown = [word for word in re.findall(r"\w+", quoted.split("(")[0]) if word not in sources.words]
                if unknown:
                    yield f"{place}: `{quoted}`: nothing is called {unknown[0]}"
            for problem in unknown_options(quoted, sources):
                yield f"{place}: `{quoted}`: {problem}"


def unknown_options(text, sources):
    """What is wrong with the options that a piece of text names."""
    for option in OPTION.findall(text):
        if option not in sources.options and not FOREIGN_OPTIONS.match(option):
            yield f"there is no option {option}"
    if "--" not in text:
        return
    for owner, option in OWN_OPTION.findall(text):
        generator = owner in text.split("--")[0]  # a scene before the options: city:blocks=3
        if not generator and owner in sources.words and option not in sources.own_options:
            yield f"{owner} has no option {option}"


def commands_of(page):
    """The commands of `occlude` in a page's fenced blocks, with lines that go on put together."""
    for block in BLOCK.findall(page.read_text("utf-8")):
        for line in re.sub(r"\\\n\s*", "" , block).splitlines():
            words = line.strip().removeprefix("$ ")
            if re.match(r"(build/bin/)?occlude [a-z]", words):
                yield words


def broken_commands(root, sources, help_of):
    """One sentence per command in a fenced block that the program would refuse."""
    for page in pages_of(root):
        for command in commands_of(page):
            try:
                words = shlex.split(command, comments=True)
            except ValueError as error:
                yield f"{page.relative_to(root)}: {command}: {error}"
                continue
            for problem in unknown_options(" ".join(words), sources):
                yield f"{page.relative_to(root)}: {command}: {problem}"
            help_text = help_of(words[1])
            if help_text is None:
                yield f"{page.relative_to(root)}: {command}: occlude has no command {words[1]}"
                continue
            for word in words:
                option = word.split("=")[0]
                if OPTION.fullmatch(option) and help_text and not re.search(rf"{option}\b", help_text):
                    yield f"{page.relative_to(root)}: {command}: {words[1]} has no option {option}"


def help_by(program):
    """A function from a command to its help; to an empty text without a program, None if there is none."""
    known = {}

    def help_of(command):
        if program and command not in known:
            done = subprocess.run([program, command, "--help"], capture_output=True, text=True, check=False)
            known[command] = done.stdout if done.returncode == 0 else None
        return known.get(command, "") if program else ""

    return help_of


def unknown_files_in_headers(root, sources):
    """One sentence per file that the comment of a public header names and that does not exist."""
    for header in sorted((root / "occlude").rglob("*.h")):
        comments = re.findall(r"//+(.*)", header.read_text("utf-8"))
        for name in FILE.findall("\n".join(comments)):
            if not PLACEHOLDER.search(name) and not sources.has_file(name, header.parent):
                yield f"{header.relative_to(root)}: there is no file {name}"


# The headings of an algorithm's page, as far as they are the same for one algorithm and for two.
HEADINGS = ("## The idea", "## How to use ", "## Cost", "## When not to use ")


def undocumented_algorithms(root):
    """One sentence per page, heading or row that the documentation of an algorithm lacks."""
    pages = {page: page.read_text("utf-8") for page in sorted(root.glob("docs/algorithms/*.md"))}
    lists = [page for page in (root / "README.md", root / "docs" / "algorithms.md") if page.exists()]
    for header in sorted((root / "occlude" / "cull").glob("*.h")):
        for name in re.findall(r'\.name = "(\w+)"', header.read_text("utf-8")):
            mine = [page for page, text in pages.items() if re.match(rf"# .*\b{name}\b", text)]
            if not mine:
                yield f"docs/algorithms: no page is headed `# {name}`"
            for page in mine:
                for heading in HEADINGS:
                    if f"\n{heading}" not in pages[page]:
                        yield f"{page.relative_to(root)}: there is no heading `{heading.strip()}`"
            for page in lists:
                if not re.search(rf"^\| [`\[][^|]*\b{name}\b[^|]*\|", page.read_text("utf-8"), re.MULTILINE):
                    yield f"{page.relative_to(root)}: no row of a table begins with {name}"


def problems_of(root, program=None):
    """All problems, in a fixed order."""
    sources = Sources(root)
    return [
        *broken_links(root),
        *unknown_names(root, sources),
        *broken_commands(root, sources, help_by(program)),
        *unknown_files_in_headers(root, sources),
        *undocumented_algorithms(root),
    ]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parents[1])
    parser.add_argument("--program", help="the occlude program, to ask for its options")
    options = parser.parse_args(arguments)
    problems = problems_of(options.root, options.program)
    print("\n".join(problems) or "check_docs: all that is named exists")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
