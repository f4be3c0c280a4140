"""Orders as a page sends them: read, or refused in words."""

import math

import pytest

from ross_payload.ground.client.command_types import (
    Cancel,
    Explore,
    Home,
    Listen,
    Noise,
    Park,
    Rearm,
    Record,
    Stop,
    Turn,
)
from ross_payload.ground.client.order_json import order_of


@pytest.mark.parametrize(
    ("mapping", "order", "numbers"),
    [
        ({"kind": "explore"}, Explore(), ()),
        ({"kind": "listen"}, Listen(), (0,)),
        ({"kind": "listen", "source": 2}, Listen(source=2), (1, 2)),
        ({"kind": "listen", "azimuth": 90}, Listen(azimuth=90.0), (2, 0, 90)),
        ({"kind": "turn", "heading": -30.5}, Turn(-30.5), (-30.5,)),
        ({"kind": "stop"}, Stop(), ()),
        ({"kind": "cancel"}, Cancel(), ()),
        ({"kind": "park"}, Park(), ()),
        ({"kind": "home"}, Home(), ()),
        ({"kind": "rearm"}, Rearm(), ()),
        ({"kind": "record", "on": True}, Record(True), (1,)),
        ({"kind": "record", "on": False}, Record(False), (0,)),
        ({"kind": "noise", "seconds": 2}, Noise(2.0), (2,)),
    ],
)
def test_an_order_is_read_from_json(mapping, order, numbers):
    assert order_of(mapping) == order
    assert order.numbers == numbers


@pytest.mark.parametrize(
    "mapping",
    [
        {},
        {"kind": "arm"},
        {"kind": ["stop"]},
        {"kind": "turn"},
        {"kind": "turn", "heading": "40"},
        {"kind": "turn", "heading": True},
        {"kind": "turn", "heading": math.nan},
        {"kind": "turn", "heading": 361},
        {"kind": "turn", "heading": 10**400},
        {"kind": "listen", "source": 1.5},
        {"kind": "listen", "source": -1},
        {"kind": "listen", "source": 256},
        {"kind": "listen", "source": 1, "azimuth": 3},
        {"kind": "record"},
        {"kind": "record", "on": 1},
        {"kind": "noise", "seconds": 61},
        {"kind": "noise", "seconds": -1},
    ],
    ids=repr,
)
def test_what_is_no_order_says_what_was_expected_and_got(mapping):
    with pytest.raises(ValueError, match=r"expected .*, got "):
        order_of(mapping)
