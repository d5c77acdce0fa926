"""docs/python.md shows what happens."""

import doctest
from pathlib import Path


def test_the_page(models, monkeypatch):
    monkeypatch.chdir(models)
    page = Path(__file__).parents[2] / "docs" / "python.md"
    found = doctest.testfile(str(page), module_relative=False)
    assert found.attempted > 20 and found.failed == 0
