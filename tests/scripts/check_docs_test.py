"""check_docs.py finds only the names of missing things, in made-up repositories."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import check_docs  # noqa: E402

REPOSITORY = {
    "occlude/cull/chc.h": 'class Chc { void cull(); };\nvisit("threshold", o.threshold, "samples");\n',
    "occlude/cull/chc.cpp": 'const char* name = "chc";\n',
    "tools/commands/cli.cpp": 'add_option("--frames"); add_option("--set"); add_subcommand("bench");\n',
    "docs/guide.md": "# The guide\n",
}


def problems_with(page, extra=None, program=None):
    """The sentences about a repository whose README.md is `page`."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, text in {**REPOSITORY, "README.md": page, **(extra or {})}.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        if program:
            script = root / "program"
            script.write_text(program, encoding="utf-8")
            script.chmod(0o755)
        return check_docs.problems_of(root, str(root / "program") if program else None)


class Names(unittest.TestCase):
    def test_what_exists_is_no_problem(self):
        page = (
            "[guide](docs/guide.md#the-guide) `occlude/cull/chc.{h,cpp}` `cull/chc.h` `chc.h` `Chc::cull()` "
            "`--set chc.threshold=20` `--frames`\n"
        )
        self.assertEqual(problems_with(page), [])

    def test_a_link_or_an_anchor_that_leads_nowhere(self):
        self.assertEqual(problems_with("[a](docs/none.md)"), ["README.md: docs/none.md does not exist"])
        self.assertEqual(problems_with("[a](docs/guide.md#no)"), ["README.md: docs/guide.md#no names no heading"])

    def test_a_file_that_is_gone_or_half_there(self):
        self.assertEqual(problems_with("`cull/old.h`"), ["README.md: there is no file `cull/old.h`"])
        half = {"occlude/cull/half.h": ""}
        self.assertEqual(len(problems_with("`occlude/cull/half.{h,cpp}`", half)), 1)

    def test_a_function_that_nobody_has(self):
        self.assertEqual(problems_with("`Chc::refit()`"), ["README.md: `Chc::refit()`: nothing is called refit"])

    def test_an_option_of_the_program_or_of_an_algorithm_that_nobody_has(self):
        self.assertEqual(problems_with("`--frame`"), ["README.md: `--frame`: there is no option --frame"])
        found = problems_with("`--set chc.treshold=3`")
        self.assertEqual(len(found), 1)
        self.assertIn("no option treshold", found[0])

    def test_placeholders_stand_for_what_the_reader_writes(self):
        self.assertEqual(problems_with("`occlude/cull/my_culler.h` `--set my_culler.option=1`"), [])

    def test_the_changelog_speaks_of_the_past(self):
        self.assertEqual(problems_with("", {"CHANGELOG.md": "`cull/old.h` `--gone`\n"}), [])

    def test_an_algorithm_without_a_page_or_a_row(self):
        header = {"occlude/cull/lazy.h": '.name = "lazy",\n'}
        self.assertEqual(
            problems_with("", header),
            ["docs/algorithms: no page is headed `# lazy`", "README.md: no row of a table begins with lazy"],
        )
        page = "# lazy\n\n## The idea\n\n## How to use it\n\n## Cost\n"
        found = problems_with("| `lazy` | does little |\n", {**header, "docs/algorithms/lazy.md": page})
        self.assertEqual(found, ["docs/algorithms/lazy.md: there is no heading `## When not to use`"])
        whole = {**header, "docs/algorithms/lazy.md": page + "\n## When not to use it\n"}
        self.assertEqual(problems_with("| `lazy` | does little |\n", whole), [])

    def test_a_header_that_names_a_file_which_is_gone(self):
        found = problems_with("", {"occlude/core/view.h": "// See cull/old.h.\n"})
        self.assertEqual(found, ["occlude/core/view.h: there is no file cull/old.h"])


class Commands(unittest.TestCase):
    HELP = '#!/bin/sh\n[ "$1" = bench ] && echo "--frames N --set X" && exit 0\nexit 2\n'

    def test_a_command_that_the_program_takes(self):
        page = "```\nocclude bench castle.glb \\\n    --frames 3 --set chc.threshold=2\n```\n"
        self.assertEqual(problems_with(page, program=self.HELP), [])

    def test_an_unknown_option_is_found_even_without_the_program(self):
        self.assertEqual(len(problems_with("```\nocclude bench --frams 3\n```\n")), 1)

    def test_an_option_of_another_command_and_an_unknown_command(self):
        other = {"tools/commands/other.cpp": 'add_option("--out")'}
        found = problems_with("```\nocclude bench --out x.png\n```\n", other, self.HELP)
        self.assertEqual(found, ["README.md: occlude bench --out x.png: bench has no option --out"])
        found = problems_with("```\nocclude bake x\n```\n", program=self.HELP)
        self.assertEqual(found, ["README.md: occlude bake x: occlude has no command bake"])

    def test_quotes_that_do_not_end(self):
        self.assertEqual(len(problems_with("```\nocclude bench 'x\n```\n")), 1)


if __name__ == "__main__":
    unittest.main()
