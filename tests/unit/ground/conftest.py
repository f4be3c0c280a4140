"""What tests of the ground side share."""

import pytest

from fleet_ear import Ground
from ross_payload.ground.flights.reading import open_flight
from scripted_payload import Script


@pytest.fixture
def script():
    return Script()


@pytest.fixture
def ground():
    return Ground()


@pytest.fixture
def opened(tmp_path):
    """Open a log of these bytes."""

    def call(data):
        path = tmp_path / "flight.tlog"
        path.write_bytes(data)
        return open_flight(path)

    return call
