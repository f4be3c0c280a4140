"""Calls of plug-ins that do not return are named, once and then every minute."""

import threading

import pytest

from ross_payload.plugin_calls import LATE_LOOKS, REPEAT_LOOKS, LateCalls, called, telling_late_calls


@pytest.fixture
def hanging():
    """A call that lasts until it is let go."""
    begun, over = threading.Event(), threading.Event()

    def hang():
        begun.set()
        over.wait()

    thread = threading.Thread(target=called, args=("separator 'theirs'", "batch", hang))
    thread.start()
    begun.wait()
    yield lambda: (over.set(), thread.join())
    over.set()
    thread.join()


def test_a_call_that_does_not_return_is_told_now_and_then_until_it_does(hanging, caplog):
    late = LateCalls()
    for _ in range(LATE_LOOKS - 1):
        late.look()
    assert (late.in_words(), caplog.messages) == ((), [])
    for _ in range(REPEAT_LOOKS):
        late.look()
    assert late.in_words() == ("separator 'theirs': batch",)
    assert caplog.messages == ["separator 'theirs': batch has not returned for 15 s: what needs it stands still"]
    late.look()
    assert len(caplog.messages) == 2
    hanging()
    late.look()
    assert late.in_words() == ()


def test_many_short_calls_are_not_one_long_one(caplog):
    late = LateCalls()
    for _ in range(3 * LATE_LOOKS):
        called("separator 'theirs'", "step", late.look)
    assert (late.in_words(), caplog.messages) == ((), [])


def test_a_call_within_another_is_the_one_that_is_told():
    late = LateCalls()

    def outer():
        called("sink 'theirs'", "write", lambda: [late.look() for _ in range(LATE_LOOKS)])
        assert late.in_words() == ("sink 'theirs': write",)
        late.look()
        assert late.in_words() == ()

    called("separator 'theirs'", "batch", outer)


def test_without_a_thread_left_nothing_is_told_and_all_goes_on(monkeypatch, caplog):
    def refuse(thread):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    with telling_late_calls() as late:
        assert late.in_words() == ()
    assert "plug-ins that hang are not told: can't start new thread" in caplog.text
