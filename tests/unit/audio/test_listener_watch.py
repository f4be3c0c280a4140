"""Who takes a stream, and for how long nobody has: by reports, refusals and their absence."""

import numpy as np

from ross_payload.audio.sinks.listener_watch import LISTENS_S, PAUSE_S, REFUSED_S, ListenerWatch


class Stream:
    """Sends a packet every 20 ms of its own time; ``say`` is called after each one."""

    def __init__(self):
        self.watch, self.now = ListenerWatch(), 0.0

    def go(self, seconds, *say, every=1.0):
        due = self.now
        for now in self.now + np.arange(0.02, seconds + 0.01, 0.02):
            self.now = float(now)
            self.watch.sent(self.now)
            if self.now >= due:
                due += every
                for each in say:
                    each(self.now)
        return self

    @property
    def unheard(self):
        return round(self.watch.unheard(self.now), 1)


def test_a_player_that_says_nothing_and_is_not_refused_may_listen():
    stream = Stream().go(100)
    assert stream.watch.may_listen(stream.now)
    assert stream.unheard == 0


def test_a_port_that_is_closed_is_told_by_refusals_which_are_fewer_than_packets():
    stream = Stream().go(10)
    stream.go(25, stream.watch.refused)
    assert not stream.watch.may_listen(stream.now)
    assert stream.unheard == 25
    stream.go(REFUSED_S + 1)
    assert stream.watch.may_listen(stream.now), "somebody has opened the port"
    assert stream.unheard == 0
    stream.go(2, stream.watch.refused)
    assert stream.unheard == 2


def test_reports_that_stop_tell_that_the_listener_is_gone():
    stream = Stream()
    stream.go(10, stream.watch.reported)
    assert stream.unheard == 0
    stream.go(LISTENS_S - 2)
    assert stream.unheard == 0, "reports may be lost"
    stream.go(20)
    assert stream.unheard == 20 + LISTENS_S - 2
    stream.go(1, stream.watch.reported)
    assert stream.unheard == 0


def test_a_killed_listener_counts_from_its_last_report():
    stream = Stream()
    stream.go(10, stream.watch.reported)
    stream.go(20, stream.watch.refused)
    assert stream.unheard == 20
    assert Stream().unheard == 0


def test_a_listener_behind_a_network_that_refuses_now_and_then_is_one():
    stream = Stream()
    stream.go(60, stream.watch.reported, stream.watch.refused)
    assert stream.watch.may_listen(stream.now)
    assert stream.unheard == 0


def test_a_goodbye_is_the_last_sign_of_life():
    stream = Stream()
    stream.go(5, stream.watch.reported)
    stream.watch.left(stream.now)
    assert not stream.watch.reports(stream.now)
    assert stream.go(12).unheard == 12


def test_while_nothing_is_sent_nobody_can_be_missed():
    stream = Stream()
    stream.go(5, stream.watch.reported)
    stream.now += 100.0  # the microphones were unplugged
    assert stream.unheard == 0
    stream.go(PAUSE_S)
    assert stream.unheard == PAUSE_S, "packets go again, and nobody reports yet"
    stream.go(1, stream.watch.reported)
    assert stream.unheard == 0
