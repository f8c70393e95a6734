"""check_includes.py finds each kind of violation in made-up trees, and nothing in lawful ones."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import check_includes  # noqa: E402

LAWFUL = {
    "occlude/core/view.h": "#include <glm/vec3.hpp>\n#include <vector>\n",
    "occlude/hierarchy/hierarchy.h": "#include <occlude/core/view.h>\n",
    "occlude/screen/projection.h": "#include <occlude/core/view.h>\n",
    "occlude/hierarchy/builders/bvh.h": "",
    "occlude/hierarchy/builders/bvh.cpp": (
        "#include <occlude/hierarchy/hierarchy.h>\n#include <tbb/parallel_for.h>\n#include <thread>\n"
    ),
    "occlude/scene/scene.h": "#include <occlude/hierarchy/hierarchy.h>\n",
    "occlude/cull/parts/frame.h": "#include <occlude/hierarchy/hierarchy.h>\n",
    "occlude/cull/adaptive/planner.h": "#include <occlude/cull/parts/frame.h>\n",
    "occlude/cull/culler.h": "#include <occlude/cull/adaptive/planner.h>\n",
    "occlude/cull/culler.cpp": (
        "static constexpr int kLimit = 3;\n"
        "static const float kSlop{0.5f};\n"
        "static int helper(int x)\n{\n    return x;\n}\n"
        'const char* text = "glDrawElements"; // glClear, std::mutex\n'
    ),
    "occlude/device/scripted.h": "#include <occlude/core/view.h>\n",
    "occlude/backends/gl/gl_device.cpp": "#include <epoxy/gl.h>\n",
    "occlude/backends/gl/detail/api.h": "#include <epoxy/gl.h>\n",
    "occlude/backends/cpu/raster.cpp": "#include <occlude/screen/projection.h>\n",
    "tools/model/scene.h": "#include <occlude/core/view.h>\n",
    "tools/load/loader.cpp": '#include "model/scene.h"\n#include <assimp/scene.h>\n',
    "tools/main.cpp": '#include "load/loader.cpp"\n',
    "adapters/osg/occlude/osg/culling.h": "#include <occlude/core/view.h>\n#include <osg/Node>\n",
    "adapters/osg/src/culling.cpp": '#include <occlude/osg/culling.h>\n#include "views.h"\n',
}


def problems_with(extra):
    """The sentences about the lawful tree with some files added or replaced."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in {**LAWFUL, **extra}.items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return check_includes.check_tree(Path(folder))[0]


class CheckIncludes(unittest.TestCase):
    def assert_one(self, name, text, sentence):
        problems = problems_with({name: text})
        self.assertEqual(len(problems), 1, problems)
        self.assertTrue(problems[0].startswith(f"{name}:"), problems)
        self.assertIn(sentence, problems[0])

    def test_a_lawful_tree_has_no_problem(self):
        self.assertEqual(problems_with({}), [])

    def test_adapters_see_installed_headers_only(self):
        name = "adapters/osg/src/state.cpp"
        self.assert_one(name, "#include <occlude/backends/gl/detail/api.h>\n", "that are installed")
        self.assert_one(name, "#include <occlude/osg/nothing.h>\n", "does not exist")

    def test_core_includes_no_other_room(self):
        text = "#include <occlude/hierarchy/hierarchy.h>\n"
        self.assert_one("occlude/core/bad.h", text, "core must not include hierarchy")

    def test_core_does_not_know_the_screen(self):
        text = "#include <occlude/screen/projection.h>\n"
        self.assert_one("occlude/core/bad.h", text, "core must not include screen")

    def test_hierarchy_does_not_know_its_builders(self):
        text = "#include <occlude/hierarchy/builders/bvh.h>\n"
        self.assert_one(
            "occlude/hierarchy/bad.h", text, "hierarchy must not include hierarchy/builders"
        )

    def test_parts_do_not_know_the_algorithms(self):
        text = "#include <occlude/cull/culler.h>\n"
        for part in ("parts", "adaptive"):
            self.assert_one(f"occlude/cull/{part}/bad.h", text, f"cull/{part} must not include cull")

    def test_tools_have_rooms_without_circles(self):
        self.assert_one(
            "tools/model/bad.cpp", '#include "load/loader.cpp"\n', "must not include tools/load"
        )
        self.assert_one("tools/model/bad.cpp", '#include "model/gone.h"\n', "does not exist")
        self.assert_one("tools/misc/bad.cpp", "\n", "not a room of the program")

    def test_no_law_goes_in_circles(self):
        for law in (check_includes.ALLOWED, check_includes.TOOLS_ALLOWED):
            for room, targets in law.items():
                for target in targets - {room}:
                    self.assertNotIn(room, law[target], f"{room} and {target}")

    def test_hierarchy_does_not_know_scenes(self):
        text = "#include <occlude/scene/scene.h>\n"
        self.assert_one("occlude/hierarchy/bad.cpp", text, "hierarchy must not include scene")

    def test_cull_does_not_know_scenes(self):
        text = "#include <occlude/scene/scene.h>\n"
        self.assert_one("occlude/cull/bad.h", text, "cull must not include scene")

    def test_backends_see_core_only(self):
        for room in ("backends/gl", "backends/cpu"):
            for path in ("cull/culler.h", "hierarchy/hierarchy.h", "scene/scene.h"):
                text = f"#include <occlude/{path}>\n"
                self.assert_one(f"occlude/{room}/bad.cpp", text, f"{room} must not include")

    def test_one_backend_does_not_see_another(self):
        text = "#include <occlude/backends/gl/detail/api.h>\n"
        self.assert_one("occlude/backends/cpu/bad.cpp", text, "must not include backends/gl")

    def test_devices_see_core_only(self):
        text = "#include <occlude/cull/culler.h>\n"
        self.assert_one("occlude/device/bad.h", text, "device must not include cull")

    def test_cull_includes_no_graphics_api(self):
        self.assert_one("occlude/cull/bad.cpp", "#include <epoxy/gl.h>\n", "must not use")

    def test_cull_names_no_graphics_api(self):
        for word in ("glBeginQuery(1, 2);", "GLuint id;", "vkCmdDraw();", "int x = GL_LESS;"):
            self.assert_one("occlude/cull/bad.cpp", f"{word}\n", "must not name a graphics API")

    def test_cull_uses_no_file_thread_or_clock(self):
        for header in ("fstream", "thread", "chrono", "mutex", "random", "cstdio"):
            text = f"#include <{header}>\n"
            self.assert_one("occlude/cull/bad.cpp", text, "files, threads or clocks")

    def test_cull_has_no_global_state(self):
        for text in ("static int count = 0;\n", "    static std::vector<int> seen;\n",
                     "inline bool verbose{false};\n", "thread_local int depth;\n"):
            self.assert_one("occlude/cull/bad.cpp", text, "outlive a culler")

    def test_public_headers_use_no_third_party_type(self):
        text = "#include <epoxy/gl.h>\n"
        self.assert_one("occlude/backends/gl/bad.h", text, "GLM and std only")
        text = "#include <tbb/task_group.h>\n"
        self.assert_one("occlude/hierarchy/builders/bad.h", text, "GLM and std only")

    def test_public_headers_reach_no_third_party_type_through_private_ones(self):
        text = "#include <occlude/backends/gl/detail/api.h>\n"
        self.assert_one("occlude/backends/gl/bad.h", text, "must not reach <epoxy/gl.h>")

    def test_quoted_includes_are_refused(self):
        self.assert_one("occlude/core/bad.h", '#include "view.h"\n', "write it as <occlude/")

    def test_an_include_of_nothing_is_found(self):
        self.assert_one("occlude/core/bad.h", "#include <occlude/core/gone.h>\n", "does not exist")

    def test_an_unknown_folder_is_found(self):
        self.assert_one("occlude/misc/bad.h", "", "not a room")

    def test_an_empty_tree_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(check_includes.main([folder]), 1)


if __name__ == "__main__":
    unittest.main()
