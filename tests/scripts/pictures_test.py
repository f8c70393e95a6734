"""Tests scripts/pictures.py: it makes every picture there is, in the colours that the program uses."""

import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import pictures  # noqa: E402


class Pictures(unittest.TestCase):
    def test_every_picture_of_the_documentation_is_made_by_the_command(self):
        made = {f"{name}.png" for name in [*pictures.RENDERED, *pictures.VIEWER, "lens_flare"]}
        made.add(f"{pictures.ANIMATION}.webp")
        there = {path.name for path in pictures.IMAGES.iterdir() if path.suffix != ".svg"}
        self.assertEqual(there, made)

    def test_the_animation_is_small(self):
        size = (pictures.IMAGES / f"{pictures.ANIMATION}.webp").stat().st_size
        self.assertLessEqual(size, pictures.MOST_ANIMATION_BYTES)

    def test_the_legend_has_the_colours_of_the_palette(self):
        colors = dict(pictures.palette((ROOT / "tools" / "render" / "palette.h").read_text("utf-8")))
        self.assertEqual(len(colors), 8)
        self.assertEqual(colors["drawn"], (0, 158, 115))
        self.assertEqual(len(set(colors.values())), 8)

    def test_every_picture_is_shown(self):
        pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
        text = "".join(page.read_text("utf-8") for page in pages)
        unseen = [path.name for path in pictures.IMAGES.iterdir() if f"images/{path.name}" not in text]
        self.assertEqual(unseen, [])


if __name__ == "__main__":
    unittest.main()
