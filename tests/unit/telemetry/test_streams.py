"""Streams: what matters most goes first, the latest value only, and nothing queues without bound."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.mavlink.message_board import MESSAGE_IDS, Board, Rank
from ross_payload.mavlink.message_scheduler import RESERVE, SHORTEST, TEXTS, Stream
from ross_protocols.mavlink.codec import chunks
from ross_protocols.mavlink.values import Array, Health, Heartbeat, Named, Severity, Source, Status, Text, Value

PERIODS = {MESSAGE_IDS[Heartbeat]: 1.0, MESSAGE_IDS[Status]: 0.25, MESSAGE_IDS[Source]: 5.0, MESSAGE_IDS[Named]: 1.0}
SIZES = {Heartbeat: 20, Status: 80, Text: 66, Source: 70, Named: 30}
STATUS, SOURCE = MESSAGE_IDS[Status], MESSAGE_IDS[Source]
BEAT = Heartbeat(Health.ACTIVE, 3)


def status(number: int = 0) -> Status:
    return Status(number, 0.0, 3, earth=True)


def source(index: int, azimuth: float = 0.5) -> Source:
    return Source(0, 1, index, 3, azimuth, 0.02, 0.9, 0.5, earth=True, resolved=True)


def stream() -> Stream:
    return Stream(PERIODS, lambda value: SIZES[type(value)])


def full_board() -> Board:
    """Put on in the wrong order on purpose."""
    board = Board()
    board.put(Rank.SOURCE, [source(0), source(1)])
    board.put(Rank.STATUS, [status()])
    board.put(Rank.HEARTBEAT, [BEAT])
    return board


def told(stream: Stream, board: Board, seconds: float, rate: float = math.inf) -> list[tuple[float, Value]]:
    """Everything that a link of ``rate`` [bytes/s], saved up for half a second, is told."""
    heard, size = [], max(rate / 2, 293)
    room = size
    for step in range(round(seconds * 50)):
        room = min(room + rate / 50, size)
        for value in stream.due(board, step / 50, room):
            room -= SIZES[type(value)]
            heard.append((step / 50, value))
    return heard


def count(heard: list[tuple[float, Value]], kind: type) -> int:
    return sum(type(value) is kind for _, value in heard)


def test_what_matters_most_goes_first() -> None:
    link = stream()
    link.queue_texts([Text(Severity.INFO, "hello")])
    kinds = [type(value) for value in link.due(full_board(), 0.0, math.inf)]
    assert kinds == [Heartbeat, Status, Text, Source, Source]


def test_everything_keeps_its_rate() -> None:
    heard = told(stream(), full_board(), 20.0)
    assert (count(heard, Heartbeat), count(heard, Status), count(heard, Source)) == (20, 80, 8)


def test_news_are_told_at_once_and_only_what_is_new() -> None:
    link, board = stream(), full_board()
    link.due(board, 0.0, math.inf)
    board.announce(Rank.SOURCE, [source(0), source(1, azimuth=0.6)])
    assert link.due(board, 0.02, math.inf) == [source(1, azimuth=0.6)]


def test_what_is_put_again_waits_for_its_time_and_is_the_latest() -> None:
    link, board = stream(), full_board()
    link.due(board, 0.0, math.inf)
    for number in range(1, 10):
        board.put(Rank.STATUS, [status(number)])
        assert link.due(board, number * 0.02, math.inf) == []
    assert link.due(board, 0.25, math.inf) == [status(9)]


def test_a_short_budget_keeps_heartbeat_and_a_status_each_second_and_slows_the_rest() -> None:
    """Of 200 bytes/s these two take 100 at most; the rest carries one of 20 sources in 0.7 s at most."""
    board = full_board()
    board.put(Rank.SOURCE, [source(index) for index in range(20)])
    heard = told(stream(), board, 60.0, rate=200)
    assert count(heard, Heartbeat) == 60
    beats = [time for time, value in heard if type(value) is Status]
    assert max(after - before for before, after in pairwise(beats)) < 1.5
    assert count(heard, Source) > 80
    assert {value.source for _, value in heard if isinstance(value, Source)} == set(range(20)), "all of them in turn"


def test_heartbeats_that_somebody_asks_for_more_often_leave_the_rest_its_place() -> None:
    """Fifty a second would take 1000 of 200 bytes/s, and what answers need."""
    link, board = stream(), full_board()
    assert link.set_period(MESSAGE_IDS[Heartbeat], SHORTEST)
    heard = told(link, board, 60.0, rate=200)
    for kind in (Heartbeat, Status):
        times = [time for time, value in heard if type(value) is kind]
        assert max(after - before for before, after in pairwise(times)) < 1.5
    assert count(heard, Source) >= 20
    assert link.due(board, 60.0, RESERVE + 19) == []
    other = stream()
    assert other.set_period(MESSAGE_IDS[Heartbeat], SHORTEST)
    assert count(told(other, board, 10.0), Heartbeat) > 450, "with room for them they come as often as asked for"


def test_what_somebody_asks_for_more_often_leaves_the_rest_its_place() -> None:
    """Two sources fifty times a second would take 7000 of 400 bytes/s."""
    board = full_board()
    board.put(Rank.MIRROR, [Named(0.0, "ross_k", 1.0)])
    usual, link = told(stream(), board, 60.0, rate=400), stream()
    assert link.set_period(SOURCE, SHORTEST)
    heard = told(link, board, 60.0, rate=400)
    assert count(heard, Named) >= 0.9 * count(usual, Named) > 0
    assert count(heard, Source) >= count(usual, Source)


def test_what_comes_as_often_as_usual_goes_first_also_when_it_is_repeated() -> None:
    """Also when it is late; heartbeat, status and mirrors leave 30 of 250 bytes/s to what matters less."""
    board = Board()
    board.put(Rank.HEARTBEAT, [BEAT])
    board.put(Rank.STATUS, [status()])
    board.put(Rank.ALIGNMENT, [source(index) for index in range(4)])
    board.put(Rank.MIRROR, [Named(0.0, f"ross_{index}", 1.0) for index in range(4)])
    heard = told(stream(), board, 60.0, rate=250)
    assert count(heard, Named) >= 0.98 * 4 * 60
    assert 0 < count(heard, Source) < 4 * 60 / 5


def test_heartbeats_that_somebody_asks_for_more_often_share_what_a_component_may_take() -> None:
    link = stream()
    link.limit = 100.0
    assert link.period(MESSAGE_IDS[Heartbeat]) == 1.0
    assert link.set_period(MESSAGE_IDS[Heartbeat], SHORTEST)
    assert 0.7 < (link.period(MESSAGE_IDS[Heartbeat]) or 0.0) <= 1.0
    assert link.set_period(MESSAGE_IDS[Heartbeat], None)
    assert link.period(MESSAGE_IDS[Heartbeat]) == 1.0


@pytest.mark.parametrize("limit", [math.inf, 100.0], ids=["a payload", "a component with a share, as a gimbal"])
def test_what_waits_for_room_gets_it_from_all_but_the_heartbeat(limit) -> None:
    link, board = stream(), full_board()
    link.limit, link.claimed = limit, 280.0
    (beat,) = link.due(board, 0.0, 293.0)
    assert isinstance(beat, Heartbeat)
    assert link.due(board, 0.5, 293.0) == []
    link.claimed = 0.0
    assert len(link.due(board, 0.5, 293.0)) > 1


def test_with_room_for_it_status_comes_as_often_as_usual() -> None:
    """20 + 4 x 80 + 2 x 70 / 5 is 368 bytes/s."""
    heard = told(stream(), full_board(), 30.0, rate=400)
    assert count(heard, Status) > 0.95 * 120


def test_no_more_is_told_than_there_is_room_for() -> None:
    heard = told(stream(), full_board(), 30.0, rate=100)
    assert sum(SIZES[type(value)] for _, value in heard) <= 30 * 100 + 293


def test_room_is_left_for_an_answer() -> None:
    link = stream()
    assert [type(value) for value in link.due(full_board(), 0.0, RESERVE + 79)] == [Heartbeat]
    assert stream().due(full_board(), 0.0, 19) == []


def test_texts_that_find_no_room_do_not_pile_up() -> None:
    link = stream()
    for number in range(1000):
        link.queue_texts([Text(Severity.INFO, str(number))])
        assert link.due(Board(), number * 0.02, 0.0) == []
    waiting = link.due(Board(), 20.0, math.inf)
    assert [text.text for text in waiting] == [str(number) for number in range(1000 - TEXTS, 1000)]


def test_a_text_that_is_lost_is_lost_as_a_whole() -> None:
    link = stream()
    link.queue_texts([Text(Severity.INFO, "short")])
    for number in range(1, TEXTS):
        link.queue_texts(chunks(Severity.INFO, "x" * 60, number))
    waiting = link.due(Board(), 20.0, math.inf)
    assert [(text.id, text.chunk) for text in waiting] == [
        (number, chunk) for number in range(TEXTS // 2, TEXTS) for chunk in (0, 1)
    ]
    link.queue_texts(chunks(Severity.INFO, "x" * 60, 99))
    link.queue_texts([Text(Severity.INFO, "short")] * (TEXTS - 1))
    assert [text.text for text in link.due(Board(), 40.0, math.inf)] == ["short"] * (TEXTS - 1)


def test_a_value_that_is_taken_from_the_board_is_not_told() -> None:
    link, board = stream(), full_board()
    link.due(board, 0.0, math.inf)
    board.announce(Rank.SOURCE, [source(0)])
    assert [value.source for _, value in told(link, board, 6.0) if isinstance(value, Source)] == [0]


def test_a_link_that_comes_late_is_told_everything() -> None:
    board = full_board()
    told(stream(), board, 3.0)
    assert count(told(stream(), board, 0.1), Source) == 2


def test_a_rate_that_is_asked_for_holds_on_this_link_alone() -> None:
    one, other, board = stream(), stream(), full_board()
    assert one.set_period(STATUS, 0.1)
    assert (one.period(STATUS), other.period(STATUS)) == (0.1, 0.25)
    assert (count(told(one, board, 10.0), Status), count(told(other, board, 10.0), Status)) == (100, 40)
    assert one.set_period(STATUS, None)
    assert one.period(STATUS) == 0.25


def test_what_is_switched_off_is_not_told_even_when_it_is_new() -> None:
    link, board = stream(), full_board()
    assert link.set_period(SOURCE, math.inf)
    board.announce(Rank.SOURCE, [source(0, azimuth=1.0)])
    assert count(told(link, board, 20.0), Source) == 0
    assert link.request(board, SOURCE)
    assert count(told(link, board, 20.0), Source) == 1, "unless it is asked for"


def test_what_is_asked_for_once_comes_once_more() -> None:
    link, board = stream(), full_board()
    link.due(board, 0.0, math.inf)
    assert link.request(board, SOURCE)
    assert [type(value) for value in link.due(board, 0.02, math.inf)] == [Source, Source]
    assert link.due(board, 0.04, math.inf) == []


def test_a_message_that_is_none_of_ours_is_refused() -> None:
    link = stream()
    assert not link.set_period(30, 1.0)
    assert not link.set_period(STATUS, math.nan)
    assert link.period(30) is None
    assert not link.request(full_board(), MESSAGE_IDS[Array])


def test_nobody_can_ask_for_more_than_50_of_a_kind_in_a_second() -> None:
    link = stream()
    link.set_period(STATUS, 1e-6)
    assert link.period(STATUS) == SHORTEST
    assert count(told(link, full_board(), 10.0), Status) <= 10 / SHORTEST


@given(st.lists(st.tuples(st.floats(0, 400), st.booleans()), max_size=60))
def test_whatever_the_room_the_first_to_find_none_holds_back_the_rest(rooms: list[tuple[float, bool]]) -> None:
    """Or a stream of small things would starve a large one that matters more."""
    link, board = stream(), full_board()
    for step, (room, news) in enumerate(rooms):
        if news:
            board.announce(Rank.SOURCE, [source(0, azimuth=step / 100), source(1)])
        chosen = link.due(board, step * 0.1, room)
        assert sum(SIZES[type(value)] for value in chosen) <= room
        kinds = [type(value) for value in chosen]
        assert kinds == sorted(kinds, key=[Heartbeat, Status, Source].index) or kinds[-1] is Status
