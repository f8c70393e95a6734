#!/usr/bin/env python3
"""Depth by tiles hides nearly as much as depth by pixels, and every pixel stays right.

usage: tiles_ratio_test.py PROGRAM

On a small city, 1280x720, software depth: two_phase from tiles of 8 and 16 pixels draws at most 1.10
times the triangles that it draws from pixels.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

MOST = 1.10


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "bench.json"
        subprocess.run(
            [sys.argv[1], "bench", "city:blocks=8,triangles=300k,seed=2", "--device", "cpu", "--path", "street",
             "--frames", "4", "--size", "1280x720", "--verify", "--json", str(out),
             "--algorithms", "two_phase,two_phase:tile=8,two_phase:tile=16"],
            check=True, stdout=subprocess.DEVNULL)
        runs = {run["algorithm"]: run for run in json.loads(out.read_text())["runs"]}
    pixels = runs["two_phase"]["per_frame"]["triangles_drawn"]
    everything = runs["frustum"]["per_frame"]["triangles_drawn"]
    failed = 0
    if pixels > 0.5 * everything:
        print(f"no evidence: pixels hide too little ({pixels:.0f} of {everything:.0f} triangles are drawn)")
        failed = 1
    for name in ("two_phase:tile=8", "two_phase:tile=16"):
        ratio = runs[name]["per_frame"]["triangles_drawn"] / pixels
        wrong = runs[name]["differing_pixels"]
        print(f"{name}: {ratio:.3f} times the triangles, {wrong} pixels differ")
        if ratio > MOST or wrong != 0:
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
