#!/usr/bin/env python3
"""Lists everything that got worse from one file of benchmark results to another.

usage: compare_results.py OLD NEW [--time-tolerance PERCENT] [--counter-tolerance PERCENT]

The files are what `occlude bench --json FILE` wrote, with --suite or without. Runs are matched by entry
(or scene, path and size) and algorithm. Worse is

  - a run, or a scene, that NEW does not have, or that was measured in another way;
  - more differing pixels of an exact algorithm;
  - other decisions, or a counter that grew, where decisions follow from the frames alone
    ("decision_hash_reproducible" in both files); where they depend on when answers arrive, a counter
    that grew by more than --counter-tolerance (5 percent);
  - a gain over `frustum` that fell by more than --time-tolerance (15 percent), if the renderer is the
    same. Milliseconds themselves are not compared: machines drift, ratios within one run do not.

Prints one line for each, then how much was compared. Exit status: 0 nothing got worse, 1 something did,
2 a file cannot be used.
"""

import argparse
import json
import sys

# How an entry was measured: with another of these, figures do not compare.
SETUP = ("size", "samples", "frames", "sample_every", "hierarchy", "leaf_triangles", "item_triangles",
         "split", "sets")  # fmt: skip
# All counters are costs: less is better.
TIMES = ("wait_ms", "read_ms", "cull_cpu_ms")


class Unusable(Exception):
    """A file that holds no results."""


def documents(path):
    """The documents of a file by key, and its scale (None without a suite)."""
    try:
        with open(path, encoding="utf-8") as file:
            content = json.load(file)
        scale = content.get("scale") if isinstance(content, dict) else None
        if isinstance(content, dict):
            content = content.get("documents", [content])
        found = {}
        for document in content:
            key = document.get("entry") or " ".join(
                [document["scene"]["name"], document["path"], "x".join(map(str, document["size"]))]
            )
            found[key] = document
            _ = document["runs"], document["device"]["renderer"]
        return found, scale
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise Unusable(
            f"{path}: no results of a benchmark ({error!r}); give a file that 'occlude bench --json "
            "FILE' wrote"
        ) from error


def setup_changes(old, new):
    """Lines about what of the setup differs."""
    changes = [f"{key} was {old.get(key)}, is {new.get(key)}" for key in SETUP
               if old.get(key) != new.get(key)]  # fmt: skip
    if old["scene"] != new["scene"]:
        changes.append(f"scene was {old['scene']}, is {new['scene']}")
    return changes


def grew(old, new, tolerance):
    """True if a cost is larger by more than a share of it; counts below one in a thousand frames pass."""
    return new > old * (1.0 + tolerance) + 1e-3


def compare_counters(old, new, strict, tolerance):
    """Lines about the counters that got worse."""
    for name, before in old["per_frame"].items():
        after = new["per_frame"].get(name)
        timed = name in TIMES or (name == "waits" and not strict)  # was the answer there in time?
        if timed or before is None or after is None:
            continue
        if grew(before, after, 0.0 if strict else tolerance):
            yield f"{name} per frame grew from {before:g} to {after:g}"


def compare_runs(old, new, same_renderer, options):
    """Lines about what got worse in one algorithm on one entry."""
    if new["guarantee"] == "exact":
        before, after = old.get("differing_pixels") or 0, new.get("differing_pixels") or 0
        if after > before:
            yield f"differing pixels grew from {before} to {after}"
    elif old["guarantee"] == "exact":
        yield f"it was exact and is {new['guarantee']}"
    strict = all(run.get("decision_hash_reproducible", False) for run in (old, new))
    if strict and old["decision_hash"] != new["decision_hash"]:
        yield f"decisions changed: hash {old['decision_hash']} became {new['decision_hash']}"
    yield from compare_counters(old, new, strict, options.counter_tolerance / 100.0)
    before, after = old.get("speedup_vs_frustum"), new.get("speedup_vs_frustum")
    if same_renderer and before and after:
        if after < before * (1.0 - options.time_tolerance / 100.0):
            yield f"gain over frustum fell from {before:.2f} to {after:.2f}"


def compare(old_documents, new_documents, options):
    """The lines about everything that got worse, and the number of runs that were compared."""
    worse, compared = [], 0
    for key, old in old_documents.items():
        new = new_documents.get(key)
        if new is None:
            worse.append(f"{key}: not in {options.new}")
            continue
        changes = setup_changes(old, new)
        if changes:
            worse += [f"{key}: measured in another way: {change}" for change in changes]
            continue
        same_renderer = old["device"]["renderer"] == new["device"]["renderer"]
        new_runs = {run["algorithm"]: run for run in new["runs"]}
        for run in old["runs"]:
            name = run["algorithm"]
            if name not in new_runs:
                worse.append(f"{key}: {name}: not in {options.new}")
                continue
            compared += 1
            worse += [
                f"{key}: {name}: {line}"
                for line in compare_runs(run, new_runs[name], same_renderer, options)
            ]
    return worse, compared


def percent(text):
    value = float(text)
    if value < 0.0:
        raise argparse.ArgumentTypeError(f"'{text}' is below 0")
    return value


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--time-tolerance", type=percent, default=15.0, metavar="PERCENT")
    parser.add_argument("--counter-tolerance", type=percent, default=5.0, metavar="PERCENT")
    options = parser.parse_args()
    try:
        old, old_scale = documents(options.old)
        new, new_scale = documents(options.new)
    except Unusable as error:
        print(f"compare_results: {error}", file=sys.stderr)
        return 2
    if old_scale != new_scale:
        print(f"compare_results: {options.old} is of scale {old_scale}, {options.new} of "
              f"{new_scale}; compare results of one scale", file=sys.stderr)  # fmt: skip
        return 2
    worse, compared = compare(old, new, options)
    for line in worse:
        print(line)
    print(f"{compared} runs compared, {len(worse)} things worse")
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
