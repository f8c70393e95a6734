#!/usr/bin/env python3
"""Makes every picture of README and docs/ that is not a drawing: pictures by the program, and the animation.

usage: pictures.py [--program build/bin/occlude] [--flare build/bin/lens_flare] [NAME...]

NAME is a file of docs/images without its ending; all are made by default. Needs Pillow (Debian: python3-pil) and the
fonts of fonts-dejavu-core. The legend of the animation takes names and colours from tools/render/palette.h.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
MOST_ANIMATION_BYTES = 1_500_000

# Views of the generated scenes, each alone and with what is hidden: the scene, and its options.
SCENES = {
    "boxcity": ("boxcity", ["--path", "street", "--path-frames", "100", "--frame", "10"]),
    "teapots": ("teapots:count=1000", ["--path", "flight", "--path-frames", "100", "--frame", "40"]),
    "library": ("library:books=5000", ["--path-frames", "100", "--frame", "36"]),
    "plant": ("plant:triangles=1200k", ["--path-frames", "100", "--frame", "85"]),
    "bunnies": ("bunnies:count=100,triangles=10k", ["--path-frames", "100", "--frame", "20"]),
    "forest": ("forest:triangles=600k,trees=3500", ["--path-frames", "100", "--frame", "30"]),
    "vienna": ("vienna:triangles=1m,blocks=8", ["--path", "street", "--path-frames", "100", "--frame", "20"]),
    "vienna_rise": ("vienna:triangles=1m,blocks=8", ["--path", "rise", "--path-frames", "100", "--frame", "70"]),
    "city": ("city:triangles=1m,blocks=6", ["--path", "street", "--path-frames", "100", "--frame", "20"]),
    "pyramids": ("pyramids", ["--path-frames", "100", "--frame", "40"]),
    "rings": ("rings", ["--path-frames", "100", "--frame", "40"]),
}

STREET = ["--path", "street", "--path-frames", "60", "--frame", "24"]
HEAP = ["teapots:count=200,triangles=2304", "--path", "flight", "--path-frames", "60", "--frame", "20"]
CASTLE = ["--path", "walk", "--path-frames", "60", "--frame", "20"]
ABOVE = ["--camera", "overview", "--show", "states", "--size", "960x600"]
SMALL = ["--size", "640x400"]

# {name: words after `occlude render`}
RENDERED = {
    "frustum_states": ["city:triangles=1m", *STREET, *ABOVE, "--algorithm", "frustum"],
    "opt_states": ["city:triangles=1m", *STREET, *ABOVE, "--algorithm", "opt"],
    "lazy_grid_states": ["city:triangles=1m", *STREET, *ABOVE, "--algorithm", "lazy_grid"],
    "adaptive_states": ["city:triangles=1m", *STREET, *ABOVE, "--algorithm", "adaptive"],
    # docs/troubleshooting.md
    "trouble_exact": [*HEAP, *SMALL, "--algorithm", "adaptive"],
    "trouble_missing": [*HEAP, *SMALL, "--algorithm", "prioritized", "--set", "prioritized.budget_triangles=60000"],
    "trouble_one_mesh": ["assets/castle/castle.glb", *CASTLE, *ABOVE, "--algorithm", "adaptive", "--set",
                         "adaptive.method=draw_all"],
    "trouble_boxes": ["rings:count=200", "--path-frames", "100", "--frame", "40", *SMALL, "--show", "boxes"],
    "trouble_large_items": ["bunnies:count=60,triangles=20k", "--path-frames", "100", "--frame", "20", *SMALL,
                            "--item-triangles", "100000", "--show", "hidden"],
    "trouble_small_items": ["bunnies:count=60,triangles=20k", "--path-frames", "100", "--frame", "20", *SMALL,
                            "--item-triangles", "256", "--show", "hidden"],
}
for scene_name, (scene, options) in SCENES.items():
    for suffix, show in (("", "visible"), ("_hidden", "hidden")):
        RENDERED[f"scene_{scene_name}{suffix}"] = [scene, *options, "--size", "640x360", "--show", show]

# What a user types and clicks in the viewer; {folder} is where the pictures go.
VIEWER_SCRIPT = """wait-loaded
wait 90
screenshot {folder}/viewer_start.png
click "split"
wait 60
screenshot {folder}/viewer_split.png
click "split"
wait 5
key P
wait 24
key P
wait 20
key F
click "overview"
wait 3
click "tested boxes"
move 620 560
wait 30
screenshot {folder}/viewer_frozen.png
click "tested boxes"
click 552 165
wait 10
click "what hides it?"
wait 10
screenshot {folder}/viewer_why.png
key F4
wait 20
screenshot {folder}/viewer_timeline.png
"""
MAX_COVERAGE = 1  # Image.Quantize.MAXCOVERAGE, by the number that older versions of Pillow know

VIEWER = ["viewer_start", "viewer_split", "viewer_frozen", "viewer_why", "viewer_timeline"]

ANIMATION = "street"
ANIMATION_SCENE = "city:blocks=10,triangles=2m,seed=1"
ANIMATION_FRAMES = (2, 57)
ANIMATION_OPTIONS = ["--path", "street", "--path-frames", "60", "--frames", "{}:{}".format(*ANIMATION_FRAMES)]


class Problem(Exception):
    """What is wrong, in a sentence for the user."""


def run(*words):
    done = subprocess.run([str(word) for word in words], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Problem(f"{' '.join(map(str, words))} ended with {done.returncode}: {done.stderr.strip()}")


def palette(header):
    """[(decision, colour as three bytes)] of the legend, in its order."""
    colors = {}
    for name, red, green, blue in re.findall(r'NamedColor (k\w+)\{"[^"]*", \{([\d.]+)f, ([\d.]+)f, ([\d.]+)f', header):
        colors[name] = tuple(round(255 * float(part)) for part in (red, green, blue))
    return [
        (decision, colors[name])
        for decision, name in re.findall(r"\{Decision::(\w+), palette::(k\w+),", header)
    ]


def keep(image, path):
    """Writes a picture with 256 colours, which is all it needs: those of legends, too, small as they are."""
    image.convert("RGB").quantize(256, method=MAX_COVERAGE, dither=0).save(path, optimize=True)
    print(f"pictures: {path.relative_to(ROOT)}, {path.stat().st_size // 1000} kB")


def legend(image_module, draw_module, font_module, width, colors):
    """A strip that says what the colours of the animation mean."""
    texts = [
        (colors["drawn"], "drawn"),
        (colors["drawn_tested"], "drawn and tested"),
        (colors["drawn_revealed"], "drawn after a test"),
        (colors["hidden_group"], "hidden (tested with others)"),
        (colors["hidden"], "hidden (tested alone)"),
        (colors["outside"], "outside the view"),
    ]
    font = font_module.truetype(FONT, 13)
    strip = image_module.new("RGB", (width, 30), "white")
    draw = draw_module.Draw(strip)
    sizes = [26 + font.getlength(text) for _, text in texts]
    gap = (width - sum(sizes)) / (len(texts) + 1)
    x = gap
    for (color, text), size in zip(texts, sizes):
        draw.rectangle((x, 9, x + 14, 22), fill=color)
        draw.text((x + 20, 7), text, fill="black", font=font)
        x += size + gap
    return strip


def animate(program, folder):
    """The street as its camera sees it, and the same frames from above."""
    from PIL import Image, ImageDraw, ImageFont

    left, right, height = 384, 576, 360
    run(program, "render", ANIMATION_SCENE, *ANIMATION_OPTIONS, "--size", f"{left}x{height}", "--out", folder / "eye")
    run(program, "render", ANIMATION_SCENE, *ANIMATION_OPTIONS, "--size", f"{right}x{height}", "--camera", "overview",
        "--show", "states", "--out", folder / "above")
    colors = dict(palette((ROOT / "tools" / "render" / "palette.h").read_text("utf-8")))
    strip = legend(Image, ImageDraw, ImageFont, left + right, colors)
    font = ImageFont.truetype(FONT, 15)
    frames = []
    for file in sorted((folder / "eye").glob("*.png")):
        frame = Image.new("RGB", (left + right, height + strip.height), "white")
        frame.paste(Image.open(file), (0, 0))
        frame.paste(Image.open(folder / "above" / file.name), (left, 0))
        frame.paste(strip, (0, height))
        draw = ImageDraw.Draw(frame)
        draw.line((left, 0, left, height), fill="white", width=2)
        for x, text in ((8, "what the camera sees"), (left + 10, "what is drawn for it, from above")):
            draw.text((x, 6), text, fill="white", font=font, stroke_width=2, stroke_fill="black")
        frames.append(frame)
    path = IMAGES / f"{ANIMATION}.webp"
    for quality in (70, 55, 40, 25):
        frames[0].save(path, save_all=True, append_images=frames[1:], duration=120, loop=0, quality=quality, method=4)
        if path.stat().st_size <= MOST_ANIMATION_BYTES:
            break
    else:
        raise Problem(f"{path} is larger than {MOST_ANIMATION_BYTES} bytes")
    print(f"pictures: {path.relative_to(ROOT)}, {len(frames)} frames, {path.stat().st_size // 1000} kB")


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--program", default="build/bin/occlude")
    parser.add_argument("--flare", default="build/bin/lens_flare")
    options = parser.parse_args(arguments)
    every = [*RENDERED, *VIEWER, "lens_flare", ANIMATION]
    for name in options.names:
        if name not in every:
            raise Problem(f"there is no picture '{name}'; there are {', '.join(every)}")
    wanted = options.names or every
    try:
        from PIL import Image
    except ImportError:
        raise Problem("Pillow is missing; on Debian: apt-get install python3-pil") from None
    program = ROOT / options.program
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for picture, words in RENDERED.items():
            if picture in wanted:
                run(program, "render", *words, "--out", folder / f"{picture}.png")
        if any(picture in wanted for picture in VIEWER):
            script = folder / "script.txt"
            script.write_text(VIEWER_SCRIPT.format(folder=folder), "utf-8")
            run(program, "view", "assets/castle/castle.glb", "--headless", "--algorithm", "chc_plus_plus",
                "--path-frames", "60", "--script", script)
        if "lens_flare" in wanted:
            run(ROOT / options.flare, folder / "lens_flare.png")
        for file in sorted(folder.glob("*.png")):
            if file.stem in wanted:
                keep(Image.open(file), IMAGES / file.name)
        if ANIMATION in wanted:
            animate(program, folder)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Problem as problem:
        print(f"pictures: {problem}", file=sys.stderr)
        sys.exit(2)
