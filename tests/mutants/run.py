#!/usr/bin/env python3
"""Mutation testing: does the suite catch bugs that were put in on purpose?

Applies each mutant of mutants.txt (all by default) to a copy of the sources, builds, and runs the tests until one fails.
Fails if a mutant survives, does not compile, or no longer fits the sources.
"""
import argparse
import filecmp
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
COPIED = ("CMakeLists.txt", "engine", "include", "tests", "tools", "bench/baselines")
MUTATED = ("engine", "tools", "include")
TEST_SECONDS, TEST_BYTES = 600, 16 << 30  # a mutant may loop, or allocate, for ever


class Unfit(Exception):
    """A table entry that is malformed or does not fit the sources."""


class Edit(NamedTuple):
    file: str
    old: list  # of lines
    new: list


class Mutant:
    def __init__(self, entry):
        self.fields, self.edits = {}, []
        before = ""
        for line in entry.splitlines():
            mark, text = line[:1], line[2:]
            if mark == "-":
                if before != "-":
                    self.edits.append(Edit(self.fields.get("file"), [], []))
                self.edits[-1].old.append(text)
            elif mark == "+" and before:
                self.edits[-1].new.append(text)
            elif field := re.fullmatch(r"(name|bug|tests|needs|file): (.+)", line):
                mark = ""
                self.fields[field[1]] = field[2]
            else:
                raise Unfit(f"the table has a line of no known form: {line}")
            before = mark
        self.name = self.fields.get("name")
        complete = {"name", "bug", "tests", "file"} <= self.fields.keys() and self.edits
        if not complete or not all(edit.file and "".join(edit.old).strip() for edit in self.edits):
            raise Unfit(f"an entry must have name, bug, tests, file and an old text:\n{entry}")

    def problem(self):
        """Why it does not fit the sources, or None."""
        try:
            self.mutated()
        except Unfit as problem:
            return str(problem)

    def mutated(self):
        """By path from the root: the new texts of the files that the mutant changes."""
        texts = {}
        for edit in self.edits:
            path, match = self.find(edit, texts)
            texts[path] = match.string[: match.start()] + "\n".join(edit.new) + match.string[match.end() :]
        return texts

    def find(self, edit, texts):
        old = "\n".join(edit.old)
        if words(old) == words("\n".join(edit.new)):
            raise Unfit(f"{self.name}: the new text is the old one: {old}")
        paths = [path.relative_to(ROOT) for folder in MUTATED for path in (ROOT / folder).rglob(edit.file)]
        found = []
        for path in paths:
            text = texts[path] if path in texts else (ROOT / path).read_text()
            found += [(path, match) for match in pattern(old).finditer(text)]
        if not found:
            raise Unfit(f"{self.name}: not in {' or '.join(map(str, paths)) or f'any file named {edit.file}'}: {old}")
        if len(found) > 1:
            places = ", ".join(f"{path}:{match.string.count(chr(10), 0, match.start()) + 1}" for path, match in found)
            raise Unfit(f"{self.name}: there {len(found)} times ({places}): {old}")
        return found[0]


def words(text):
    return re.findall(r"\w+|[^\w\s]", text)


def pattern(text):
    """A pattern for `text` with any white space between its words and signs."""
    parts = words(text)
    begin, end = (r"\b" if re.match(r"\w", part) else "" for part in (parts[0], parts[-1]))
    return re.compile(begin + r"\s*".join(map(re.escape, parts)) + end)


def read_table(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    mutants = [Mutant(entry.strip()) for entry in re.split(r"\n{2,}", "\n".join(lines)) if entry.strip()]
    if not mutants:
        raise Unfit(f"no mutants in {path}")
    names = [mutant.name for mutant in mutants]
    if twice := {name for name in names if names.count(name) > 1}:
        raise Unfit(f"names given twice: {', '.join(sorted(twice))}")
    return mutants


class Suite:
    """A copy of the sources and its build."""

    def __init__(self, folder):
        self.folder, self.build, self.log = folder, folder / "build", folder / "log"
        self.copy_sources()
        options = ["-DCMAKE_BUILD_TYPE=Release", "-DLAMELLA_BUILD_BENCH=OFF", "-DLAMELLA_SHARED_MODELS="]
        if shutil.which("ccache"):  # an unmutated source is then restored without being compiled again
            options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
            os.environ["CCACHE_BASEDIR"] = str(folder)
        if shutil.which("ninja") and not (self.build / "CMakeCache.txt").exists():
            options += ["-G", "Ninja"]
        if self.call(["cmake", "-S", folder, "-B", self.build, *options]) != 0:
            sys.exit(self.log.read_text())

    def copy_sources(self):
        """Copies only files that differ, so that only these are built again."""
        wanted = set()
        for path in (path for top in COPIED for path in [ROOT / top, *(ROOT / top).rglob("*")] if path.is_file()):
            wanted.add(path.relative_to(ROOT))
            copy = self.folder / path.relative_to(ROOT)
            if not copy.exists() or not filecmp.cmp(path, copy, shallow=False):
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, copy)
        for path in [path for top in COPIED for path in (self.folder / top).rglob("*") if path.is_file()]:
            if path.relative_to(self.folder) not in wanted:
                path.unlink()

    def call(self, command, **options):
        with self.log.open("w") as log:
            return subprocess.call(list(map(str, command)), stdout=log, stderr=subprocess.STDOUT, **options)

    def builds(self, target):
        return self.call(["cmake", "--build", self.build, "--target", target, "--parallel", str(os.cpu_count())]) == 0

    def passes(self, command):
        """Whether the tests pass. Tests still running after TEST_SECONDS fail."""

        def limit_memory():
            resource.setrlimit(resource.RLIMIT_AS, (TEST_BYTES, TEST_BYTES))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        command = ["timeout", "-k", "10", str(TEST_SECONDS), *command]
        self.status = self.call(command, preexec_fn=limit_memory)
        return self.status == 0

    def outcome(self, first):
        """Runs the tests that are most likely to fail first, and builds only what they need."""
        unit = [self.build / "tests" / "lamella_tests", "--abort"]
        ctest = ["ctest", "--test-dir", self.build, "--parallel", str(os.cpu_count()), "--stop-on-failure"]
        of_cli = ("lamella_cli", [*ctest, "--tests-regex", "^cli_"])
        of_engine = ("lamella_tests", unit)
        steps = [of_cli, of_engine] if first == "cli" else [("lamella_tests", [*unit, first]), of_engine, of_cli]
        for target, command in steps:
            if not self.builds(target):
                return "NO BUILD", next((line for line in self.log.read_text().splitlines() if "error" in line), "")
            if not self.passes(command):
                return "caught", self.failed_test()
        return "SURVIVED", ""

    def failed_test(self):
        """The first failed test. Catch2 writes its name below a line, ctest after a number."""
        text = self.log.read_text(errors="replace")
        name = re.search(r"^-{71,}\n(.+)", text, re.M) or re.search(r"^\s*\d+ - (cli_\w+)", text, re.M)
        return name[1] if name else f"exit status {self.status}"

    def try_mutant(self, mutant):
        needs = mutant.fields.get("needs")
        if needs and not re.search(rf"\b{needs}\b", pathlib.Path("/proc/cpuinfo").read_text()):
            return "skipped", f"needs {needs}"
        texts = mutant.mutated()
        try:
            for path, text in texts.items():
                (self.folder / path).write_text(text)
            return self.outcome(mutant.fields["tests"])
        finally:
            for path in texts:
                shutil.copyfile(ROOT / path, self.folder / path)


def run(mutants, folder):
    begin = time.monotonic()
    suite = Suite(folder)
    outcome, why = suite.outcome("[solids]")
    if outcome != "SURVIVED":
        sys.exit(f"{suite.log.read_text()}\nthe suite fails without any mutant: {why}")
    print(f"the suite passes, after {time.monotonic() - begin:.0f} s", flush=True)
    failures = 0
    for mutant in mutants:
        began = time.monotonic()
        outcome, why = suite.try_mutant(mutant)
        failures += outcome not in ("caught", "skipped")
        print(f"{mutant.name:28} {outcome:9} {time.monotonic() - began:4.0f} s  {why}", flush=True)
    print(f"{len(mutants)} mutants, {failures} not caught, {time.monotonic() - begin:.0f} s")
    return failures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="mutants to try (all)")
    parser.add_argument("-d", dest="folder", type=pathlib.Path, help="keep the copy and its build here for the next run")
    parser.add_argument("--table", type=pathlib.Path, default=HERE / "mutants.txt", help="the mutants (%(default)s)")
    parser.add_argument("--check", action="store_true", help="only check that each mutant fits the sources; nothing is built")
    arguments = parser.parse_args()
    try:
        mutants = read_table(arguments.table)
    except Unfit as problem:
        sys.exit(str(problem))
    if unknown := set(arguments.names) - {mutant.name for mutant in mutants}:
        sys.exit(f"no mutant of the name: {', '.join(sorted(unknown))}")
    mutants = [mutant for mutant in mutants if not arguments.names or mutant.name in arguments.names]
    if problems := list(filter(None, (mutant.problem() for mutant in mutants))):
        sys.exit("\n".join([*problems, f"{len(problems)} of {len(mutants)} mutants do not fit the sources"]))
    if arguments.check:
        print(f"{len(mutants)} mutants fit the sources")
        return 0
    if arguments.folder:
        arguments.folder.mkdir(parents=True, exist_ok=True)
        return run(mutants, arguments.folder.resolve()) != 0
    with tempfile.TemporaryDirectory() as folder:
        return run(mutants, pathlib.Path(folder)) != 0


if __name__ == "__main__":
    sys.exit(main())
