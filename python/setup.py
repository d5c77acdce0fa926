"""A wheel of the module with the program: builds both with CMake, in T4D_BUILD or a folder of its own.

It links to the libraries of the system that it was built on, so it is for such systems alone.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("T4D_BUILD", ROOT / "build" / "wheel"))


class BuildWithCMake(build_py):
    def run(self):
        if not (BUILD / "CMakeCache.txt").exists():
            subprocess.run(
                ["cmake", "-S", ROOT, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release", "-DT4D_BUILD_TESTS=OFF",
                 "-DT4D_BUILD_BENCHMARKS=OFF", "-DT4D_BUILD_PYTHON=ON",
                 f"-DPython_EXECUTABLE={sys.executable}", "-Wno-dev"],
                check=True,
            )  # fmt: skip
        subprocess.run(
            ["cmake", "--build", BUILD, "--parallel", "--target", "t4d_python", "t4d_python_verbs", "t4d_blender", "t4d"],
            check=True,
        )
        package = Path(self.build_lib) / "t4d"
        shutil.rmtree(package, ignore_errors=True)
        shutil.copytree(BUILD / "python" / "t4d", package, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy2(BUILD / "blender" / "io_mesh_t4d.zip", package)  # for t4d-blender
        (package / "bin").mkdir()
        for path in (BUILD / "t4d", *BUILD.glob("t4d_*.so")):
            shutil.copy2(path, package / "bin" / path.name)


class BinaryDistribution(Distribution):
    def has_ext_modules(self):
        return True


version = re.findall(r"#define T4D_VERSION_\w+ ([0-9]+)", (ROOT / "include" / "t4d" / "version.h").read_text())
setup(
    version=".".join(version),
    packages=["t4d", "t4d.readers"],
    data_files=[("share/t4d/paraview", ["paraview/t4d_reader.py"])],
    cmdclass={"build_py": BuildWithCMake},
    distclass=BinaryDistribution,
)
