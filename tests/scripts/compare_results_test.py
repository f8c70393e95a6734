#!/usr/bin/env python3
"""Tests scripts/compare_results.py on made-up results: what must count as worse, and what must not."""

import copy
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "compare_results.py"


def example():
    """Results of one entry: chc, whose answers may come at any time, and stop_and_wait."""

    def run(algorithm, reproducible):
        return {
            "algorithm": algorithm,
            "guarantee": "exact",
            "frame_ms": {"median": 10.0},
            "speedup_vs_frustum": 4.0,
            "per_frame": {"queries": 100.0, "triangles_drawn": 5000.0, "waits": 8.0,
                          "wait_ms": 3.0},
            "differing_pixels": 0,
            "decision_hash": "00000000000000aa",
            "decision_hash_reproducible": reproducible,
        }

    return {
        "version": 1,
        "suite": "quick",
        "scale": "small",
        "documents": [
            {
                "entry": "street",
                "scene": {"name": "city", "triangles": 1000},
                "device": {"name": "gl", "renderer": "software"},
                "hierarchy": "bvh",
                "path": "street",
                "size": [640, 360],
                "frames": 24,
                "sets": [],
                "runs": [run("chc", False), run("stop_and_wait", True)],
            }
        ],
    }


class CompareResults(unittest.TestCase):
    def compare(self, change, *options):
        """Exit status and output after `change` was made to the new results."""
        new = copy.deepcopy(example())
        change(new["documents"][0])
        return self.compare_texts(json.dumps(example()), json.dumps(new), *options)

    def compare_texts(self, old, new, *options):
        with tempfile.TemporaryDirectory() as folder:
            files = [Path(folder, name) for name in ("old.json", "new.json")]
            for file, text in zip(files, (old, new)):
                file.write_text(text, encoding="utf-8")
            done = subprocess.run(
                [sys.executable, str(SCRIPT), *map(str, files), *options],
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            return done.returncode, done.stdout + done.stderr

    def assert_worse(self, change, words, *options):
        code, output = self.compare(change, *options)
        self.assertEqual(code, 1, output)
        self.assertIn(words, output)

    def assert_fine(self, change, *options):
        code, output = self.compare(change, *options)
        self.assertEqual(code, 0, output)

    def test_waits_are_a_matter_of_time_unless_runs_repeat(self):
        def wait_more(run):
            def change(document):
                document["runs"][run]["per_frame"]["waits"] = 9.0

            return change

        self.assert_fine(wait_more(0))
        self.assert_worse(wait_more(1), "stop_and_wait: waits per frame grew")

    def test_equal_results_are_fine_and_counted(self):
        code, output = self.compare(lambda document: None)
        self.assertEqual(code, 0)
        self.assertIn("2 runs compared, 0 things worse", output)

    def test_a_counter_of_a_reproducible_run_may_not_grow_at_all(self):
        def grow(document, run, factor=1.01):
            document["runs"][run]["per_frame"]["queries"] *= factor

        self.assert_worse(lambda d: grow(d, 1), "street: stop_and_wait: queries per frame grew")
        self.assert_fine(lambda d: grow(d, 1, 0.5))
        self.assert_fine(lambda d: grow(d, 0))  # chc: within 5 percent
        self.assert_worse(lambda d: grow(d, 0), "chc", "--counter-tolerance", "0.5")
        self.assert_worse(lambda d: grow(d, 0, 1.06), "chc")

    def test_changed_decisions_are_worse_only_where_they_are_reproducible(self):
        def decide(document, run):
            document["runs"][run]["decision_hash"] = "00000000000000ab"

        self.assert_worse(lambda d: decide(d, 1), "decisions changed")
        self.assert_fine(lambda d: decide(d, 0))

    def test_gains_may_fall_within_a_tolerance_and_times_are_not_compared(self):
        def slow(document, gain):
            document["runs"][0].update(speedup_vs_frustum=gain, frame_ms={"median": 1000.0})
            document["runs"][0]["per_frame"]["wait_ms"] = 500.0

        self.assert_fine(lambda d: slow(d, 3.5))
        self.assert_worse(lambda d: slow(d, 3.5), "gain over frustum", "--time-tolerance", "5")
        self.assert_worse(lambda d: slow(d, 3.3), "gain over frustum fell from 4.00 to 3.30")

        def elsewhere(document):
            slow(document, 1.0)
            document["device"]["renderer"] = "another"

        self.assert_fine(elsewhere)

    def test_pixels_and_promises(self):
        def differ(document, guarantee):
            document["runs"][1].update(differing_pixels=3, guarantee=guarantee)

        self.assert_worse(lambda d: differ(d, "exact"), "differing pixels grew from 0 to 3")
        self.assert_worse(lambda d: differ(d, "latent(1)"), "it was exact and is latent(1)")

    def test_what_is_missing_or_measured_in_another_way_is_worse(self):
        self.assert_worse(lambda d: d["runs"].pop(0), "street: chc: not in")
        self.assert_worse(lambda d: d.update(entry="lane"), "street: not in")
        self.assert_worse(lambda d: d.update(frames=25), "frames was 24, is 25")
        self.assert_worse(lambda d: d["scene"].update(triangles=2), "measured in another way")

    def test_results_without_a_suite_are_matched_by_scene_path_and_size(self):
        document = example()["documents"][0]
        del document["entry"]
        text = json.dumps(document)
        self.assertEqual(self.compare_texts(text, text)[0], 0)
        self.assertEqual(self.compare_texts(text, json.dumps([document]))[0], 0)

    def test_unusable_files_and_other_scales_are_refused_by_name(self):
        good = json.dumps(example())
        for bad in ("", "[1, 2]", '{"documents": [{}]}', "nonsense"):
            code, output = self.compare_texts(good, bad)
            self.assertEqual(code, 2, bad)
            self.assertIn("new.json", output)
        full = example()
        full["scale"] = "full"
        code, output = self.compare_texts(good, json.dumps(full))
        self.assertEqual(code, 2)
        self.assertIn("one scale", output)


if __name__ == "__main__":
    unittest.main()
