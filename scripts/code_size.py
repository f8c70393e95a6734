#!/usr/bin/env python3
"""Measures the bytes of code of each algorithm that is linked alone; writes docs/measurements/size.md.

usage: code_size.py LIBRARY        LIBRARY: a static release build, such as build/occlude/libocclude.a

Links a program for each algorithm: a hierarchy from arrays, a device that does nothing, the algorithm.
Its size is what such a program has more than an empty one, code and constants, without what is shared
with the C++ runtime, oneTBB and Highway.
"""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

EMPTY = "int main() { return 0; }\n"

DEVICE = """
struct Device final : occlude::QueryDevice {
    occlude::DeviceCaps c;
    const occlude::DeviceCaps& caps() const override { return c; }
    void begin_frame(const occlude::View&) override {}
    void draw(std::span<const occlude::ItemId>, occlude::DrawPass) override {}
    void query(const occlude::QueryBatch&, std::span<occlude::Ticket>) override {}
    void flush() override {}
    occlude::Answer poll(occlude::Ticket) override { return occlude::Answer::lost(); }
    occlude::Answer wait(occlude::Ticket) override { return occlude::Answer::lost(); }
    void end_frame() override {}
};
"""


def program(header: str, type_name: str) -> str:
    return f"""#include <occlude/cull/{header}>
{DEVICE}
int main()
{{
    const occlude::Hierarchy tree = occlude::Hierarchy::from_arrays({{}}, {{}}, {{}});
    Device device;
    occlude::{type_name} culler(tree);
    return static_cast<int>(culler.cull(occlude::View(), device).counters.items_drawn);
}}
"""


def builder(header: str, call: str) -> str:
    return f"""#include <occlude/hierarchy/builders/{header}>
int main()
{{
    const std::vector<occlude::ItemBounds> items(10);
    return static_cast<int>(occlude::{call}(items).items().size());
}}
"""


def bytes_of(source: str, library: str, folder: Path) -> int:
    path = folder / "main.cpp"
    path.write_text(source)
    out = folder / "main"
    subprocess.run(["c++", "-std=c++20", "-O2", "-DNDEBUG", f"-I{ROOT}", path, library, "-ltbb", "-lhwy",
                    "-Wl,--gc-sections,--as-needed", "-o", out], check=True)
    text, data, _ = subprocess.run(["size", out], check=True, text=True,
                                   stdout=subprocess.PIPE).stdout.splitlines()[1].split()[:3]
    return int(text) + int(data)


def algorithms() -> list[tuple[str, str]]:
    """Header and class of every culler that is made from a hierarchy alone."""
    found = []
    for path in sorted((ROOT / "occlude/cull").glob("*.h")):
        for name in re.findall(r"^class (\w+) final : public Culler", path.read_text(), re.MULTILINE):
            found.append((path.name, name))
    return found


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    library = sys.argv[1]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, text=True,
                            stdout=subprocess.PIPE, check=True).stdout.strip()
    compiler = subprocess.run(["c++", "--version"], text=True, stdout=subprocess.PIPE,
                              check=True).stdout.splitlines()[0]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        base = bytes_of(EMPTY, library, folder)
        rows = [(cls, header, bytes_of(program(header, cls), library, folder) - base)
                for header, cls in algorithms()]
        builders = [(call, header, bytes_of(builder(header, call), library, folder) - base)
                    for call, header in (("build_bvh", "bvh_builder.h"), ("build_bsp", "bsp_builder.h"),
                                         ("build_octree", "octree_builder.h"), ("build_grid", "grid_builder.h"),
                                         ("build_two_level", "two_level.h"))]
    lines = [
        "# Code size",
        "",
        "Bytes of code and constants that one algorithm brings when a program links it alone, with the tree and the view",
        "that it needs; and one builder of trees.",
        "",
        f"Made by `scripts/code_size.py build/occlude/libocclude.a` at {commit}, {time.strftime('%Y-%m-%d')}, with {compiler}, x86-64.",
        "",
        "| alone | header | bytes |",
        "|---|---|---|",
    ]
    lines += [f"| `{name}` | `cull/{header}` | {size:,} |" for name, header, size in sorted(rows, key=lambda r: r[2])]
    lines += [f"| `{name}` | `hierarchy/builders/{header}` | {size:,} |"
              for name, header, size in sorted(builders, key=lambda r: r[2])]
    (ROOT / "docs/measurements/size.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
