"""check_shape.py finds each kind of violation in made-up trees, and nothing where the rules are kept."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import check_shape  # noqa: E402


def problems_with(files, still_long=frozenset()):
    """The sentences about a tree of these files."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, text in files.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return check_shape.check_tree(root, still_long)[0]


def function(length, indent=""):
    """A function whose body has that many lines."""
    body = "".join(f"{indent}    ++count;\n" for _ in range(length))
    return f"{indent}void run()\n{indent}{{\n{body}{indent}}}\n"


def class_of(member_lines):
    """A class with these lines in its private part."""
    body = "".join(f"    {line}\n" for line in member_lines)
    return f"class Culler final : public Base {{\npublic:\n    void run() {{ ++n; }}\n\nprivate:\n{body}}};\n"


class Files(unittest.TestCase):
    def test_400_lines_are_allowed_and_401_are_not(self):
        self.assertEqual(problems_with({"occlude/core/a.cpp": "int a;\n" * 400}), [])
        found = problems_with({"occlude/core/a.cpp": "int a;\n" * 401})
        self.assertEqual(len(found), 1)
        self.assertTrue(found[0].startswith("occlude/core/a.cpp:1: has 401 lines"))

    def test_a_reason_in_the_head_lets_a_file_be_long(self):
        head = "// Tables of figures.\n// Long because: one row per figure of the paper.\n"
        self.assertEqual(problems_with({"tools/a.cpp": head + "int a;\n" * 500}), [])

    def test_a_reason_elsewhere_or_an_empty_one_does_not(self):
        for text in ("int a;\n" * 401 + "// Long because: it is.\n", "// Long because:\n" + "int a;\n" * 401):
            self.assertEqual(len(problems_with({"tools/a.cpp": text})), 1)

    def test_what_is_listed_is_let_through_by_that_rule_only(self):
        long_file = {"tests/a.cpp": "int a;\n" * 401}
        self.assertEqual(problems_with(long_file, {("tests/a.cpp", "file")}), [])
        self.assertEqual(len(problems_with(long_file, {("tests/a.cpp", "class")})), 1)


class Functions(unittest.TestCase):
    def test_60_lines_are_allowed_and_61_are_not(self):
        for indent in ("", "    "):
            self.assertEqual(problems_with({"occlude/core/a.h": function(60, indent)}), [])
            self.assertEqual(
                problems_with({"occlude/core/a.h": function(61, indent)}),
                ["occlude/core/a.h:2: this function has 61 lines; the limit is 60"],
            )

    def test_two_functions_are_counted_apart(self):
        self.assertEqual(problems_with({"occlude/core/a.cpp": function(40) + function(40)}), [])


class Classes(unittest.TestCase):
    def test_15_members_are_allowed_and_16_are_not(self):
        members = [f"std::map<int, std::vector<int>> m{i}_;" for i in range(14)]
        self.assertEqual(problems_with({"occlude/a.h": class_of(members + ["int last_ = f(3);"])}), [])
        found = problems_with({"occlude/a.h": class_of(members + ["int a_ = f(3);", "Box b_{1, 2};"])})
        self.assertEqual(found, ["occlude/a.h:1: class Culler has 16 data members; the limit is 15"])

    def test_functions_types_and_constants_are_no_members(self):
        others = [f"int f{i}(int x) const;" for i in range(9)] + [f"static constexpr int k{i} = {i};" for i in range(9)]
        others += ["using Map = std::map<int, int>;", "friend class Other;", "struct Node {", "    int deep;", "};"]
        self.assertEqual(problems_with({"occlude/a.h": class_of(others * 3)}), [])

    def test_a_struct_is_plain_data(self):
        text = class_of([f"int m{i};" for i in range(30)]).replace("class Culler", "struct Culler")
        self.assertEqual(problems_with({"occlude/a.h": text}), [])


class Includes(unittest.TestCase):
    def test_a_circle_is_found_and_a_diamond_is_none(self):
        diamond = {
            "occlude/a.h": "#include <occlude/b.h>\n#include <occlude/c.h>\n",
            "occlude/b.h": "#include <occlude/d.h>\n",
            "occlude/c.h": "#include <occlude/d.h>\n",
            "occlude/d.h": "",
        }
        self.assertEqual(problems_with(diamond), [])
        diamond["occlude/d.h"] = "#include <occlude/a.h>\n"
        self.assertEqual(problems_with(diamond), ["occlude/d.h:1: includes occlude/a.h, which includes it again"])

    def test_the_includes_of_the_tools_are_followed_too(self):
        files = {"tools/model/a.h": '#include "model/b.h"\n', "tools/model/b.h": '#include "model/a.h"\n'}
        self.assertEqual(len(problems_with(files)), 1)


if __name__ == "__main__":
    unittest.main()
