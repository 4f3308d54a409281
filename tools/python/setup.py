"""Builds the native module with CMake: of the engine in this repository, or of an installed one in CMAKE_PREFIX_PATH."""

import os
import re
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

FOLDER = Path(__file__).resolve().parent
VERSION_FILE = FOLDER.parent.parent / "include" / "lamella" / "version.hpp"


class CMakeBuild(build_ext):
    """Builds in setuptools' own folder for temporary files."""

    def build_extension(self, ext):
        build = Path(self.build_temp).resolve()
        target = Path(self.get_ext_fullpath(ext.name)).resolve()
        build.mkdir(parents=True, exist_ok=True)
        target.parent.mkdir(parents=True, exist_ok=True)
        configure = ["cmake", "-S", FOLDER, "-B", build, "-DCMAKE_BUILD_TYPE=Release", f"-DLAMELLA_PYTHON={sys.executable}"]
        subprocess.run([*configure, *os.environ.get("CMAKE_ARGS", "").split()], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "lamella_python_package", "--parallel", str(os.cpu_count() or 1)], check=True)
        made = build / "python" / "lamella"
        for path in (made / target.name, made / "_option_table.py", *made.glob("bin/*")):
            to = target.parent / path.relative_to(made)
            to.parent.mkdir(exist_ok=True)
            self.copy_file(str(path), str(to))


setup(
    version=re.search(r'version = "([^"]+)"', VERSION_FILE.read_text()).group(1),
    ext_modules=[Extension("lamella._native", sources=[])],
    cmdclass={"build_ext": CMakeBuild},
)
