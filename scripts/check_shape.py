#!/usr/bin/env python3
"""The shape of the sources: what a reader can hold in mind at once.

    files      at most 400 lines, or a line "Long because: REASON" in the comment at the head
    functions  at most 60 lines between their braces
    classes    at most 15 data members (a struct is plain data and may have more)
    includes   no file includes itself through others

usage: check_shape.py [ROOT]      ROOT is the repository; by default the one this script is in.

Prints one line per violation, as file:line: sentence. Exit status 0 if there is none, 1 otherwise.
The check relies on the layout that clang-format gives: the brace of a function stands alone on its line.
"""

import re
import sys
from pathlib import Path

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
MAX_DATA_MEMBERS = 15
FOLDERS = ("adapters", "occlude", "tools", "examples", "tests", "benchmarks")

# What breaks a rule still: (file, rule). Nothing may be added.
STILL_LONG = set()

REASON = re.compile(r"^//\s+Long because: \S+")
CLASS = re.compile(r"^(?P<indent> *)class (?:\[\[\w+\]\] )?(?P<name>[\w:]+)(?: final)?(?: : .*)? ?\{$")
INCLUDE = re.compile(r'^#include [<"]([^>"]+)[>"]')
NO_MEMBER = re.compile(r"^(using|friend|static|typedef|template|enum|struct|class|public|private|protected|explicit|virtual)\b")


def without_comments(text):
    """The text with comments and the insides of strings blanked; lines keep their numbers."""

    def blank(match):
        token = match.group(0)
        if token.startswith("/"):
            return re.sub(r"[^\n]", " ", token)
        return token[0] + token[-1]

    token = r'R"\((?:.|\n)*?\)"|//[^\n]*|/\*(?:.|\n)*?\*/|(?<!include )"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\''
    return re.sub(token, lambda m: re.sub(r"[^\n]", " ", m[0]) if m[0].startswith("R") else blank(m), text)


def head_gives_reason(lines):
    """True if the comment that opens the file says why the file is long."""
    for line in lines:
        if not line.startswith("//"):
            return False
        if REASON.match(line):
            return True
    return False


def long_functions(lines):
    """(line, length) of every function body that is too long."""
    for start, line in enumerate(lines):
        opening = re.fullmatch(r"( *)\{", line)
        if not opening:
            continue
        closing = re.compile(rf"{opening[1]}\}}")
        end = next((i for i in range(start + 1, len(lines)) if closing.match(lines[i])), start)
        if end - start - 1 > MAX_FUNCTION_LINES:
            yield start + 1, end - start - 1


def is_data_member(declaration):
    """True for the declaration of a variable in the body of a class."""
    text = re.sub(r"\s+", " ", declaration).strip()
    if NO_MEMBER.match(text) or text.startswith("~"):
        return False
    while (shorter := re.sub(r"<[^<>]*>", "", text)) != text:
        text = shorter
    text = re.split(r" = |\{", text)[0]
    return "(" not in text and "operator" not in text and len(text.rstrip(";").split()) >= 2


def large_classes(lines):
    """(line, name, members) of every class with too many data members."""
    for start, line in enumerate(lines):
        opening = CLASS.match(line.rstrip())
        if not opening:
            continue
        inner = opening["indent"] + "    "
        members, declaration = 0, ""
        for body in lines[start + 1 :]:
            if body.startswith(opening["indent"] + "};"):
                break
            at_level = body.startswith(inner) and not body.startswith(inner + " ")
            if at_level and not declaration and body.rstrip().endswith("{"):
                continue  # a nested type or a function: its body is deeper
            if at_level and body.strip() in ("}", "};", "{"):
                declaration = ""
                continue
            if at_level or declaration:
                declaration += body
            if declaration.rstrip().endswith(";"):
                members += is_data_member(declaration)
                declaration = ""
            elif declaration.rstrip().endswith(("}", "{", ":")):
                declaration = ""
        if members > MAX_DATA_MEMBERS:
            yield start + 1, opening["name"], members


def check_file(root, name):
    """(rule, sentence) for every violation within one file."""
    text = (root / name).read_text(encoding="utf-8")
    lines = text.splitlines()
    if len(lines) > MAX_FILE_LINES and not head_gives_reason(lines):
        yield "file", (
            f"{name}:1: has {len(lines)} lines: split it, or give the reason in the comment at its head "
            '("Long because: ...")'
        )
    code = without_comments(text).splitlines()
    for line, length in long_functions(code):
        yield "function", f"{name}:{line}: this function has {length} lines; the limit is {MAX_FUNCTION_LINES}"
    for line, class_name, members in large_classes(code):
        yield "class", (
            f"{name}:{line}: class {class_name} has {members} data members; the limit is {MAX_DATA_MEMBERS}"
        )


def includes_of(root, name, files):
    """The files among `files` that `name` includes."""
    for line in (root / name).read_text(encoding="utf-8").splitlines():
        match = INCLUDE.match(line)
        if not match:
            continue
        for base in ("", "tools", "tests", str(name.parent)):
            target = Path(base) / match[1]
            if target in files:
                yield target
                break


def circles(root, files):
    """A sentence for each include that closes a circle."""
    graph = {name: sorted(set(includes_of(root, name, files))) for name in files}
    state = {}
    for first in sorted(files):
        stack = [(first, iter(graph[first]))]
        if first in state:
            continue
        state[first] = "open"
        while stack:
            name, rest = stack[-1]
            target = next(rest, None)
            if target is None:
                state[name] = "done"
                stack.pop()
            elif state.get(target) == "open":
                yield f"{name}:1: includes {target}, which includes it again"
            elif target not in state:
                state[target] = "open"
                stack.append((target, iter(graph[target])))


def check_tree(root, still_long=None):
    """All violations in a fixed order, and the number of files read."""
    accepted = STILL_LONG if still_long is None else still_long
    files = sorted(
        path.relative_to(root)
        for folder in FOLDERS
        for path in (root / folder).rglob("*")
        if path.suffix in (".h", ".cpp")
    )
    problems = []
    for name in files:
        for rule, sentence in check_file(root, name):
            if (str(name), rule) not in accepted:
                problems.append(sentence)
    problems += circles(root, set(files))
    return problems, len(files)


def main(arguments):
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parent.parent
    problems, file_count = check_tree(root)
    if file_count == 0:
        problems = [f"{root}: there is no source under {', '.join(FOLDERS)}"]
    print("\n".join(problems) if problems else f"check_shape: {file_count} files keep their shape")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
