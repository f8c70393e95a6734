"""The Conan recipe of occlude: conan create packaging/conan"""

from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Occlude(ConanFile):
    name = "occlude"
    version = "0.1.0"
    description = "Occlusion culling: what a renderer need not draw"
    license = "MIT"
    topics = ("graphics", "rendering", "occlusion-culling")
    package_type = "static-library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"threads": [True, False], "simd": [True, False], "gl": [True, False]}
    default_options = {"threads": True, "simd": True, "gl": False}

    @property
    def _checkout(self):
        return Path(self.recipe_folder).parents[1]

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "occlude/*", "cmake/*"):
            copy(self, pattern, self._checkout, self.export_sources_folder)

    def requirements(self):
        self.requires("glm/[>=0.9.9.8]", transitive_headers=True)
        if self.options.threads:
            self.requires("onetbb/[>=2021.8]")
        if self.options.simd:
            self.requires("highway/[>=1.0.3]")
        if self.options.gl:
            self.requires("libepoxy/[>=1.5.10]")
            self.requires("egl/system")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for option in ("threads", "simd", "gl"):
            toolchain.cache_variables[f"OCCLUDE_{option.upper()}"] = bool(self.options.get_safe(option))
        for part in ("C", "CONFORMANCE", "TOOLS", "TESTS", "EXAMPLES", "WERROR"):
            toolchain.cache_variables[f"OCCLUDE_{part}"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, Path(self.package_folder) / "licenses")
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_find_mode", "none")  # the package's own occlude-config.cmake
        self.cpp_info.builddirs = ["lib/cmake/occlude"]
        self.cpp_info.libs = ["occlude_gl", "occlude"] if self.options.gl else ["occlude"]
