"""What scripts share that compare figures with bars and put their tables into bench/README.md."""
import re
import sys


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
