#!/usr/bin/env python3
"""Reads every model of a folder with `occlude info`, and writes a table of the results.

usage: check_models.py [--program build/bin/occlude] [--models /usr/share/assimp/models]
                       [--out docs/measurements/models.md] [--verify] [--only TEXT]

The models are those of the Debian package assimp-testmodels. A file fails if the program crashes,
hangs, or refuses it without naming it; a glTF 2.0 file also if its triangles are not those that
this script counts in its JSON. With --verify, files of over 20 objects or 10,000 triangles are
drawn culled and unculled, at 1 and 4 samples a pixel, and must not differ.
Exit status 0 if no file failed, 1 otherwise.
"""

import argparse
import json
import re
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Files that models refer to, and texts about them.
COMPANIONS = {"", ".png", ".jpg", ".jpeg", ".tga", ".bmp", ".txt", ".bin", ".mtl", ".glsl", ".vert",
              ".frag", ".material", ".md", ".gz", ".skeleton", ".source", ".dds", ".gif", ".pcx"}
INFO_SECONDS = 120
VERIFY_SECONDS = 600
TRIANGLES_OF_MODE = {4: lambda n: n // 3, 5: lambda n: max(n - 2, 0), 6: lambda n: max(n - 2, 0)}


def gltf_json(path):
    """The JSON of a glTF 2.0 file, or nothing."""
    data = path.read_bytes()
    try:
        if data[:4] == b"glTF":
            if struct.unpack("<I", data[4:8])[0] != 2:
                return None
            size = struct.unpack("<I", data[12:16])[0]
            data = data[20:20 + size]
        root = json.loads(data.decode("utf-8-sig"))
    except (ValueError, struct.error):
        return None
    is_2 = isinstance(root, dict) and str(root.get("asset", {}).get("version", "")).startswith("2")
    return root if is_2 else None


def count_triangles(root):
    """Triangles of the default scene, by the counts of accessors alone."""
    accessors, meshes, nodes = (root.get(key, []) for key in ("accessors", "meshes", "nodes"))

    def of_primitive(primitive):
        if "POSITION" not in primitive.get("attributes", {}):
            return 0
        source = primitive.get("indices", primitive["attributes"]["POSITION"])
        count = TRIANGLES_OF_MODE.get(primitive.get("mode", 4), lambda n: 0)
        return count(accessors[source]["count"])

    of_mesh = [sum(map(of_primitive, mesh["primitives"])) for mesh in meshes]
    if root.get("scenes"):
        open_nodes = list(root["scenes"][root.get("scene", 0)].get("nodes", []))
    else:
        children = {child for node in nodes for child in node.get("children", [])}
        open_nodes = [i for i in range(len(nodes)) if i not in children]
    total = 0
    while open_nodes:
        node = nodes[open_nodes.pop()]
        extensions = node.get("extensions", {})
        if not extensions.get("KHR_node_visibility", {}).get("visible", True):
            continue
        placed = extensions.get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        copies = min((accessors[a]["count"] for a in placed.values()), default=1)
        total += copies * of_mesh[node["mesh"]] if "mesh" in node else 0
        open_nodes += node.get("children", [])
    return total


def number(text):
    return int(text.replace(",", ""))


def run(command, seconds):
    """Exit status, output and seconds; a status of None: it was stopped."""
    start = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace",
                              timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return None, "", time.monotonic() - start
    return done.returncode, done.stdout + done.stderr, time.monotonic() - start


class Outcome:
    """What became of one file."""

    def __init__(self, name):
        self.name = name
        self.kind = ""
        self.detail = ""
        self.objects = self.triangles = self.in_file = 0
        self.failure = ""
        self.differing = {}


def inspect(program, path, name):
    outcome = Outcome(name)
    command = [program, "info", str(path), "--device", "cpu", "--size", "64x64", "--frames", "1",
               "--load-seconds", "30", "--cache", ""]
    status, text, _ = run(command, INFO_SECONDS)
    if status is None:
        outcome.kind = outcome.failure = "hangs"
    elif status == 2:
        outcome.kind = "refused"
        message = text.strip().splitlines()[-1] if text.strip() else ""
        outcome.detail = message.removeprefix("occlude: ").replace(str(path) + ": ", "")
        if str(path) not in message:
            outcome.failure = "is refused without its name"
    elif status != 0:
        outcome.kind = "crashes"
        outcome.failure = f"ends with {status}"
    else:
        outcome.kind = "read"
        outcome.objects = number(re.search(r"objects +([\d,]+)", text)[1])
        drawn = re.search(r"\n  triangles +([\d,]+)(?: of ([\d,]+) in the file)?", text)
        outcome.triangles = number(drawn[1])
        outcome.in_file = number(drawn[2]) if drawn[2] else outcome.triangles
        lost = re.search(r"left out +(.*(?:\n {20}.*)*)", text)
        outcome.detail = "left out: " + "; ".join(
            line.strip() for line in lost[1].splitlines()) if lost else ""
        root = gltf_json(path)
        if root is not None and count_triangles(root) != outcome.in_file:
            outcome.failure = f"has {count_triangles(root)} triangles, not {outcome.in_file}"
    return outcome


def verify(program, path, outcome):
    for samples in (1, 4):
        with tempfile.NamedTemporaryFile(suffix=".json") as results:
            command = [program, "verify", str(path), "--algorithms", "exact", "--frames", "4",
                       "--path", "auto", "--size", "640x360", "--msaa", str(samples),
                       "--nothing-hidden-is-fine", "--json", results.name]
            status, text, _ = run(command, VERIFY_SECONDS)
            if status not in (0, 1):
                outcome.failure = f"verify ends with {status}: {text.strip()[-200:]}"
                return
            document = json.load(open(results.name, encoding="utf-8"))
        outcome.differing[samples] = sum(r["differing_pixels"] or 0 for r in document["runs"]
                                         if r["guarantee"] == "exact")
        if outcome.differing[samples]:
            outcome.failure = f"differs in {outcome.differing[samples]} pixels at {samples} samples"


def table(outcomes, models):
    read = [o for o in outcomes if o.kind == "read"]
    refused = [o for o in outcomes if o.kind == "refused"]
    checked = [o for o in outcomes if o.differing]
    lines = [
        "# Models of others",
        "",
        f"Every model of the Debian package assimp-testmodels (`{models}`), read by `occlude info`. Generated by",
        "`scripts/check_models.py --verify --out docs/measurements/models.md`; do not edit.",
        "",
        "Triangles of glTF 2.0 files are compared with the counts that their JSON gives. *Left out*, *drawn once* and why: see",
        "[scenes](../scenes.md#what-is-left-out). Files with over 20 objects or 10,000 triangles are verified: all exact algorithms,",
        "4 frames of the path `auto` at 640x360, with 1 and with 4 samples a pixel.",
        "",
        f"{len(outcomes)} files: {len(read)} read, {len(refused)} refused with a reason, "
        f"{sum(o.kind == 'crashes' for o in outcomes)} crashes, "
        f"{sum(o.kind == 'hangs' for o in outcomes)} hangs. "
        f"{len(checked)} files were verified: "
        f"{sum(sum(o.differing.values()) for o in checked)} differing pixels.",
        "",
        "| file | outcome | objects | triangles | differing pixels, at 1 and 4 samples | why, or what was left out |",
        "|---|---|---|---|---|---|",
    ]
    for o in outcomes:
        detail = (o.detail + ("; **" + o.failure + "**" if o.failure else "")).replace("|", "\\|")
        counts = f"{o.objects:,} | {o.triangles:,}" if o.kind == "read" else " | "
        pixels = ", ".join(str(n) for n in o.differing.values())
        lines.append(f"| {o.name} | {o.kind} | {counts} | {pixels} | {detail} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/bin/occlude")
    parser.add_argument("--models", type=Path, default=Path("/usr/share/assimp/models"))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--verify", action="store_true")
    parser.add_argument("--only", default="", help="files whose name holds this text")
    options = parser.parse_args()
    files = [p for p in sorted(options.models.rglob("*"))
             if p.is_file() and p.suffix.lower() not in COMPANIONS and options.only in str(p)]
    outcomes = []
    for path in files:
        outcome = inspect(options.program, path, str(path.relative_to(options.models)))
        if options.verify and outcome.kind == "read" and (
                outcome.objects > 20 or outcome.triangles > 10000):
            verify(options.program, path, outcome)
        if outcome.failure:
            print(f"{outcome.name}: {outcome.failure}", file=sys.stderr)
        outcomes.append(outcome)
    if options.out:
        options.out.write_text(table(outcomes, options.models), encoding="utf-8")
    failed = sum(bool(o.failure) for o in outcomes)
    print(f"{len(outcomes)} files, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
