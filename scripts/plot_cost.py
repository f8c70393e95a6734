#!/usr/bin/env python3
"""Draws the cost of culling against the number of objects, from a run of the traversal benchmarks.

usage: plot_cost.py BENCHMARKS.json OUT.svg

BENCHMARKS.json is what `occlude_benchmarks --benchmark_filter=traverse --benchmark_out=FILE` writes.
Exit status 2 if there is nothing to draw in it.
"""

import json
import math
import re
import sys
from pathlib import Path

WIDTH, HEIGHT = 720, 440
LEFT, RIGHT, TOP, BOTTOM = 70, 150, 30, 50
COLORS = ["#888888", "#1b7f5c", "#c4572a", "#3b5fc0", "#8a3fa0", "#b08900"]
NAME = re.compile(r"traverse/(?P<algorithm>\w+)/boxes:(?P<boxes>\d+)(?P<manual>/manual_time)?$")
TO_MICROSECONDS = {"ns": 1e-3, "us": 1.0, "ms": 1e3, "s": 1e6}


def read_series(path):
    """{algorithm: [(boxes, microseconds), ...]}, in the order of the file."""
    series = {}
    for run in json.loads(Path(path).read_text())["benchmarks"]:
        match = NAME.match(run["name"])
        if match and run.get("run_type", "iteration") == "iteration":
            time = run["real_time" if match["manual"] else "cpu_time"]
            micros = time * TO_MICROSECONDS[run["time_unit"]]
            series.setdefault(match["algorithm"], []).append((int(match["boxes"]), micros))
    return {name: sorted(points) for name, points in series.items()}


def decades(values):
    """The powers of ten around the values, as exponents."""
    low = math.floor(math.log10(min(values)))
    return low, max(math.ceil(math.log10(max(values))), low + 1)


def draw(series):
    points = [p for line in series.values() for p in line]
    x_low, x_high = decades([x for x, _ in points])
    y_low, y_high = decades([y for _, y in points])

    def at(x, y):
        across = (math.log10(x) - x_low) / (x_high - x_low)
        up = (math.log10(y) - y_low) / (y_high - y_low)
        return (LEFT + across * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM))

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="13">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for exponent in range(x_low, x_high + 1):
        x, _ = at(10**exponent, 10**y_low)
        out.append(f'<path d="M{x:.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>')
        out.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{10**exponent:,}</text>')
    for exponent in range(y_low, y_high + 1):
        _, y = at(10**x_low, 10**exponent)
        label = f"{10**exponent:,} µs" if exponent < 3 else f"{10**(exponent - 3):,} ms"
        out.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        out.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{label}</text>')
    for (name, line), color in zip(series.items(), COLORS):
        path = " ".join(f"{'M' if i == 0 else 'L'}{x:.1f} {y:.1f}" for i, (x, y) in enumerate(at(*p) for p in line))
        out.append(f'<path d="{path}" fill="none" stroke="{color}" stroke-width="2"/>')
        for point in line:
            x, y = at(*point)
            out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{color}"/>')
        x, y = at(*line[-1])
        out.append(f'<text x="{x + 10:.1f}" y="{y + 4:.1f}" fill="{color}">{name}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 8}" text-anchor="middle">objects in the city</text>')
    out.append(f'<text x="{LEFT}" y="{TOP - 12}">the culler\'s own time per frame</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    series = read_series(sys.argv[1])
    if not series:
        print(f"{sys.argv[1]}: no traverse/* benchmarks in it; run occlude_benchmarks "
              "--benchmark_filter=traverse --benchmark_out=FILE", file=sys.stderr)
        return 2
    Path(sys.argv[2]).write_text(draw(series))
    return 0


if __name__ == "__main__":
    sys.exit(main())
