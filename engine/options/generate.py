#!/usr/bin/env python3
"""Writes what follows from options.toml into the places where it is used.

    engine/options/generate.py           writes them
    engine/options/generate.py --check   compares; exit status 1 and a line a file where one is not what would be written
    engine/options/generate.py --python FILE    writes the module of Python's keywords, as the build does

What the option does is then written in engine/slicing; C, Python, the tool, archives and records pass it on.
"""

import pathlib
import re
import sys
import textwrap

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WIDTH = 125
GROUPS = {"planes": "PlaneOptions", "frame": "Frame", "region": "RegionRules", "": "SliceOptions"}
ENUMS = {"side": "PlaneSide", "content": "LayerContent"}
KINDS = {  # their types in C++, in C and in Python
    "mm": ("double", "double", "float"),
    "number": ("double", "double", "float"),
    "flag": ("bool", "int32_t", "bool"),
    "count": ("std::uint64_t", "uint64_t", "int"),
    "choice": ("", "int32_t", "str"),
    "optional_mm": ("std::optional<double>", "double", "float"),
    "heights": ("std::optional<std::vector<double>>", "const double*", "npt.ArrayLike"),
    "slabs": ("std::vector<Slab>", "const lamella_slab*", "npt.ArrayLike"),
    "transform": ("Transform", "double", "npt.ArrayLike"),
    "fill_from": ("std::vector<FillFrom>", "const lamella_fill_from*", "Sequence[Tuple[int, str]]"),
}
MORE_IN_C = {"heights_mm": [("size_t", "height_count"), ("int32_t", "at_heights")], "slabs": [("size_t", "slab_count")],
             "fill_from": [("size_t", "fill_from_count")]}  # fmt: skip


FIELDS = {"name", "group", "type", "default", "least", "above", "needs_region", "special", "special_text", "user_default",
          "since", "python", "tool", "why", "text", "more", "help"}  # fmt: skip


def check(options):
    """Refuses descriptions of which something would be lost in silence."""
    names = [fields.get("name", "") for fields in options]
    for fields, name in zip(options, names):
        problems = [f"no field '{field}'" for field in ("name", "type", "text") if field not in fields]
        problems += [f"no field is called '{field}'" for field in fields if field not in FIELDS]
        problems += [] if re.fullmatch("[a-z][a-z0-9_]*", name) else ["a name is lower_case"]
        problems += ["it is described twice"] if names.count(name) > 1 else []
        problems += [] if fields.get("group", "") in GROUPS else [f"no group is called '{fields['group']}'"]
        if problems:
            raise SystemExit(f"options.toml: {name or fields}: {problems[0]}")


class Option:
    def __init__(self, fields):
        self.fields = fields
        self.name, self.type, self.text = fields["name"], fields["type"], fields["text"]
        self.group = fields.get("group", "")
        self.words = list(self.type) if isinstance(self.type, (list, dict)) else []
        self.kind = "choice" if self.words else self.type
        self.path = f"{self.group}.{self.name}" if self.group else self.name
        self.python = fields.get("python", self.name.removesuffix("_mm"))
        tool = fields.get("tool", self.name.removesuffix("_mm").replace("_", "-"))
        self.flag = f"--{tool}" if tool else ""
        self.help = fields.get("help", self.text.removesuffix("."))
        if not (tool and self.python) and "why" not in fields:
            raise SystemExit(f"options.toml: {self.name} is not everywhere, and does not say why")

        self.enum = ENUMS.get(self.name, "".join(word.capitalize() for word in self.name.split("_")))
        self.cpp_type, c_type, self.python_type = KINDS[self.kind]
        self.c_fields = [(c_type, f"{self.name}[12]" if self.kind == "transform" else self.name), *MORE_IN_C.get(self.name, [])]
        self.exclusive = "above" in fields
        self.least = fields["above"] if self.exclusive else fields.get("least", "-no_limit")
        [(self.special, self.special_value)] = fields.get("special", {"": 0}).items()

    @property
    def cpp_default(self):
        if self.words:
            return f" = {self.enum}::{self.fields.get('default', self.words[0])}"
        if self.kind in ("mm", "number", "count"):
            return f" = {self.fields['default']}"
        return " = false" if self.kind == "flag" else "{}"


def comment(text, indent="    ", mark="/// "):
    return textwrap.wrap(text, WIDTH, initial_indent=indent + mark, subsequent_indent=indent + mark, break_long_words=False)


def cpp_enums(options):
    for o in options:
        if isinstance(o.type, dict):
            yield from comment(o.text, "")
            yield f"enum class {o.enum} : std::uint8_t {{"
            for word, words in o.type.items():
                yield from comment(words)
                yield f"    {word},"
            yield "};"
        elif o.words:
            yield f"enum class {o.enum} : std::uint8_t {{ {', '.join(o.words)} }};"


def cpp_struct(options, group):
    for o in options:
        if o.group == group:
            yield from comment(o.text + (" " + o.fields["more"] if "more" in o.fields else ""))
            yield f"    {o.cpp_type or o.enum} {o.name}{o.cpp_default};"


def c_enums(options):
    for o in options:
        prefix = re.sub(r"(?<!^)(?=[A-Z])", "_", o.enum).upper()
        if o.words:
            values = ", ".join(f"LAMELLA_{prefix}_{word.upper()} = {i}" for i, word in enumerate(o.words))
            yield from textwrap.wrap(f"enum {{ {values} }};", WIDTH, subsequent_indent="       ")


def c_struct(options):
    """By the version that added them, so that no field ever moves; within one the narrow ones last, in pairs."""
    for version in sorted({o.fields.get("since", "0.3") for o in options}):
        fields = [(kind, name, o) for o in options if o.fields.get("since", "0.3") == version for kind, name in o.c_fields]
        wide = [field for field in fields if field[0] != "int32_t"]
        narrow = [field for field in fields if field[0] == "int32_t"]
        for kind, name, o in wide + narrow:
            brief = re.split(r"\. ", o.text)[0].rstrip(".")
            room = WIDTH - len(f"    {kind} {name}; /* . */")
            brief = (brief if len(brief) <= room else brief.split("; ")[0]) + "."
            line = f"    {kind} {name};" + (f" /* {brief} */" if name in (o.name, f"{o.name}[12]") else "")
            if len(line) > WIDTH:
                yield f"    /* {brief} */"
                line = f"    {kind} {name};"
            yield line
        if len(narrow) % 2 == 1:
            yield f"    int32_t reserved_{version.replace('.', '_')};"


def quoted(text):
    return '"' + text.replace('"', '\\"') + '"'


def table(options):
    for o in options:
        limits = f"{o.least}, {str(o.exclusive).lower()}"
        special = f"{quoted(o.special)}, {o.special_value}"
        yield f"OPTION({o.kind}, {o.name}, {o.path}, {quoted(o.python)}, {quoted(o.flag)}, {limits}, {special},"
        yield f"       {str(o.fields.get('needs_region', False)).lower()}, {quoted(o.help)})"


def words(options):
    for o in options:
        if o.words:
            spelled = ", ".join(quoted(word.replace("_", "-")) for word in o.words)
            yield f"constexpr std::array<std::string_view, {len(o.words)}> words_of({o.enum} /*any*/) {{"
            yield f"    return {{{spelled}}};"
            yield "}"


def keyword_class(o):
    """The dictionary of keywords that holds it: calls take some of these together."""
    special = {"layer_height_mm": "UniformOptions", "first_height_mm": "UniformOptions", "datum": "UniformOptions",
               "heights_mm": "HeightOptions", "transform": "TransformOptions"}  # fmt: skip
    return special.get(o.name, f"{o.group.capitalize()}Options" if o.group in ("region", "frame") else "LayerOptions")


def keywords(options):
    """Python's keyword and the options that it sets: both ends of a range share one."""
    for keyword in dict.fromkeys(o.python for o in options if o.python):
        yield keyword, [o for o in options if o.python == keyword]


def python_type(o, count):
    if count > 1:
        return "Tuple[int, int]"
    return "Union[str, float]" if o.special else o.python_type


def python_default(o, count):
    default = o.fields.get("user_default", o.fields.get("default"))
    if o.words:
        return quoted((default or o.words[0]).replace("_", "-"))
    if o.kind in ("mm", "number"):
        return quoted(default) if isinstance(default, str) else str(default)
    return "False" if o.kind == "flag" else "None"


def python_text(o, texts):
    """With the meanings of words, as help() shows it."""
    meanings = {word.replace("_", "-"): meaning for word, meaning in o.type.items()} if isinstance(o.type, dict) else {}
    if o.special:
        meanings[o.special] = o.fields["special_text"] + "."
    lines = textwrap.wrap(" ".join([*texts, *(f"'{word}': {meaning}" for word, meaning in meanings.items())]), WIDTH - 13)
    return [" " * 8 + quoted(line + " ") for line in lines[:-1]] + [" " * 8 + quoted(lines[-1]) + ","]


def tuple_of(names):
    inside = ", ".join(map(quoted, names))
    return f"({inside},)" if len(names) == 1 else f"({inside})"


PYTHON_HEAD = [
    '"""The options of a slice, by keyword. Written by engine/options/generate.py when the package is built."""',
    "from __future__ import annotations",
    "from typing import Any, Dict, Optional, Sequence, Tuple, TypedDict, Union",
    "import numpy.typing as npt",
]


def python_options(options):
    """By keyword what _options.Option holds."""
    yield "OPTIONS: Dict[str, Dict[str, Any]] = {"
    for keyword, those in keywords(options):
        o = those[0]
        given = [f"kind={quoted(o.kind)}", f"fields={tuple_of([each.name for each in those])}"]
        given += [f"words={tuple_of([word.replace('_', '-') for word in o.words])}"] if o.words else []
        given += [f"special={{{quoted(o.special)}: {o.special_value}}}"] if o.special else []
        given += [f"least={o.least}"] if o.least != "-no_limit" else []
        given += ["exclusive=True"] if o.exclusive else []
        yield f"    {quoted(keyword)}: dict(text="
        yield from python_text(o, [each.text for each in those])
        yield f"        {', '.join(given)}, default={python_default(o, len(those))}),"
    yield "}"


def python_keywords(options):
    for name in dict.fromkeys(keyword_class(o) for o in options if o.python):
        yield f"class {name}(TypedDict, total=False):"
        for keyword, those in keywords(options):
            if keyword_class(those[0]) == name:
                yield f"    {keyword}: Optional[{python_type(those[0], len(those))}]"


def pieces(options):
    """What each file holds between its markers: (file, name of the markers, lines)."""
    header = "include/lamella/options.hpp"
    yield header, "choices", cpp_enums(options)
    for group, struct in GROUPS.items():
        yield header, struct, cpp_struct(options, group)
    yield "include/lamella/lamella.h", "choices", c_enums(options)
    yield "include/lamella/lamella.h", "options", c_struct(options)
    yield "engine/options/option_words.hpp", "words", words(options)
    yield "engine/options/options.inc", "options", table(options)


def replaced(text, path, name, lines):
    """`text` with what stands between the lines `begin NAME` and `end NAME` replaced."""
    begin = re.search(rf"^.*\bbegin {name}\b.*\n", text, re.MULTILINE)
    end = re.search(rf"^.*\bend {name}\b.*$", text, re.MULTILINE)
    if not begin or not end:
        raise SystemExit(f"{path}: no lines with 'begin {name}' and 'end {name}'")
    return text[: begin.end()] + "\n".join(lines) + "\n" + text[end.start() :]


def main():
    if sys.argv[1:] not in ([], ["--check"]) and sys.argv[1:-1] != ["--python"]:
        raise SystemExit(__doc__.strip())
    described = tomllib.loads((HERE / "options.toml").read_text())["option"]
    check(described)
    options = [Option(fields) for fields in described]
    if sys.argv[1:-1] == ["--python"]:
        lines = [*PYTHON_HEAD, *python_options(options), *python_keywords(options)]
        pathlib.Path(sys.argv[2]).write_text("\n".join(lines) + "\n")
        return 0
    texts = {}
    for path, name, lines in pieces(options):
        texts[path] = replaced(texts.get(path) or (ROOT / path).read_text(), path, name, lines)
    stale = [path for path, text in texts.items() if (ROOT / path).read_text() != text]
    for path in stale:
        if sys.argv[1:] == ["--check"]:
            print(f"{path}: not what engine/options/generate.py writes")
        else:
            (ROOT / path).write_text(texts[path])
            print(f"{path}: written")
    return 1 if stale and sys.argv[1:] == ["--check"] else 0


if __name__ == "__main__":
    sys.exit(main())
