"""Somebody who may not read everything, also where tests run as root."""

import os
from contextlib import contextmanager

import pytest


@contextmanager
def nobody():
    """Be a user without rights."""
    me = os.geteuid()
    if me == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(me)


@pytest.fixture
def closed(tmp_path):
    """Give a folder that `nobody` may not enter, with the empty folder `inner` in it."""
    folder = tmp_path / "closed"
    (folder / "inner").mkdir(parents=True)
    folder.chmod(0)
    yield folder
    folder.chmod(0o700)
