#!/usr/bin/env python3
"""The dependency law of the library and of the program, as docs/architecture.md states it.

    core <- screen <- hierarchy <- hierarchy/builders <- scene
                      hierarchy <- cull/parts <- cull/adaptive <- cull
    core <- screen <- effects <- device; core <- screen <- backends/*, conformance   (none sees an algorithm)
    cull <- integration (helpers of whoever integrates the library)
    cull <- c                                         (the C interface)
    files <- model <- load, walk <- generate ; model <- render <- measure <- report <- suites, session <- commands

usage: check_includes.py [ROOT]      ROOT is the repository; by default the one this script is in.

Prints one line per violation, as file:line: sentence. Exit status 0 if there is none, 1 otherwise.
"""

import re
import sys
from pathlib import Path

# Which rooms a room may include, itself always among them.
ALLOWED = {
    "core": {"core"},
    "screen": {"core", "screen"},
    "hierarchy": {"core", "screen", "hierarchy"},
    "hierarchy/builders": {"core", "screen", "hierarchy", "hierarchy/builders"},
    "scene": {"core", "screen", "hierarchy", "hierarchy/builders", "scene"},
    "cull/parts": {"core", "screen", "hierarchy", "cull/parts"},
    "cull/adaptive": {"core", "screen", "hierarchy", "cull/parts", "cull/adaptive"},
    "cull": {
        "core", "screen", "hierarchy", "hierarchy/builders", "cull/parts", "cull/adaptive", "cull",
    },
    "integration": {
        "core", "screen", "hierarchy", "hierarchy/builders", "cull/parts", "cull/adaptive", "cull",
        "integration",
    },
    "effects": {"core", "screen", "hierarchy", "effects"},
    "device": {"core", "screen", "effects", "device"},
    "c": {
        "core", "screen", "hierarchy", "hierarchy/builders", "scene", "cull/parts", "cull", "backends/cpu_fast", "c",
    },
    "conformance": {"core", "screen", "conformance"},
    "backends/gl": {"core", "screen", "backends/gl"},
    "backends/cpu": {"core", "screen", "backends/cpu"},
    "backends/cpu_fast": {"core", "screen", "backends/cpu_fast"},
    None: {"backends/cpu_fast"},  # front doors: headers right below occlude/
}  # fmt: skip

# The same for the folders of tools/. All of them may include the library.
TOOLS_ALLOWED = {
    "files": {"files"},
    "model": {"files", "model"},
    "load": {"files", "model", "load"},
    "walk": {"files", "model", "walk"},
    "generate": {"files", "model", "load", "walk", "generate"},
    "options": {"model", "options"},
    "render": {"files", "model", "render"},
    "measure": {"files", "model", "render", "measure"},
    "report": {"files", "model", "measure", "report"},
    "replay": {"files", "model", "render", "measure", "replay"},
    "suites": {"files", "model", "options", "measure", "report", "suites"},
    "session": {
        "files", "model", "load", "walk", "generate", "options", "render", "measure", "report",
        "session",
    },
    "viewer": {
        "files", "model", "load", "walk", "generate", "options", "render", "measure", "report",
        "session", "viewer",
    },
    "commands": {
        "files", "model", "load", "walk", "generate", "options", "render", "measure", "report",
        "suites", "replay", "session", "viewer", "commands",
    },
}  # fmt: skip

# Third-party and system includes that the sources and the detail/ headers of a room may use beside GLM.
THIRD_PARTY = {
    "screen": ("hwy/",),
    "hierarchy": ("sys/mman.h",),
    "hierarchy/builders": ("tbb/", "oneapi/tbb/", "sys/mman.h"),
    "scene": ("tbb/", "oneapi/tbb/"),
    "backends/gl": ("epoxy/", "EGL/", "KHR/"),
    "backends/cpu": ("tbb/", "oneapi/tbb/", "hwy/"),
    "backends/cpu_fast": ("tbb/", "oneapi/tbb/", "hwy/"),
}

# What cull/ must not even name: files, threads, clocks, and randomness other than core/rng.h.
IMPURE_HEADERS = {
    "atomic", "barrier", "chrono", "condition_variable", "cstdio", "ctime", "execution",
    "filesystem", "fstream", "future", "iostream", "latch", "mutex", "random", "semaphore",
    "shared_mutex", "stdio.h", "stop_token", "thread", "time.h",
}  # fmt: skip
GRAPHICS_API = re.compile(
    r"\b(gl[A-Z]\w+|GL_[A-Z]\w+|GL(?:u?int|enum|sync|sizei)|egl[A-Z]\w+|EGL\w+"
    r"|vk[A-Z]\w+|Vk[A-Z]\w+|VK_\w+|ID3D\w+|OpenGL)\b"
)
MUTABLE_GLOBAL = re.compile(
    r"^\s*(?:inline\s+static|static|inline|thread_local|extern)\b"
    r"(?!.*\b(?:const|constexpr|consteval|constinit\s+const)\b)[^(]*(?:;|=|\{)\s*"
)

INCLUDE = re.compile(r'^\s*#\s*include\s*(?P<open>[<"])(?P<path>[^>"]+)[>"]')
STANDARD = re.compile(r"^[a-z0-9_]+(\.h)?$")


def room_of(path):
    """The room of a path below occlude/: its folder without detail/; None for the top."""
    folders = [part for part in Path(path).parts[:-1] if part != "detail"]
    return "/".join(folders) or None


def in_cull(room):
    """True for the rooms that decide, which must repeat exactly."""
    return room is not None and room.split("/")[0] == "cull"


def code_lines(text):
    """The lines of a source file without comments and string contents; numbering is kept."""

    def blank(match):
        token = match.group(0)
        if token.startswith("/"):
            return re.sub(r"[^\n]", " ", token)
        return token[0] + token[-1]

    token = r'//[^\n]*|/\*.*?\*/|(?<!include )(?<!include)"(?:\\.|[^"\\\n])*"'
    return re.sub(token, blank, text, flags=re.DOTALL).splitlines()


def check_include(root, name, room, match):
    """What is wrong with one include of the file `name`, or None."""
    path = match["path"]
    if match["open"] == '"':
        return f'"{path}": write it as <occlude/...>, so that it means the same everywhere'
    if path.startswith("occlude/"):
        target = room_of(path.removeprefix("occlude/"))
        if not (root / path).is_file():
            return f"<{path}> does not exist"
        if target not in ALLOWED[room]:
            return f"{room} must not include {target} (<{path}>)"
        return None
    if path.startswith("glm/"):
        return None
    if STANDARD.match(path):
        if in_cull(room) and path in IMPURE_HEADERS:
            return f"cull must not use files, threads or clocks (<{path}>)"
        return None
    if path.startswith(THIRD_PARTY.get(room, ())):
        return None if private(name) else f"a public header must include GLM and std only (<{path}>)"
    return f"{room} must not use <{path}>"


def check_file(root, name):
    """Sentences about one file, `name` being its path below `root`."""
    room = room_of(name.relative_to("occlude"))
    if room not in ALLOWED:
        return [f"{name}:1: this folder is not a room of the library; see docs/architecture.md"]
    problems = []
    for number, line in enumerate(code_lines((root / name).read_text(encoding="utf-8")), 1):
        include = INCLUDE.match(line)
        sentence = None
        if include:
            sentence = check_include(root, name, room, include)
        elif in_cull(room) and (api := GRAPHICS_API.search(line)):
            sentence = f"cull must not name a graphics API ({api[0]})"
        elif in_cull(room) and MUTABLE_GLOBAL.match(line):
            sentence = "cull must not have variables that outlive a culler"
        if sentence:
            problems.append(f"{name}:{number}: {sentence}")
    return problems


def check_tools_file(root, name):
    """Sentences about one file of the program; its includes in quotes start at tools/."""
    folder = name.parts[1] if len(name.parts) > 2 else None
    if folder is None:
        return []  # main.cpp puts everything together
    if folder not in TOOLS_ALLOWED:
        return [f"{name}:1: this folder is not a room of the program; see docs/architecture.md"]
    problems = []
    for number, line in enumerate(code_lines((root / name).read_text(encoding="utf-8")), 1):
        include = INCLUDE.match(line)
        if not include or include["open"] == "<":
            continue
        path = include["path"]
        target = path.split("/")[0]
        if not (root / "tools" / path).is_file():
            problems.append(f'{name}:{number}: "{path}" does not exist below tools/')
        elif target not in TOOLS_ALLOWED[folder]:
            problems.append(f'{name}:{number}: tools/{folder} must not include tools/{target} ("{path}")')
    return problems


def check_adapter_file(root, name):
    """Sentences about one file of an adapter, which sees of the library what is installed."""
    problems = []
    for number, path in includes_of(root, name):
        if not path.startswith("occlude/"):
            continue
        own = Path(*name.parts[:2]) / path
        if not (root / path).is_file() and not (root / own).is_file():
            problems.append(f"{name}:{number}: <{path}> does not exist")
        elif "detail" in Path(path).parts:
            problems.append(f"{name}:{number}: adapters see the headers that are installed, not <{path}>")
    return problems


def private(name):
    """True for files that users of the library never include."""
    return name.suffix == ".cpp" or "detail" in name.parts


def includes_of(root, name):
    """(line number, path) of each include in angle brackets of a file."""
    for number, line in enumerate(code_lines((root / name).read_text(encoding="utf-8")), 1):
        match = INCLUDE.match(line)
        if match and match["open"] == "<":
            yield number, match["path"]


def third_party_reached(root, name, known):
    """The third-party include that a header reaches, itself or through others, or None."""
    if name not in known:
        known[name] = None  # ends the search in circles
        for _, path in includes_of(root, name):
            if path.startswith(THIRD_PARTY.get(room_of(name.relative_to("occlude")), ())):
                known[name] = path
            elif path.startswith("occlude/") and (root / path).is_file():
                known[name] = third_party_reached(root, Path(path), known)
            if known[name]:
                break
    return known[name]


def check_reach(root, name, known):
    """Sentences about a public header that reaches third-party headers through private ones."""
    for number, path in includes_of(root, name):
        if path.startswith("occlude/") and private(Path(path)) and (root / path).is_file():
            reached = third_party_reached(root, Path(path), known)
            if reached:
                yield f"{name}:{number}: a public header must not reach <{reached}> through <{path}>"


def sources_below(root, folder):
    """The sources and headers below root/folder, in a fixed order."""
    return sorted(
        path.relative_to(root)
        for path in (root / folder).rglob("*")
        if path.suffix in (".h", ".cpp")
    )


def check_tree(root):
    """All violations below occlude/, tools/ and adapters/, in a fixed order, and the number of files read."""
    files = sources_below(root, "occlude")
    tools = sources_below(root, "tools")
    adapters = sources_below(root, "adapters")
    problems = [problem for name in files for problem in check_file(root, name)]
    problems += [problem for name in tools for problem in check_tools_file(root, name)]
    problems += [problem for name in adapters for problem in check_adapter_file(root, name)]
    known = {}
    for name in files:
        if not private(name):
            problems += check_reach(root, name, known)
    return problems, len(files) + len(tools) + len(adapters)


def main(arguments):
    root = Path(arguments[0]) if arguments else Path(__file__).resolve().parent.parent
    problems, file_count = check_tree(root)
    if file_count == 0:
        problems = [f"{root}: there is no source under occlude/"]
    print("\n".join(problems) if problems else f"check_includes: {file_count} files obey the law")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
