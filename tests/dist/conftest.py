"""What every test in this folder can ask for."""

import pytest

import bare_debian as debian
from own_actuator import folder  # noqa: F401


@pytest.fixture(scope="session")
def bare_debian(tmp_path_factory):
    """An archive of a bare Debian."""
    return debian.bare(tmp_path_factory.mktemp("bare"))


@pytest.fixture(scope="session")
def wheels(tmp_path_factory):
    """A folder of wheels: what a payload runs on, and what builds its own."""
    debian.python_of_debian()
    return debian.wheels_of_a_payload(tmp_path_factory.mktemp("fetched"))
