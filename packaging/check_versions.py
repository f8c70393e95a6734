#!/usr/bin/env python3
"""What the packages repeat of the project: its version, its CMake options, the functions of its C library.

usage: check_versions.py

Prints a line per disagreement with CMakeLists.txt and the headers of occlude/c. Exit status 0 if there is
none, 1 otherwise.
"""

import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def read(path: str) -> str:
    return (ROOT / path).read_text()


def first(pattern: str, path: str) -> str:
    found = re.search(pattern, read(path), re.MULTILINE)
    return found.group(1) if found else ""


def problems() -> list[str]:
    found = []
    version = first(r"project\(occlude VERSION (\S+)", "CMakeLists.txt")
    for path, stated in {
        "packaging/debian/changelog": first(r"^occlude \(([^)]+)\)", "packaging/debian/changelog"),
        "packaging/vcpkg/occlude/vcpkg.json": json.loads(read("packaging/vcpkg/occlude/vcpkg.json"))["version"],
        "packaging/conan/conanfile.py": first(r'^    version = "(.*)"', "packaging/conan/conanfile.py"),
    }.items():
        if stated != version:
            found.append(f"{path}: version {stated or 'is missing'}; CMakeLists.txt says {version}")

    options = set(re.findall(r"option\(OCCLUDE_(\w+)", read("CMakeLists.txt")))
    named = {
        "packaging/vcpkg/occlude/portfile.cmake": set(
            re.findall(r"OCCLUDE_(\w+)", read("packaging/vcpkg/occlude/portfile.cmake"))),
        "packaging/debian/rules": set(re.findall(r"-DOCCLUDE_(\w+)", read("packaging/debian/rules"))),
        "packaging/conan/conanfile.py": {
            name.upper()
            for names in re.findall(r"for (?:option|part) in \(([^)]*)\):", read("packaging/conan/conanfile.py"))
            for name in re.findall(r'"(\w+)"', names)
        },
    }
    for path, names in named.items():
        if not names:
            found.append(f"{path}: names no option of CMakeLists.txt")
        found += [f"{path}: there is no option OCCLUDE_{name}" for name in sorted(names - options)]

    headers = "".join(path.read_text() for path in sorted((ROOT / "occlude/c").glob("*.h")))
    header = re.sub(r"/\*.*?\*/", "", headers, flags=re.DOTALL)
    declared = set(re.findall(r"OCCLUDE_C_API[^;]*?\b(occlude_\w+)\(", header))
    listed = set(re.findall(r"^ (occlude_\w+)@OCCLUDE_1 ", read("packaging/debian/libocclude1.symbols"), re.MULTILINE))
    found += [f"packaging/debian/libocclude1.symbols: lacks {name}" for name in sorted(declared - listed)]
    found += [f"packaging/debian/libocclude1.symbols: {name} is not in the header" for name in sorted(listed - declared)]
    return found


def main() -> int:
    lines = problems()
    for line in lines:
        print(line)
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
