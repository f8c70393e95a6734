#!/usr/bin/env python3
"""Measures all figures of the documentation, and writes the pages that show them.

usage: measure.py run [NAME...] [--program build/bin/occlude] [--tests build/bin/test_cull] [--machine NAME]
       measure.py pages [--machine NAME]
       measure.py check [--machine NAME]

benchmarks/measurements.toml lists the measurements: a name, the page, the commands and the columns.
`run` runs the commands of the named measurements (of all by default) and keeps their JSON output
in benchmarks/results/MACHINE/NAME.json, with the commands, the commit, the date and the machine.
`pages` writes docs/measurements/*.md from these files, and the blocks between
`<!-- measured: NAME -->` and `<!-- end -->` in other pages; `<!-- measured: NAME a,b -->` shows the rows
a and b only. `check` changes nothing and exits with 1 if `pages` would change a file, or if
docs/measurements/ has a page that no measurement makes.
"""

import argparse
import datetime
import json
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Pages of docs/measurements/ that other commands write: `./dev soak`, scripts/check_models.py. README lists all.
OTHER_PAGES = {"README", "trust", "models", "osg", "size", "occluders"}
BLOCK = re.compile(r"(<!-- measured: (\w+)(?: ([\w,]+))? -->\n).*?(<!-- end -->)", re.DOTALL)


class Problem(Exception):
    """What is wrong, in a sentence for the user."""


# --- what there is to measure ---


def load_measurements(root=ROOT):
    """The measurements of benchmarks/measurements.toml, in order."""
    path = root / "benchmarks" / "measurements.toml"
    try:
        listed = tomllib.loads(path.read_text("utf-8"))["measurement"]
    except (OSError, tomllib.TOMLDecodeError, KeyError) as error:
        raise Problem(f"{path}: {error}") from error
    for entry in listed:
        for key in ("name", "page", "title", "rows", "columns"):
            if key not in entry:
                raise Problem(f"{path}: measurement {entry.get('name', '?')} has no '{key}'")
    return listed


def machine_folder(root, machine):
    """The folder of results: the named one, or the only one there is."""
    results = root / "benchmarks" / "results"
    if machine:
        return results / machine
    folders = sorted(path for path in results.iterdir() if path.is_dir())
    if len(folders) != 1:
        raise Problem(f"{results} has {len(folders)} machines; name one with --machine")
    return folders[0]


# --- running ---


def processor():
    """The processor's name and the number of cores."""
    name = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines():
            if line.startswith("model name"):
                name = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{name}, {os.cpu_count()} cores"


def without_frames(document):
    """The document of `bench --json` or of a suite without single frames: they are not shown."""
    if isinstance(document, dict):
        return {
            key: without_frames(value)
            for key, value in document.items()
            if not (key == "frames" and isinstance(value, list))
        }
    if isinstance(document, list):
        return [without_frames(value) for value in document]
    return document


def run_command(command, programs):
    """Runs one command of a measurement and returns the JSON it writes."""
    words = shlex.split(command)
    kind = words[0]
    if kind not in programs:
        raise Problem(f"'{command}' starts with {kind}; it must start with {' or '.join(programs)}")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.json"
        json_words = {
            "occlude": ["--json", str(out)],
            "test_cull": [f"--gtest_output=json:{out}"],
        }
        done = subprocess.run([programs[kind], *words[1:], *json_words[kind]], cwd=ROOT, check=False)
        if not out.exists():
            raise Problem(f"'{command}' ended with {done.returncode} and wrote no JSON")
        return without_frames(json.loads(out.read_text("utf-8")))


def measure(entry, folder, programs):
    """Runs all commands of a measurement and keeps what they say."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()
    kept = {
        "name": entry["name"],
        "date": datetime.date.today().isoformat(),
        "commit": commit,
        "machine": processor(),
        "rows": [
            {"command": row["command"], "document": run_command(row["command"], programs)}
            for row in entry["rows"]
        ],
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{entry['name']}.json").write_text(json.dumps(kept, indent=1) + "\n", "utf-8")


# --- tables ---


def look_up(value, path):
    """The value behind "frame_ms.median" in nested objects; None where there is none."""
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return value


def shown(value, digits=3):
    """A number as a table shows it: `digits` significant ones, thousands separated."""
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    if value == 0:
        return "0"
    if abs(value) >= 10 ** (digits - 1):
        return f"{value:,.0f}"
    return f"{float(f'{value:.{digits}g}'):g}"


def documents_of(document):
    """The documents of single scenes: of a suite many, else one."""
    return document.get("documents", [document])


def runs_of(document):
    """(scene name, run) of each run of a document of `occlude bench`."""
    for part in documents_of(document):
        for run in part["runs"]:
            yield part["scene"]["name"], run


def run_of(document, algorithm, hierarchy=None):
    """The run of an algorithm, as --algorithms names it; on this kind of tree, if one is named."""
    for _, run in runs_of(document):
        if run["algorithm"] == algorithm and hierarchy in (None, run["hierarchy"]):
            return run
    raise Problem(f"there is no run of {algorithm}")


def figure(document, run, column):
    """What a column says of a run: a value, or with `over` its ratio to the value of another run."""
    value = look_up(run, column["value"])
    if "over" not in column or value is None:
        return shown(value)
    base = look_up(run_of(document, column["over"], run["hierarchy"]), column["value"])
    return shown(value / base if base else None)


def table_of_runs(entry, kept):
    """One row for each run of each command, the command's label before the algorithm."""
    columns = entry["columns"]
    lines = [[entry.get("row_title", "")] + [column["title"] for column in columns]]
    for row, measured in zip(entry["rows"], kept["rows"]):
        label = f"{row['label']}, " if len(entry["rows"]) > 1 else ""
        document = measured["document"]
        for _, run in runs_of(document):
            lines.append([f"{label}`{run['algorithm']}`"] + [figure(document, run, c) for c in columns])
    return lines


def table_of_rows(entry, kept):
    """One row for each command; a column names an algorithm and a value of its run."""
    columns = entry["columns"]
    lines = [[entry.get("row_title", "")] + [column["title"] for column in columns]]
    for row, measured in zip(entry["rows"], kept["rows"]):
        cells = [row["label"]]
        for column in columns:
            document = measured["document"]
            cells.append(figure(document, run_of(document, column["run"]), column))
        lines.append(cells)
    return lines


def table_of_tests(entry, kept):
    """One row for each test that recorded the properties that the columns name."""
    columns = entry["columns"]
    lines = [[column["title"] for column in columns]]
    for measured in kept["rows"]:
        for suite in measured["document"]["testsuites"]:
            for test in suite["testsuite"]:
                if all(column["value"] in test for column in columns):
                    lines.append([as_shown(test[column["value"]]) for column in columns])
    return lines


def as_shown(text):
    """A property of a test: shortened if it is a number."""
    try:
        return shown(float(text))
    except ValueError:
        return text


TABLES = {
    "runs": table_of_runs,
    "rows": table_of_rows,
    "tests": table_of_tests,
}


def markdown(lines):
    """Lines of cells as a Markdown table; figures to the right."""
    head, *body = lines
    rule = ["---"] + ["---:"] * (len(head) - 1)
    return "".join("| " + " | ".join(cells) + " |\n" for cells in [head, rule, *body])


def section(entry, kept):
    """What a page says of one measurement."""
    text = f"## {entry['title']}\n\n"
    if "text" in entry:
        text += entry["text"].strip() + "\n\n"
    text += table(entry, kept) + "\n"
    commands = "\n".join(dict.fromkeys(row["command"] for row in kept["rows"]))
    renderers = {
        look_up(part, "device.renderer") for row in kept["rows"] for part in documents_of(row["document"])
    } - {None}
    where = ", ".join([kept["machine"], *sorted(renderers)])
    text += f"```\n{commands}\n```\n\nCommit {kept['commit']}, {kept['date']}, {where}.\n"
    return text


def table(entry, kept, only=None):
    """The table of a measurement, in Markdown; only the rows of these names if there are any."""
    head, *body = TABLES[entry.get("table", "runs")](entry, kept)
    if only is not None:
        names = {cells[0].strip("`") for cells in body}
        missing = [name for name in only if name not in names]
        if missing:
            raise Problem(f"{entry['name']} has no row {', '.join(missing)}")
        body = [cells for cells in body if cells[0].strip("`") in only]
    return markdown([head, *body])


# --- pages ---


def page_texts(root, measurements, folder):
    """{path: text} of all files that `pages` writes."""
    kept = {}
    for entry in measurements:
        file = folder / f"{entry['name']}.json"
        if file.exists():
            kept[entry["name"]] = json.loads(file.read_text("utf-8"))
    pages = {}
    for entry in measurements:
        if entry["name"] in kept:
            if [row["command"] for row in entry["rows"]] != [row["command"] for row in kept[entry["name"]]["rows"]]:
                raise Problem(f"the commands of '{entry['name']}' have changed; measure it again")
            pages.setdefault(entry["page"], []).append(section(entry, kept[entry["name"]]))
    texts = {}
    for page, sections in pages.items():
        manual = root / "docs" / "algorithms" / f"{page}.md"
        title = page if manual.exists() else page.replace("_", " ")
        head = (
            f"# Measured: {title}\n\n"
            "`scripts/measure.py pages` writes this page from `benchmarks/results/`. "
            "`scripts/measure.py run` measures again.\n\n"
        )
        if manual.exists():
            head += f"[The manual page](../algorithms/{page}.md) explains the options.\n\n"
        texts[root / "docs" / "measurements" / f"{page}.md"] = head + "\n".join(sections)
    by_name = {entry["name"]: entry for entry in measurements}
    for path in [root / "README.md", *sorted((root / "docs").rglob("*.md"))]:
        old = texts.get(path) or path.read_text("utf-8")

        def fill(match):
            name = match[2]
            if name not in kept:
                raise Problem(f"{path.relative_to(root)}: there is no result of '{name}'")
            rows = match[3].split(",") if match[3] else None
            return match[1] + table(by_name[name], kept[name], rows) + match[4]

        new = BLOCK.sub(fill, old)
        if new != old or path in texts:
            texts[path] = new
    return texts


def pages_of_nothing(root, measurements):
    """The pages of docs/measurements/ that no measurement makes."""
    pages = {entry["page"] for entry in measurements} | OTHER_PAGES
    return [path for path in sorted((root / "docs" / "measurements").glob("*.md")) if path.stem not in pages]


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("verb", choices=("run", "pages", "check"))
    parser.add_argument("names", nargs="*")
    parser.add_argument("--program", default="build/bin/occlude")
    parser.add_argument("--tests", default="build/bin/test_cull")
    parser.add_argument("--machine")
    options = parser.parse_args(arguments)
    measurements = load_measurements()
    folder = machine_folder(ROOT, options.machine)
    known = [entry["name"] for entry in measurements]
    for name in options.names:
        if name not in known:
            raise Problem(f"there is no measurement '{name}'; there are {', '.join(known)}")
    if options.verb == "run":
        programs = {
            "occlude": str(ROOT / options.program),
            "test_cull": str(ROOT / options.tests),
        }
        for entry in measurements:
            if not options.names or entry["name"] in options.names:
                print(f"measure: {entry['name']}", file=sys.stderr)
                measure(entry, folder, programs)
        return 0
    stale = 0
    for path in pages_of_nothing(ROOT, measurements):
        stale += 1
        print(f"measure: {path.relative_to(ROOT)} is the page of no measurement")
    for path, text in page_texts(ROOT, measurements, folder).items():
        if path.exists() and path.read_text("utf-8") == text:
            continue
        stale += 1
        if options.verb == "pages":
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
        print(f"measure: {'wrote' if options.verb == 'pages' else 'stale:'} {path.relative_to(ROOT)}")
    return 1 if options.verb == "check" and stale else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Problem as problem:
        print(f"measure: {problem}", file=sys.stderr)
        sys.exit(2)
