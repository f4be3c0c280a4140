"""The allocatee's rules of DroneCAN, one by one: when it asks, when it goes on, when it gives way."""

import numpy as np
import pytest

from dronecan_wire import UNIQUE
from ross_payload.dronecan.allocatee import Allocatee
from ross_protocols.dronecan.messages import Allocation

ALLOCATOR, ASKER = 10, 0
SEEDS = range(20)


@pytest.fixture(params=SEEDS)
def allocatee(request):
    return Allocatee(UNIQUE, 33, np.random.default_rng(request.param), 0.0)


def said(allocatee, begin, end):
    """What it says between two times, and when."""
    times = np.arange(begin, end, 0.001)
    return [(time, told) for time in times if (told := allocatee.due(time)) is not None]


def test_it_asks_every_600_to_1000_ms_with_the_first_six_bytes_and_its_wish(allocatee):
    times, told = zip(*said(allocatee, 0.0, 10.0), strict=True)
    assert set(told) == {Allocation(33, UNIQUE[:6], first=True)}
    assert np.all((np.diff([0.0, *times]) > 0.598) & (np.diff([0.0, *times]) < 1.002))


def test_it_goes_on_within_400_ms_where_the_allocator_is(allocatee):
    for known, part in ((6, UNIQUE[6:12]), (12, UNIQUE[12:])):
        assert allocatee.on_allocation(ALLOCATOR, Allocation(0, UNIQUE[:known]), 1.0) is None
        assert [told for _, told in said(allocatee, 1.0, 1.401)] == [Allocation(33, part)]


def test_whoever_is_heard_meanwhile_goes_first(allocatee):
    allocatee.on_allocation(ALLOCATOR, Allocation(0, UNIQUE[:6]), 1.0)
    allocatee.on_allocation(ALLOCATOR, Allocation(0, b"abcdef"), 1.0)
    assert said(allocatee, 1.0, 1.599) == []


def test_any_allocation_puts_its_own_request_off(allocatee):
    for time in np.arange(0.0, 5.0, 0.5):
        allocatee.on_allocation(ASKER, Allocation(0, b"abcdef", first=True), time)
        assert said(allocatee, time, time + 0.5) == []


def test_only_a_node_with_an_id_is_believed(allocatee):
    assert allocatee.on_allocation(ASKER, Allocation(77, UNIQUE), 1.0) is None
    allocatee.on_allocation(ASKER, Allocation(0, UNIQUE[:6]), 1.0)
    assert said(allocatee, 1.0, 1.599) == []


def test_an_id_comes_with_the_whole_unique_id_and_is_not_zero(allocatee):
    assert allocatee.on_allocation(ALLOCATOR, Allocation(77, UNIQUE[:12]), 1.0) is None
    assert allocatee.on_allocation(ALLOCATOR, Allocation(77, UNIQUE[::-1]), 1.0) is None
    assert allocatee.on_allocation(ALLOCATOR, Allocation(0, UNIQUE), 1.0) is None
    assert allocatee.on_allocation(ALLOCATOR, Allocation(77, UNIQUE), 1.0) == 77
