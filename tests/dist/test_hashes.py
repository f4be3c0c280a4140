"""The versions that a payload runs on, with their hashes: for ``pip install --require-hashes``."""

import re
from importlib.metadata import requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
EXTRAS = ("", "capture", "serial", "can", "gpio", "ground", "stream", "voice")  # what a payload is installed with
PIN = re.compile(
    r"(?P<name>[\w.-]+)==(?P<version>[^\s;]+)(?P<marker> ;[^\\]*)?(?P<hashes>(?: \\\n    --hash=sha256:[0-9a-f]{64})+)"
)


@pytest.fixture(scope="module")
def text():
    return (ROOT / "requirements-hashed.txt").read_text()


@pytest.fixture(scope="module")
def pins(text):
    """Version by name."""
    return {canonicalize_name(found["name"]): found["version"] for found in PIN.finditer(text)}


def needed(name, extras, known):
    """Add to ``known`` what a package needs here with these extras, and what that needs."""
    for line in requires(name) or ():
        requirement = Requirement(line)
        marker, other = requirement.marker, canonicalize_name(requirement.name)
        if (marker is None or any(marker.evaluate({"extra": extra}) for extra in extras)) and other not in known:
            known.add(other)
            needed(other, ("", *requirement.extras), known)
    return known


def test_every_line_is_a_version_with_its_hashes(text):
    assert PIN.sub("", text).strip() == ""


def test_the_versions_are_those_that_the_tests_ran_with(pins):
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    tested = {canonicalize_name(name): version for name, _, version in (line.partition("==") for line in lines)}
    assert pins == {name: tested.get(name) for name in pins}


def test_everything_that_a_payload_needs_is_there(pins):
    assert needed("ross-payload", EXTRAS, set()) <= set(pins)


def test_no_registry_is_named(text):
    assert "://" not in text
    assert "--index" not in text
