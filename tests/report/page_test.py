#!/usr/bin/env python3
"""The HTML report in a browser: headless Chromium opens what `occlude bench --html` writes.

usage: page_test.py OCCLUDE CHROMIUM

Every figure on the page must be that of the JSON, rounded; so must every number of its sentences and settings, and
the raw data that it carries. All plots must be drawn, the console must stay silent, and on a phone 400 pixels wide nothing may stand out to the right.
"""

import html.parser
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

PLOTS = 5
PHONE_PX = 400


class Figures(html.parser.HTMLParser):
    """Elements with data-key: (document, run, key, text); and the number of plots that were drawn."""

    def __init__(self):
        super().__init__()
        self.document, self.open, self.figures, self.plotted = None, None, [], None
        self.within, self.sentences, self.raw = None, [], ""

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag == "html":
            self.plotted = attributes.get("data-plotted")
        if "data-document" in attributes:
            self.document = int(attributes["data-document"])
        if "data-key" in attributes:
            self.open = (self.document, int(attributes["data-run"]), attributes["data-key"])
        if tag in ("dd", "p") and self.document is not None:
            self.within = tag if tag == "dd" or attributes.get("class") == "headline" else None
        if attributes.get("id") == "occlude-data":
            self.within = "raw"

    def handle_endtag(self, tag):
        if tag in (self.within, "script"):
            self.within = None

    def handle_data(self, data):
        if self.within == "raw":
            self.raw += data
        elif self.within and not self.open:
            self.sentences.append((self.document, data))
        if self.open:
            self.figures.append((*self.open, data))
            self.open = None


def browse(chromium, folder, page, *options):
    """The page after its scripts ran, and what they wrote to the console."""
    done = subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--v=0",
         f"--user-data-dir={folder}/profile", "--virtual-time-budget=5000", *options, "--dump-dom", page.as_uri()],
        capture_output=True, text=True, timeout=120, check=True)
    return done.stdout, re.findall(r"CONSOLE.*", done.stderr)


def value_at(value, key):
    for step in key.split("."):
        value = value[int(step)] if isinstance(value, list) else value[step]
    return value


def check_figures(dom, documents):
    reader = Figures()
    reader.feed(dom)
    assert reader.plotted == str(PLOTS * len(documents)), f"{reader.plotted} plots were drawn"
    for document, run, key, text in reader.figures:
        value = value_at(documents[document]["runs"][run], key)
        place = f"document {document}, run {run}, {key}: the page says '{text}', the JSON {value}"
        if text == "–":
            assert value is None, place
            continue
        decimals = len(text.partition(".")[2])
        assert abs(float(text.replace(",", "")) - value) <= 0.5001 * 10.0**-decimals, place
    runs = sum(len(document["runs"]) for document in documents)
    assert len(reader.figures) > 15 * runs, f"only {len(reader.figures)} figures for {runs} runs"


def leaves(value):
    """All numbers and strings below a value of JSON."""
    if isinstance(value, (dict, list)):
        for child in value.values() if isinstance(value, dict) else value:
            yield from leaves(child)
    else:
        yield value


def check_sentences(dom, documents):
    """The numbers of the headline and of the settings are numbers, or parts of strings, of the JSON."""
    reader = Figures()
    reader.feed(dom)
    assert json.loads(reader.raw) == documents, "the page's raw data are not those of the JSON"
    checked = 0
    for document, text in reader.sentences:
        known = list(leaves({key: value for key, value in documents[document].items() if key != "runs"}))
        for run in documents[document]["runs"]:
            known += leaves({key: value for key, value in run.items() if key != "frames"})
        strings = [value for value in known if isinstance(value, str)]
        numbers = {value for value in known if isinstance(value, (int, float)) and not isinstance(value, bool)}
        for token in re.findall(r"\d+(?:,\d{3})*(?:\.\d+)?", text):
            in_string = any(token in value for value in strings)
            assert in_string or float(token.replace(",", "")) in numbers, f"'{text}': the JSON has no {token}"
            checked += 1
    assert checked >= 10 * len(documents), f"only {checked} numbers in sentences"


def check_phone(chromium, folder):
    page = Path(folder) / "phone.html"
    page.write_text(
        f'<iframe src="report.html" style="border:0;width:{PHONE_PX}px;height:800px" onload="document.title ='
        " 'width ' + this.contentDocument.documentElement.scrollWidth\"></iframe>")
    dom, _ = browse(chromium, folder, page, "--allow-file-access-from-files")
    width = re.search(r"<title>width (\d+)</title>", dom)
    assert width, "the report did not load in a frame"
    assert int(width[1]) <= PHONE_PX, f"the page is {width[1]} pixels wide on a phone of {PHONE_PX}"


def main(program, chromium):
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        report, data = Path(folder) / "report.html", Path(folder) / "bench.json"
        subprocess.run(
            [program, "bench", "boxes:count=300", "movers:count=60,triangles=3k", "--device", "cpu", "--size", "96x64",
             "--frames", "6", "--algorithms", "chc,adaptive,next_frame", "--hierarchy", "bvh,octree", "--verify",
             "--json", data, "--html", report],
            check=True, timeout=120, stdout=subprocess.DEVNULL)
        documents = json.loads(data.read_text())
        assert report.read_text().count("data:image/png") == 6 * len(documents), "two frames, three pictures each"
        dom, console = browse(chromium, folder, report)
        assert not console, f"the console says: {console}"
        check_figures(dom, documents)
        check_sentences(dom, documents)
        check_phone(chromium, folder)
    print("the page says what the JSON says")


if __name__ == "__main__":
    main(*sys.argv[1:])
