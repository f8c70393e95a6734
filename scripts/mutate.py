#!/usr/bin/env python3
"""Applies deliberate one-line bugs, each of which a test must catch.

usage: mutate.py [--check] [NAME...]

scripts/mutations.toml lists the bugs: a file, the text before, the text after, and the tests that
must fail. The text is the key, so that the list survives edits elsewhere in the file. Each bug is
applied to a copy of the sources in build-mutate/, the one test program that must notice is built,
the named tests run, and the copy is restored. The working tree is never touched. The copy is
compiled as `./dev test` compiles, so that with ccache only the changed files are compiled.

--check only asserts that every text before occurs exactly once: a fast test.

Exit status 0 if every bug was caught, 1 if one survived or the list is stale, 2 for wrong use.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPY = ROOT / "build-mutate"
BUILD = COPY / "build"  # relative paths are those of build/, and with them ccache's keys
FOLDERS = ["occlude", "tests", "cmake", "scripts"]
TIMEOUT_S = 300


def load():
    with open(ROOT / "scripts" / "mutations.toml", "rb") as file:
        return tomllib.load(file)["mutation"]


def problems(mutations):
    """Sentences about entries that do not fit the sources."""
    found = []
    names = [m["name"] for m in mutations]
    for name in sorted({n for n in names if names.count(n) > 1}):
        found.append(f"{name}: there are two of that name")
    for m in mutations:
        path = ROOT / m["file"]
        if not path.is_file():
            found.append(f"{m['name']}: {m['file']} does not exist")
            continue
        count = path.read_text(encoding="utf-8").count(m["before"])
        if count != 1:
            found.append(f"{m['name']}: its text is {count} times in {m['file']}, not once")
        if m["before"] == m["after"]:
            found.append(f"{m['name']}: it changes nothing")
    return found


def copy_sources():
    """Brings the copy up to date without touching files that are the same."""
    for folder in FOLDERS:
        for source in (ROOT / folder).rglob("*"):
            target = COPY / source.relative_to(ROOT)
            if source.is_file() and not (
                target.is_file() and target.read_bytes() == source.read_bytes()
            ):
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, target)
    shutil.copyfile(ROOT / "CMakeLists.txt", COPY / "CMakeLists.txt")


def launcher():
    """ccache, unless the environment names another launcher."""
    if "CMAKE_CXX_COMPILER_LAUNCHER" in os.environ or not shutil.which("ccache"):
        return []
    return ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"]


def configure():
    subprocess.run(
        ["cmake", "-G", "Ninja", "-S", COPY, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release",
         "-DOCCLUDE_GL=OFF", "-DOCCLUDE_C=OFF", "-DOCCLUDE_TOOLS=OFF", "-DOCCLUDE_EXAMPLES=OFF",
         "-DOCCLUDE_INSTALL=OFF", *launcher(),
         "--log-level=ERROR"],
        check=True,
    )  # fmt: skip


def build(program):
    return subprocess.run(
        ["cmake", "--build", BUILD, "--target", program], capture_output=True, text=True
    )


def failing(program, tests):
    """The names of failing tests, or what else went wrong; empty if all passed."""
    command = [BUILD / "bin" / program, f"--gtest_filter={tests}", "--gtest_brief=1"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return ["(hangs)"]
    lines = [line for line in done.stdout.splitlines() if line.startswith("[  FAILED  ] ")]
    names = sorted({line.split("] ")[1].split(",")[0].split(" ")[0] for line in lines})
    names = [name for name in names if "." in name]
    return names or (["(crashes)"] if done.returncode != 0 else [])


def verdict(mutation):
    """What caught the bug, or an empty list."""
    path = COPY / mutation["file"]
    original = path.read_text(encoding="utf-8")
    path.write_text(original.replace(mutation["before"], mutation["after"]), encoding="utf-8")
    try:
        built = build(mutation["program"])
        if built.returncode != 0:
            return ["(does not compile)"]
        return failing(mutation["program"], mutation["tests"])
    finally:
        path.write_text(original, encoding="utf-8")


def run(mutations):
    copy_sources()
    configure()
    for program in sorted({m["program"] for m in mutations}):
        built = build(program)
        if built.returncode != 0:
            sys.exit(f"mutate: {program} does not build:\n{built.stdout[-3000:]}")
    survivors = 0
    for m in mutations:
        caught = verdict(m)
        # A bug that the compiler refuses says nothing about the tests.
        good = caught and caught != ["(does not compile)"]
        survivors += 0 if good else 1
        print(f"{'caught  ' if good else 'SURVIVED'}  {m['name']}: {', '.join(caught[:3])}", flush=True)
    print(f"{len(mutations) - survivors} of {len(mutations)} bugs were caught")
    return 1 if survivors else 0


def main(arguments):
    mutations = load()
    stale = problems(mutations)
    if stale:
        print("\n".join(stale))
        return 1
    if arguments[:1] == ["--check"]:
        print(f"mutate: {len(mutations)} bugs fit the sources")
        return 0
    unknown = set(arguments) - {m["name"] for m in mutations}
    if unknown:
        print(f"mutate: no such bug: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    return run([m for m in mutations if not arguments or m["name"] in arguments])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
