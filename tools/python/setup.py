"""Builds the native module with CMake: of the engine in this repository, or of an installed one in CMAKE_PREFIX_PATH.

A source distribution carries what of the repository the build needs in its folder "sources".
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.sdist import sdist

FOLDER = Path(__file__).resolve().parent
ROOT = next(path for path in (FOLDER / "sources", FOLDER.parent.parent) if (path / "include").exists())
SOURCES = ("LICENSE", "CMakeLists.txt", "engine", "include", "tools/CMakeLists.txt", "tools/lamella", "tools/models",
           *(f"tools/python/{name}" for name in ("CMakeLists.txt", "interpreter.cmake", "native", "src")))
# As CMake names what it misses.
DEBIAN_PACKAGES = {
    "CMAKE_CXX_COMPILER": "g++", "Unix": "make", "Ninja": "ninja-build", "PkgConfig": "pkg-config", "TBB": "libtbb-dev",
    "EXPAT": "libexpat1-dev", "ZLIB": "zlib1g-dev", "libzip": "libzip-dev", "FastFloat": "libfast-float-dev",
    "nlohmann_json": "nlohmann-json3-dev", "OpenSSL": "libssl-dev", "CLI11": "libcli11-dev", "mimalloc": "libmimalloc-dev",
    "Python": "python3-dev python3-numpy pybind11-dev",
}


def missing(package):
    sys.exit(f"lamella: what it is built with is missing; on Debian, as root: apt-get install {package}")


def configure(command):
    if shutil.which("cmake") is None:
        missing("cmake")
    cmake = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(cmake.stdout, flush=True)
    if cmake.returncode:
        named = re.findall(r'(?:Could NOT find |No |no |provided by\s+"|Package \'|corresponding to\s+")(\w+)', cmake.stdout)
        for name in named:
            if name in DEBIAN_PACKAGES:
                missing(DEBIAN_PACKAGES[name])
        sys.exit("lamella: cmake failed; its message is above")


class CMakeBuild(build_ext):
    """Builds in setuptools' own folder for temporary files."""

    def build_extension(self, ext):
        build = Path(self.build_temp).resolve()
        target = Path(self.get_ext_fullpath(ext.name)).resolve()
        build.mkdir(parents=True, exist_ok=True)
        target.parent.mkdir(parents=True, exist_ok=True)
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1))
        print(f"lamella: compiling the engine by {jobs} processes at once, which takes minutes", flush=True)
        configure(["cmake", "-S", str(ROOT / "tools" / "python"), "-B", str(build), "-DCMAKE_BUILD_TYPE=Release",
                   f"-DLAMELLA_PYTHON={sys.executable}", *shlex.split(os.environ.get("CMAKE_ARGS", ""))])
        subprocess.run(["cmake", "--build", build, "--target", "lamella_python_package", "--parallel", jobs], check=True)
        made = build / "python" / "lamella"
        for path in (made / target.name, made / "_option_table.py", *made.glob("bin/*")):
            to = target.parent / path.relative_to(made)
            to.parent.mkdir(exist_ok=True)
            self.copy_file(str(path), str(to))


class WithSources(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        for name in SOURCES:
            to = Path(base_dir, "sources", name)
            to.parent.mkdir(parents=True, exist_ok=True)
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, to, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
            else:
                shutil.copy(ROOT / name, to)
        shutil.copy(ROOT / "LICENSE", base_dir)


setup(
    version=re.search(r'version = "([^"]+)"', (ROOT / "include" / "lamella" / "version.hpp").read_text()).group(1),
    ext_modules=[Extension("lamella._native", sources=[])],
    cmdclass={"build_ext": CMakeBuild, "sdist": WithSources},
)
