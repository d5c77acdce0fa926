#!/usr/bin/env python3
"""The recipes of packaging/ name the libraries that cmake/components.cmake finds, and no others."""

import json
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# The names of a package in CMake, vcpkg and Conan.
NAMES = {
    "Eigen3": ("eigen3", "eigen"),
    "TBB": ("tbb", "onetbb"),
    "fmt": ("fmt", "fmt"),
    "CGAL": ("cgal", "cgal"),
    "ZLIB": ("zlib", "zlib"),
    "ISAL": ("isal", "isa-l"),
    "OpenVDB": ("openvdb", "openvdb"),
    "zstd": ("zstd", "zstd"),
    "TinyGLTF": ("tinygltf", "tinygltf"),
    "LZ4": ("lz4", "lz4"),
    "LibLZMA": ("liblzma", "xz_utils"),
    "LibDeflate": ("libdeflate", "libdeflate"),
    "EXPAT": ("expat", "expat"),
    "CURL": ("curl", "libcurl"),
    "meshoptimizer": ("meshoptimizer", "meshoptimizer"),
    "draco": ("draco", "draco"),
    "tl-expected": ("tl-expected", "tl-expected"),
    "nlohmann_json": ("nlohmann-json", "nlohmann_json"),
}
# Those behind an option, which neither recipe needs.
OPTIONAL = {"CGAL", "CURL", "meshoptimizer", "draco"}
NOWHERE = {"TetGen"}


def found_by_cmake():
    """What the library's list finds, and the headers that the build needs."""
    components = (ROOT / "cmake/components.cmake").read_text()
    names = set(re.findall(r"t4d_find\((\w+)", components))
    if "include(T4dOpenVDB)" in components:
        names.add("OpenVDB")
    target = (ROOT / "cmake/T4dTarget.cmake").read_text()
    return names | set(re.findall(r"find_package\(([\w-]+) REQUIRED", target))


def options_of_cmake():
    return set(re.findall(r"option\(T4D_WITH_(\w+)", (ROOT / "CMakeLists.txt").read_text()))


class Recipes(unittest.TestCase):
    def setUp(self):
        self.packages = found_by_cmake()

    def test_each_package_has_a_name_in_both(self):
        self.assertEqual(self.packages, set(NAMES) | NOWHERE)

    def test_vcpkg_names_the_packages(self):
        recipe = json.loads((ROOT / "packaging/vcpkg/vcpkg.json").read_text())
        needed = {name for name in recipe["dependencies"] if isinstance(name, str)}
        self.assertEqual(needed, {NAMES[package][0] for package in self.packages - OPTIONAL - NOWHERE})
        optional = {name for feature in recipe["features"].values() for name in feature["dependencies"]}
        self.assertEqual(optional, {NAMES[package][0] for package in OPTIONAL})

    def test_conan_names_the_packages(self):
        recipe = (ROOT / "packaging/conan/conanfile.py").read_text()
        needed = set(re.findall(r'^        self\.requires\("([\w-]+)/', recipe, re.M))
        self.assertEqual(needed, {NAMES[package][1] for package in self.packages - OPTIONAL - NOWHERE})
        optional = set(re.findall(r'^            self\.requires\("([\w-]+)/', recipe, re.M))
        self.assertEqual(optional, {NAMES[package][1] for package in OPTIONAL})

    def test_both_leave_tetgen_out(self):
        self.assertIn("-DT4D_WITH_TETGEN=OFF", (ROOT / "packaging/vcpkg/portfile.cmake").read_text())
        self.assertIn('"with_tetgen": False', (ROOT / "packaging/conan/conanfile.py").read_text())

    def test_options_are_those_of_the_build(self):
        portfile = (ROOT / "packaging/vcpkg/portfile.cmake").read_text()
        conan = (ROOT / "packaging/conan/conanfile.py").read_text()
        used = set(re.findall(r"T4D_WITH_(\w+)", portfile)) | {name.upper() for name in re.findall(r'"with_(\w+)"', conan)}
        self.assertEqual(used, options_of_cmake() - {"RSVG", "HTTPLIB"})  # of the program

    def test_the_version_is_that_of_the_library(self):
        header = (ROOT / "include/t4d/version.h").read_text()
        version = ".".join(re.findall(r"#define T4D_VERSION_\w+ ([0-9]+)", header))
        self.assertEqual(json.loads((ROOT / "packaging/vcpkg/vcpkg.json").read_text())["version-semver"], version)


if __name__ == "__main__":
    unittest.main()
