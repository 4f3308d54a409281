"""The command line tool that comes with the package: ``python -m lamella``, and ``lamella`` on the path of the environment.

Imports nothing of the package, so that a command begins at once: `pip` makes a script of main() that finds it by its path.
"""

import os
import sys
from typing import NoReturn, Optional


def find_tool() -> Optional[str]:
    """The path of the program, if the package was built with it."""
    name = "lamella.exe" if os.name == "nt" else "lamella"
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", name)
    return path if os.path.exists(path) else None


def main() -> NoReturn:
    tool = find_tool()
    if tool is None:
        sys.exit("lamella: this package was built without the command line tool")
    if os.name == "nt":
        import subprocess

        sys.exit(subprocess.call([tool, *sys.argv[1:]]))
    os.execv(tool, ["lamella", *sys.argv[1:]])
