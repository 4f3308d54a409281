#!/usr/bin/env python3
"""Compares the results of the host's test suites: suites.py OWN ADAPTER SUITE...

Both folders hold SUITE.xml, written by Catch2's XML reporter. Prints a table. The exit status is 1 if a case that passes
without the adapter fails with it, or is missing."""
import sys
import xml.etree.ElementTree as ElementTree


def read(path):
    """Whether each case passed, by name, and the number of assertions that held. A crash leaves the file cut off."""
    cases, assertions = {}, 0
    try:
        for _, element in ElementTree.iterparse(path, events=("end",)):
            if element.tag == "TestCase":
                cases[element.get("name")] = element.find("OverallResult").get("success") == "true"
            elif element.tag == "OverallResults":  # of a section, or, last of all, of the suite
                assertions = int(element.get("successes"))
    except ElementTree.ParseError as error:
        print(f"{path}: {error}", file=sys.stderr)
    return cases, assertions


def main():
    own_folder, adapter_folder, *suites = sys.argv[1:]
    broken = []
    print("| suite | cases | pass by themselves | pass with the adapter | assertions, by themselves | with the adapter |")
    print("|---|---|---|---|---|---|")
    for suite in suites:
        own, own_assertions = read(f"{own_folder}/{suite}.xml")
        adapter, adapter_assertions = read(f"{adapter_folder}/{suite}.xml")
        if not own:
            sys.exit(f"error: {own_folder}/{suite}.xml holds no case")
        broken += [f"{suite}: {name}" for name, passed in own.items() if passed and not adapter.get(name)]
        print(f"| {suite} | {len(own)} | {sum(own.values())} | {sum(adapter.values())} | {own_assertions} | {adapter_assertions} |")
    for case in broken:
        print(f"\nPasses only without the adapter: {case}")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
