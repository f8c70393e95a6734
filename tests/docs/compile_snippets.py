#!/usr/bin/env python3
"""Compiles every ```cpp block of a page, in order, each in the scope of those before it.

usage: compile_snippets.py PAGE PREAMBLE SIGNATURE OUTPUT.cpp COMPILER [FLAGS...]

SIGNATURE is that of the function around all blocks: what they know. Exit status 0 if it compiles.
"""

import re
import subprocess
import sys
from pathlib import Path


def snippets(page):
    """(line number, text) of each block."""
    text = page.read_text(encoding="utf-8")
    for match in re.finditer(r"^```cpp\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL):
        yield text.count("\n", 0, match.start(1)) + 1, match[1]


def main(arguments):
    page, preamble, signature, output = arguments[:4]
    blocks = list(snippets(Path(page)))
    if not blocks:
        print(f"{page}: there is no cpp block")
        return 1
    code = [f'#include "{preamble}"', f"{signature}", "{"]
    for line, text in blocks:
        code += ["{", f'#line {line} "{page}"', text]
    code += ["}" * len(blocks), "}"]
    Path(output).write_text("\n".join(code), encoding="utf-8")
    compiled = subprocess.run([*arguments[4:], "-fsyntax-only", output], check=False)
    print(f"{page}: {len(blocks)} snippets, compiler says {compiled.returncode}")
    return compiled.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
