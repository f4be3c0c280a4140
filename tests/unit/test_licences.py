"""The page of licences names every package that is installed with RoSS."""

import re
from importlib.metadata import PackageNotFoundError, distribution

from packaging.requirements import Requirement

from manual import ROOT


def canonical(name):
    return re.sub(r"[-_.]+", "-", name.lower())


def needed(requirement, seen):
    """Add the names of what a requirement installs here, and of what that needs in turn."""
    asked = Requirement(requirement)
    key = (canonical(asked.name), frozenset(asked.extras))
    if key in seen:
        return seen
    try:
        lines = distribution(asked.name).requires or ()
    except PackageNotFoundError:  # of an extra that is not installed here
        return seen
    seen.add(key)
    for line in lines:
        marker = Requirement(line).marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in ("", *asked.extras)):
            needed(line, seen)
    return seen


def test_everything_that_is_installed_is_named():
    page = canonical((ROOT / "docs" / "reference" / "licences.md").read_text(encoding="utf-8"))
    packages = {name for name, _ in needed("ross-payload[all]", set())} - {"ross-payload"}
    assert {"numpy", "pycparser"} <= packages  # and what the extras bring, where those are installed
    assert [name for name in sorted(packages) if not re.search(rf"(?<![\w-]){name}(?![\w-])", page)] == []
