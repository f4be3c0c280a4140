"""Which streams are wanted, by the configuration, by order, and by a recording."""

import numpy as np
import pytest

from listening_bench import MIXTURE, azimuth, source
from ross_payload.config import Config
from ross_payload.config.listening_options import selection_of, selection_text
from ross_payload.listening.order_book import RECORDED, OrderBook
from ross_payload.streams import LISTENER_TIMEOUT_S, MAX_STREAMS, Selection, StreamOrder, What

FILE = {"sink": "file", "what": "source 1", "options": {"path": "a.flac"}}
HERE = {"address": "127.0.0.1", "port": 5004}


def book(*streams, recording=None, **record):
    return OrderBook(Config.model_validate({"listening": {"streams": streams}, "recording": record}), recording)


def test_those_of_the_configuration_come_first_in_their_order():
    wanted = book(FILE, {"sink": "tcp", "on": False, "gain_db": 3, "muted": True, "options": {"port": 7}}).wanted
    assert [(each.number, each.sink, each.on, each.gain_db, each.muted, each.keeps) for each in wanted.values()] == [
        (0, "file", True, 0.0, False, True),
        (1, "tcp", False, 3.0, True, False),
    ]
    assert wanted[0].selection == source(1)
    assert wanted[1].selection == Selection()


def test_without_any_nothing_streams():
    assert book().wanted == {}
    assert book().changed(3) is None


def test_an_order_starts_a_stream_to_an_address_once():
    streams = book(FILE)
    order = StreamOrder(True, selection=source(2), gain_db=-6.0, **HERE, codec="L16")
    assert streams.place(order) == ""
    wanted = streams.changed(0)
    assert (wanted[1].sink, wanted[1].on, wanted[1].selection, wanted[1].gain_db) == ("rtp", True, source(2), -6.0)
    assert wanted[1].options == {"address": "127.0.0.1", "port": 5004, "codec": "L16"}
    assert streams.changed(0) is None
    assert streams.place(order) == ""  # networks double frames
    assert set(streams.changed(0)) == {0, 1}
    assert streams.place(StreamOrder(True, address="127.0.0.1", port=5006)) == ""
    assert set(streams.changed(0)) == {0, 1, 2}


def test_an_order_to_where_a_stream_of_the_configuration_goes_changes_that_one():
    """Two streams to one port would be a noise; a TCP stream at that port is something else."""
    streams = book({"sink": "tcp", "options": HERE}, {"sink": "rtp", "on": False, "options": HERE})
    assert streams.place(StreamOrder(True, selection=source(2), **HERE)) == ""
    wanted = streams.changed(0)
    assert [(each.sink, each.on, each.selection) for each in wanted.values()] == [
        ("tcp", True, Selection()),
        ("rtp", True, source(2)),
    ]


def test_an_order_changes_what_it_tells_and_nothing_else():
    streams = book(FILE)
    assert streams.place(StreamOrder(True, number=0, selection=azimuth(30), muted=True)) == ""
    first = streams.changed(0)[0]
    assert (first.selection, first.muted, first.gain_db, first.options) == (azimuth(30), True, 0.0, {"path": "a.flac"})
    streams.place(StreamOrder(True, number=0, gain_db=2.0))
    second = streams.changed(0)[0]
    assert (second.selection, second.muted, second.gain_db) == (azimuth(30), True, 2.0)


def test_one_or_all_of_them_can_be_stopped_and_started_again():
    streams = book(FILE, FILE | {"on": False})
    streams.place(StreamOrder(True, **HERE))
    streams.place(StreamOrder(False, number=0))
    assert [each.on for each in streams.changed(0).values()] == [False, False, True]
    streams.place(StreamOrder(False))
    assert not any(each.on for each in streams.changed(0).values())
    streams.place(StreamOrder(True, number=2))
    assert streams.changed(0)[2].on
    assert streams.wanted[2].options["port"] == 5004


def test_a_stream_is_stopped_by_where_it_goes():
    streams = book(FILE)
    streams.place(StreamOrder(True, **HERE))
    streams.place(StreamOrder(True, address="127.0.0.1", port=6000))
    assert streams.place(StreamOrder(False, **HERE)) == ""
    assert [each.on for each in streams.changed(0).values()] == [True, False, True]
    assert streams.place(StreamOrder(False, **HERE)) == "", "networks double frames"
    assert streams.place(StreamOrder(False, address="127.0.0.1", port=7000)) == "there is no stream to 127.0.0.1:7000"


def test_what_nobody_takes_ends_when_it_was_ordered_and_waits_when_it_was_configured():
    streams = book({"sink": "rtp", "options": HERE})
    streams.place(StreamOrder(True, address="127.0.0.1", port=6000))
    for number in (0, 1, 7):
        streams.give_up(number)
    configured, ordered = streams.changed(0).values()
    assert (configured.on, configured.ended) == (True, "")
    assert (ordered.on, ordered.ended) == (False, f"no listener for {LISTENER_TIMEOUT_S:g} s")
    streams.give_up(1)
    assert streams.changed(0) is None
    streams.place(StreamOrder(True, address="127.0.0.1", port=6000))
    assert (streams.changed(0)[1].on, streams.wanted[1].ended) == (True, "")
    streams.give_up(1)
    streams.place(StreamOrder(False))
    assert streams.changed(0)[1].ended == "", "somebody wants it off"


def test_the_number_of_an_ordered_stream_is_given_again_when_it_is_off_and_no_other_is_free():
    streams = book(FILE | {"on": False})
    for number in range(1, MAX_STREAMS):
        assert streams.place(StreamOrder(True, address="127.0.0.1", port=5000 + number)) == ""
    assert (
        streams.place(StreamOrder(True, address="127.0.0.1", port=6000)) == f"there are {MAX_STREAMS} streams already"
    )
    streams.place(StreamOrder(False, number=5))
    assert streams.place(StreamOrder(True, address="127.0.0.1", port=6000)) == ""
    assert streams.wanted[5].options["port"] == 6000
    assert streams.wanted[0].sink == "file"


@pytest.mark.parametrize(
    ("order", "why"),
    [
        (StreamOrder(True), "a new stream needs an address and a port"),
        (StreamOrder(True, number=7), "there is no stream 7"),
        (StreamOrder(False, number=7), "there is no stream 7"),
        (StreamOrder(True, number=0, gain_db=float("nan")), "gain: expected -60 to 60 dB, got nan"),
        (StreamOrder(True, number=0, selection=source(16)), "source: expected 0 to 15, got 16"),
        (StreamOrder(True, number=0, selection=source(None)), "source: expected 0 to 15, got None"),
        (StreamOrder(True, number=0, selection=azimuth(np.inf)), "azimuth: expected an angle, got inf"),
        (StreamOrder(True, number=0, port=9), "file: unknown key 'port'"),
        (StreamOrder(True, **HERE, codec="mp3"), "rtp: codec: "),
        (StreamOrder(True, address="239.1.2.3", port=5004), "rtp: "),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(order, why):
    streams = book(FILE)
    before = streams.wanted
    assert streams.place(order).startswith(why)
    assert streams.wanted == before
    assert streams.changed(0) is None


def test_a_recording_takes_the_target_and_every_source_that_is_asked_for():
    streams = book(FILE, recording=lambda: True, target=True, sources=True)
    assert set(streams.wanted) == {0, RECORDED}
    wanted = streams.changed(3)
    assert [(each.voice, each.selection) for each in wanted.values() if each.voice] == [
        ("target", Selection()),
        *((f"source-{number}", source(number)) for number in range(3)),
    ]
    assert streams.changed(3) is None
    assert len(streams.changed(4)) == 6
    streams.place(StreamOrder(False))
    assert [each.on for each in streams.changed(2).values()] == [False, *[True] * 5]
    assert streams.place(StreamOrder(False, number=RECORDED)).startswith("this stream is the recorder's")


def test_nothing_is_recorded_that_was_not_asked_for():
    assert set(book(FILE, recording=lambda: True).wanted) == {0}
    assert set(book(FILE, target=True, sources=True).wanted) == {0}  # there is no recorder


@pytest.mark.parametrize("text", ["mixture", "target", "source 0", "source 15", "azimuth -40.5", "azimuth 180"])
def test_what_a_stream_carries_is_read_and_written_alike(text):
    assert selection_text(selection_of(text)) == text


WRONG = ["", "voice", "source", "source -1", "source 16", "azimuth", "azimuth nan", "target 1"]


@pytest.mark.parametrize("text", WRONG)
def test_anything_else_is_refused(text):
    with pytest.raises(ValueError, match=r"expected mixture, target, source N \(0 to 15\) or azimuth DEGREES"):
        selection_of(text)
    assert MIXTURE.what is What.MIXTURE
