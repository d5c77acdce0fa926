"""A recipe for Conan 2 of this checkout: `conan create packaging/conan --build=missing`.

Held against cmake/components.cmake by tests/recipes_test.py.
"""

import re
from pathlib import Path

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy

ROOT = Path(__file__).resolve().parents[2]


class T4d(ConanFile):
    name = "t4d"
    description = "4D meshes: the boundary of a moving solid in space-time"
    license = "Apache-2.0"
    settings = "os", "arch", "compiler", "build_type"
    options = {
        "shared": [True, False],
        "fPIC": [True, False],
        "with_tetgen": [True, False],
        "with_cgal": [True, False],
        "with_curl": [True, False],
        "with_draco": [True, False],
        "with_meshoptimizer": [True, False],
    }
    # Conan Center has no TetGen: with one of the system's, with_tetgen=True.
    default_options = {
        "shared": False,
        "fPIC": True,
        "with_tetgen": False,
        "with_cgal": False,
        "with_curl": True,
        "with_draco": True,
        "with_meshoptimizer": True,
    }

    def set_version(self):
        header = (ROOT / "include" / "t4d" / "version.h").read_text()
        self.version = ".".join(re.findall(r"#define T4D_VERSION_\w+ ([0-9]+)", header))

    def export_sources(self):
        for folder in ("include", "model", "platform", "fixtures", "slice", "mesh4d", "voxel4d", "formats", "convert",
                       "measure", "mill", "edit", "tools", "conformance", "cmake", "docs", "examples", "web"):  # fmt: skip
            copy(self, f"{folder}/*", ROOT, self.export_sources_folder, excludes="*/node_modules/*")
        for file in ("CMakeLists.txt", "LICENSE", "NOTICE", "*.md"):
            copy(self, file, ROOT, self.export_sources_folder)

    def requirements(self):
        self.requires("eigen/3.4.0", transitive_headers=True)
        self.requires("expat/[>=2.5 <3]")
        self.requires("fmt/[>=9.1 <11]")
        self.requires("isa-l/[>=2.30 <3]")
        self.requires("libdeflate/[>=1.14 <2]")
        self.requires("lz4/[>=1.9 <2]")
        self.requires("nlohmann_json/[>=3.11 <4]")
        self.requires("onetbb/[>=2021.8 <2022]")
        self.requires("openvdb/[>=10 <12]")
        self.requires("tinygltf/[>=2.7 <3]")
        self.requires("tl-expected/[>=1.0 <2]", transitive_headers=True)
        self.requires("xz_utils/[>=5.4 <6]")
        self.requires("zlib/[>=1.2.13 <2]")
        self.requires("zstd/[>=1.5 <1.6]")
        if self.options.with_cgal:
            self.requires("cgal/[>=5.5 <7]")
        if self.options.with_curl:
            self.requires("libcurl/[>=7.85 <9]")
        if self.options.with_draco:
            self.requires("draco/[>=1.5 <2]")
        if self.options.with_meshoptimizer:
            self.requires("meshoptimizer/[>=0.18 <1]")

    def validate(self):
        if self.settings.os != "Linux":
            raise ConanInvalidConfiguration("t4d with all of its components runs on Linux only")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for library in ("tetgen", "cgal", "curl", "draco", "meshoptimizer"):
            toolchain.cache_variables[f"T4D_WITH_{library.upper()}"] = bool(self.options.get_safe(f"with_{library}"))
        for part in ("PROGRAM", "READER", "TESTS", "BENCHMARKS", "PYTHON"):
            toolchain.cache_variables[f"T4D_BUILD_{part}"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        self.cpp_info.builddirs = ["lib/cmake/t4d"]
        self.cpp_info.set_property("cmake_find_mode", "none")
