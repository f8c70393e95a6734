#!/usr/bin/env python3
"""The viewer in a real window: Xvfb is the display, xdotool the keyboard and the mouse.

usage: desktop_test.py OCCLUDE

A script (--script) waits for the texts that each input must bring up; pixels come from the
viewer's own screenshots. Exit status 0 if everything appeared, 1 otherwise.
"""

import json
import os
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

SCENE = "city:blocks=4,triangles=60k,seed=3"
SIZE = (1000, 640)
TIMEOUT_S = 240


def decoded(path):
    """Width, height and rows (RGB bytes, the top row first) of an 8-bit RGB PNG."""
    data = path.read_bytes()
    chunks, at, header = b"", 8, None
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            chunks += body
        at += 12 + length
    width, height = header[0], header[1]
    raw, rows, before = zlib.decompress(chunks), [], bytes(3 * width)
    for y in range(height):
        start = y * (3 * width + 1)
        kind, row = raw[start], bytearray(raw[start + 1 : start + 1 + 3 * width])
        for i, value in enumerate(row):
            left = row[i - 3] if i >= 3 else 0
            up, corner = before[i], before[i - 3] if i >= 3 else 0
            paeth = min((left, up, corner), key=lambda v, p=left + up - corner: abs(p - v))
            row[i] = (value + (0, left, up, (left + up) // 2, paeth)[kind]) & 255
        rows.append(bytes(row))
        before = rows[-1]
    return width, height, rows


def differing(a, b, box):
    """Pixels of a box (left, top, right, bottom) in which two pictures differ."""
    return sum(
        a[2][y][3 * x : 3 * x + 3] != b[2][y][3 * x : 3 * x + 3]
        for y in range(box[1], box[3])
        for x in range(box[0], box[2])
    )


class Desktop:
    """A display of its own, and what a person does at it."""

    def __init__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x1024x24"],
            pass_fds=[write], stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(write)
        self.display = ":" + os.read(read, 16).decode().strip()
        self.environment = {**os.environ, "DISPLAY": self.display}

    def do(self, *words):
        """One command of xdotool; its output."""
        done = subprocess.run(
            ["xdotool", *map(str, words)], env=self.environment, capture_output=True, text=True,
            check=False, timeout=60,
        )  # fmt: skip
        return done.stdout.strip()

    def window(self):
        """The viewer's window, with the keyboard's focus."""
        for _ in range(600):
            found = self.do("search", "--name", "occlude view").split()
            if found:
                self.do("windowmove", found[-1], 0, 0)
                self.do("windowfocus", found[-1])
                return found[-1]
            time.sleep(0.1)
        raise SystemExit("desktop_test: no window appeared")


def wait_for(path):
    """The path, once it is there."""
    for _ in range(600):
        if path.exists():
            return path
        time.sleep(0.1)
    raise SystemExit(f"desktop_test: {path.name} was not written")


def drive(desktop, folder):
    """Inputs, each of which the script in main() waits for."""
    desktop.window()
    time.sleep(1)
    desktop.do("key", "F1")
    wait_for(folder / "help.png")
    desktop.do("key", "Escape")
    wait_for(folder / "closed.png")
    desktop.do("mousemove", 640, 300, "click", 1)
    wait_for(folder / "why.png")
    desktop.do("keydown", "d")
    time.sleep(1.5)
    desktop.do("keyup", "d")
    desktop.do("mousemove", 600, 300, "mousedown", 1, "mousemove", 660, 320)
    desktop.do("mousemove", 720, 330, "mouseup", 1)
    desktop.do("key", "f")
    wait_for(folder / "frozen.png")
    desktop.do("key", "F4")
    wait_for(folder / "timeline.png")
    desktop.do("key", "ctrl+q")


SCRIPT = """wait-loaded
wait-text list the keys
screenshot {0}/help.png
wait 100
assert-no-text list the keys
screenshot {0}/closed.png
wait-text Chain of nodes
screenshot {0}/why.png
wait-text culling camera frozen
screenshot {0}/frozen.png
wait-text read depth
screenshot {0}/timeline.png
wait 100000
"""


def main(program):
    """Runs the viewer on a display of its own and looks at what it showed."""
    desktop = Desktop()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        script = folder / "script.txt"
        script.write_text(SCRIPT.format(folder), encoding="utf-8")
        environment = {**desktop.environment, "XDG_CONFIG_HOME": str(folder / "config")}
        viewer = subprocess.Popen(
            [program, "view", SCENE, "--size", f"{SIZE[0]}x{SIZE[1]}", "--script", script],
            env=environment, cwd=folder,
        )  # fmt: skip
        try:
            drive(desktop, folder)
            code = viewer.wait(timeout=TIMEOUT_S)
        finally:
            viewer.kill()
            desktop.server.terminate()
        assert code == 0, f"the viewer ended with {code}"
        pictures = {
            step: decoded(folder / f"{step}.png")
            for step in ("help", "closed", "why", "frozen", "timeline")
        }
        assert pictures["help"][:2] == SIZE, pictures["help"][:2]
        picture = (320, 60, 640, 400)
        assert differing(pictures["help"], pictures["closed"], picture) > 10000, "help"
        assert differing(pictures["closed"], pictures["frozen"], picture) > 10000, "flying"
        assert differing(pictures["frozen"], pictures["timeline"], (320, 520, 640, 620)) > 3000
        settings = json.loads((folder / "config/occlude/viewer.json").read_text(encoding="utf-8"))
        assert settings["timeline"] is True, "settings are remembered"
        assert settings["window_size"] == list(SIZE), settings["window_size"]
    print("desktop_test: the window did what keyboard and mouse asked")


if __name__ == "__main__":
    main(sys.argv[1])
