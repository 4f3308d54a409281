"""The script ``lamella``: runs the package's tool without importing the package."""

import runpy
from importlib.machinery import PathFinder
from pathlib import Path


def main() -> None:
    package = PathFinder.find_spec("lamella")
    assert package is not None and package.origin is not None
    runpy.run_path(str(Path(package.origin).with_name("_tool.py")))["main"]()
