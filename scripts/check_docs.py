#!/usr/bin/env python3
"""Every relative link of the Markdown files leads to a file, and every #anchor to a heading.

usage: check_docs.py [ROOT]      Exit status 0 if all do, 1 otherwise.
"""

import re
import sys
from pathlib import Path

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def anchors(page):
    """The anchors of a page's headings, as GitHub forms them."""
    headings = re.findall(r"^#+ +(.+?) *$", FENCE.sub("", page.read_text("utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in headings}


def broken_links(root):
    """One sentence per link below `root` that leads nowhere."""
    pages = [*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("examples/**/*.md")]
    for page in sorted(pages):
        for link in LINK.findall(FENCE.sub("", page.read_text("utf-8"))):
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = link.partition("#")
            target = page.parent / path if path else page
            if not target.exists():
                yield f"{page.relative_to(root)}: {link} does not exist"
            elif anchor and anchor not in anchors(target):
                yield f"{page.relative_to(root)}: {link} names no heading"


if __name__ == "__main__":
    problems = list(broken_links(Path(sys.argv[1]) if sys.argv[1:] else Path(__file__).parents[1]))
    print("\n".join(problems) or "check_docs: all links resolve")
    sys.exit(1 if problems else 0)
