"""What scripts share that compare figures with bars and put their tables into bench/README.md."""
import argparse
import json
import pathlib
import re
import subprocess
import sys


def table_parser(doc, *words):
    """A parser of these words and --readme, whose help is the script's own."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for word in words:
        parser.add_argument(word, type=pathlib.Path if word == "build" else str)
    parser.add_argument("--readme", type=pathlib.Path)
    return parser


def add_meshes(parser, least="+"):
    """NAME=MESH words, as pairs."""
    parser.add_argument("meshes", nargs=least, metavar="NAME=MESH", type=lambda word: tuple(word.split("=", 1)))


def output_of(*command):
    """The JSON that a program prints."""
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def show(readme, name, lines):
    """Prints the lines; with `readme` they also replace the table of that name there."""
    table = "\n".join(lines) + "\n"
    print(table, end="")
    if readme:
        replace_table(readme, name, table)


def mark(text, value, bar):
    """The text, with whether the bar is met; and that."""
    return (text, True) if bar is None else (f"{text} ({'met' if value <= bar else 'not met'})", value <= bar)


def mark_least(text, value, bar):
    """The same for a bar that the value must reach."""
    met = bar is None or value >= bar
    return (text if bar is None else f"{text} ({'met' if met else 'not met'})"), met


def replace_table(readme, name, table):
    """Puts `table` between the markers `<!-- name: begin -->` and `<!-- name: end -->` of the file `readme`."""
    text = readme.read_text()
    parts = re.split(rf"(<!-- {name}: (?:begin|end) -->\n)", text)
    if len(parts) != 5:
        sys.exit(f"{readme}: has not one pair of markers '<!-- {name}: begin -->' and '... end'")
    parts[2] = "\n" + table + "\n"
    readme.write_text("".join(parts))
