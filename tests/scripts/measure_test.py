"""Tests scripts/measure.py on made-up results: the tables, the pages, and what it refuses."""

import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import measure  # noqa: E402

ENTRY = {
    "name": "castle",
    "page": "side_by_side",
    "title": "The castle",
    "text": "A walk.",
    "rows": [{"label": "castle", "command": "occlude bench castle.glb"}],
    "columns": [
        {"title": "ms", "value": "frame_ms.median", "run": "chc"},
        {"title": "triangles", "value": "per_frame.triangles_drawn", "run": "frustum"},
    ],
}


def run(algorithm, median, triangles, hierarchy="bvh"):
    return {
        "algorithm": algorithm,
        "hierarchy": hierarchy,
        "frame_ms": {"median": median},
        "per_frame": {"triangles_drawn": triangles},
    }


def kept(runs):
    document = {"scene": {"name": "castle"}, "device": {"renderer": "llvmpipe"}, "runs": runs}
    return {
        "name": "castle",
        "date": "2026-11-30",
        "commit": "abc1234",
        "machine": "a processor, 2 cores",
        "rows": [{"command": "occlude bench castle.glb", "document": document}],
    }


RESULT = kept([run("frustum", 20.0, 114462.0), run("chc", 12.345, 41527.0)])


class Measure(unittest.TestCase):
    def test_numbers_have_three_digits(self):
        cases = {12.345: "12.3", 0: "0", 114462.4: "114,462", 0.001234: "0.00123", 3.0: "3"}
        for value, text in cases.items():
            self.assertEqual(measure.shown(value), text)

    def test_a_table_of_runs_has_a_row_for_each_run(self):
        text = measure.table(ENTRY, RESULT)
        self.assertIn("| `frustum` | 20 | 114,462 |", text)
        self.assertIn("| `chc` | 12.3 | 41,527 |", text)

    def test_a_table_of_rows_names_runs_in_its_columns(self):
        text = measure.table({**ENTRY, "table": "rows"}, RESULT)
        self.assertIn("| castle | 12.3 | 114,462 |", text)

    def test_several_commands_name_their_rows(self):
        entry = {**ENTRY, "rows": [{"label": "castle", "command": "a"}, {"label": "city", "command": "b"}]}
        text = measure.table(entry, {**RESULT, "rows": RESULT["rows"] * 2})
        self.assertIn("| castle, `chc` | 12.3", text)
        self.assertIn("| city, `chc` | 12.3", text)

    def test_a_column_can_be_a_ratio_to_another_run_on_the_same_tree(self):
        runs = [run("frustum", 20.0, 100.0), run("chc", 5.0, 25.0)]
        runs += [run("frustum", 20.0, 200.0, "bsp"), run("chc", 5.0, 100.0, "bsp")]
        column = {"title": "share", "value": "per_frame.triangles_drawn", "over": "frustum"}
        text = measure.table({**ENTRY, "columns": [column]}, kept(runs))
        self.assertIn("| `chc` | 0.25 |", text)
        self.assertIn("| `chc` | 0.5 |", text)

    def test_a_table_of_tests_shows_what_they_recorded(self):
        entry = {
            **ENTRY,
            "table": "tests",
            "columns": [{"title": "device", "value": "device"}, {"title": "time", "value": "time_of_best"}],
        }
        tests = [{"name": "A", "device": "late answers", "time_of_best": "1.02345"}, {"name": "B"}]
        document = {"testsuites": [{"testsuite": tests}]}
        text = measure.table(entry, {**RESULT, "rows": [{"command": "test_cull", "document": document}]})
        self.assertIn("| late answers | 1.02 |", text)
        self.assertEqual(len(text.splitlines()), 3)

    def test_results_of_other_commands_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "castle.json").write_text(json.dumps(RESULT))
            entry = {**ENTRY, "rows": [{"label": "castle", "command": "occlude bench other.glb"}]}
            with self.assertRaises(measure.Problem):
                measure.page_texts(root, [entry], root)

    def test_a_page_without_a_measurement_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            pages = Path(folder) / "docs" / "measurements"
            pages.mkdir(parents=True)
            for name in ("side_by_side", "README", "by_hand"):
                (pages / f"{name}.md").write_text("")
            found = measure.pages_of_nothing(Path(folder), [ENTRY])
            self.assertEqual([path.stem for path in found], ["by_hand"])

    def test_a_block_can_show_some_rows(self):
        self.assertNotIn("frustum", measure.table(ENTRY, RESULT, ["chc"]))
        with self.assertRaises(measure.Problem):
            measure.table(ENTRY, RESULT, ["nobody"])

    def test_a_section_names_command_commit_date_and_machine(self):
        text = measure.section(ENTRY, RESULT)
        for part in ("occlude bench castle.glb", "abc1234", "2026-11-30", "2 cores", "llvmpipe"):
            self.assertIn(part, text)

    def test_single_frames_are_not_kept(self):
        document = {"frames": 3, "runs": [{"frames": [{"ms": 1}], "algorithm": "chc"}]}
        self.assertEqual(
            measure.without_frames(document), {"frames": 3, "runs": [{"algorithm": "chc"}]}
        )

    def test_pages_and_blocks_are_written_from_results(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            (root / "docs").mkdir()
            (root / "results").mkdir()
            (root / "README.md").write_text("<!-- measured: castle chc -->\nold\n<!-- end -->\n")
            (root / "results" / "castle.json").write_text(json.dumps(RESULT))
            texts = measure.page_texts(root, [ENTRY], root / "results")
            self.assertIn("## The castle", texts[root / "docs" / "measurements" / "side_by_side.md"])
            self.assertIn("| `chc` | 12.3", texts[root / "README.md"])
            self.assertNotIn("old", texts[root / "README.md"])
            (root / "README.md").write_text("<!-- measured: gone -->\n<!-- end -->\n")
            with self.assertRaises(measure.Problem):
                measure.page_texts(root, [ENTRY], root / "results")

    def test_a_command_must_start_with_a_known_program(self):
        with self.assertRaises(measure.Problem):
            measure.run_command("rm -rf nothing", {"occlude": "occlude"})

    def test_every_measurement_of_the_repository_is_complete(self):
        names = [entry["name"] for entry in measure.load_measurements()]
        self.assertEqual(len(names), len(set(names)))


if __name__ == "__main__":
    unittest.main()
