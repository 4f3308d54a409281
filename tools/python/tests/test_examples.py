"""The examples in docstrings are true."""

import doctest
import importlib
import pkgutil

import pytest

import lamella

MODULES = ["lamella", *(f"lamella.{module.name}" for module in pkgutil.iter_modules(lamella.__path__) if module.name != "_native")]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name, doctest_namespace):
    result = doctest.testmod(importlib.import_module(name), extraglobs=doctest_namespace)
    assert result.failed == 0


def test_there_are_examples(doctest_namespace):
    finder = doctest.DocTestFinder()
    examples = [test for name in MODULES for test in finder.find(importlib.import_module(name)) if test.examples]
    assert len(examples) >= 12
