"""Enrolment by pointing: turn, separate, learn the voice; nobody is enrolled who has not agreed, and no mixture."""

import errno
import json
import os
import stat
import threading
import time
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from ross_payload.errors import AudioError, ConfigError
from ross_payload.events import Answer, Answered, Enrolled, Separated, State, StateChanged, TurnStarted
from ross_payload.interfaces import Groups, Quality
from ross_payload.mission import enrol_talker
from ross_payload.mission.live_session import Kit
from ross_payload.orders import Enrol, Explore, Home, ListenTo, Park, Seek, TurnTo
from ross_payload.service.voice_keeper import VoiceKeeper
from ross_payload.sessions.event_json import plain
from ross_payload.voiceprint import EmbeddingPrint, VoiceStore, built_in_model
from ross_payload.voiceprint.dominance import POOR
from session_bench import HOP, RATE, Bench, Likes, make, nobody


def model_of(seconds=5.0):
    model = built_in_model()
    return EmbeddingPrint(np.eye(model.size)[0], seconds, model)


@pytest.fixture
def heard(monkeypatch):
    """The voices that prints are made of; each becomes the print of who spoke as loud."""
    voices = []

    def enrol(voice, rate, model, *, separated):
        assert separated
        voices.append((voice, rate))
        likes = Likes(round(float(np.abs(voice).max() / 0.1)) - 1)
        likes.seconds = 5.0
        return likes

    monkeypatch.setattr(enrol_talker, "enrol", enrol)
    return voices


@pytest.fixture
def explored():
    bench = Bench(make=nobody)
    bench.hop(Explore(number=1))
    bench.over(1)
    return bench


def test_a_source_is_turned_to_separated_and_enrolled(explored, heard):
    explored.hop(Enrol(source=2, seconds=0.5, name="ann", consent=True, number=2))
    answer = explored.over(2)
    said = next(event for event in explored.events if isinstance(event, Enrolled))
    assert (said.name, said.source, said.seconds) == ("ann", 2, 5.0)
    assert any(isinstance(event, TurnStarted) for event in explored.events)
    ((voice, rate),) = heard
    assert len(voice) == pytest.approx(0.5 * rate, abs=100)
    assert np.abs(voice).max() == pytest.approx(0.3, abs=0.01)  # the group of source 2 is the mixture times 3
    assert answer.answer is Answer.DONE
    assert "enrolled ann" in explored.reason(2)


def test_of_a_poor_voice_the_parts_are_enrolled_in_which_it_dominates(explored, heard, monkeypatch):
    separate = enrol_talker.separate

    def poor(*asked):
        groups, voices = separate(*asked)
        return replace(groups, quality=(Quality(POOR, 5.0),) * len(groups.members)), voices

    monkeypatch.setattr(enrol_talker, "separate", poor)
    explored.hop(Enrol(source=0, seconds=0.5, name="ann", consent=True, number=2))
    assert explored.over(2).answer is Answer.DONE
    ((voice, _),) = heard
    assert np.abs(voice).max() == pytest.approx(0.1 / 14, rel=0.02)  # its share beside the mixture times 2 and 3


def test_who_was_enrolled_is_the_target_from_then_on(explored, heard):
    explored.hop(Seek(number=2))
    assert explored.over(2).answer is Answer.REFUSED
    explored.hop(Enrol(source=2, seconds=0.5, name="ann", consent=True, number=3))
    explored.over(3)
    assert explored.session.target == "ann"
    explored.hop(Seek(number=4))
    run = explored.hops_until(Separated)
    assert run.groups[run.target].members == (2,)


def test_without_consent_nothing_turns(explored, heard):
    before = list(explored.goals)
    explored.hop(Enrol(source=2, name="ann", number=2))
    assert explored.over(2).answer is Answer.REFUSED
    assert "agreed" in explored.reason(2)
    assert explored.goals == before
    assert not heard


@pytest.mark.parametrize("source", [-1, 3])
def test_a_source_that_is_not_there_is_refused(explored, source):
    explored.hop(Enrol(source=source, name="ann", consent=True, number=2))
    assert explored.over(2).answer is Answer.REFUSED
    assert explored.reason(2) == "there is no such source"


def test_an_azimuth_means_whoever_is_there(explored, heard):
    explored.hop(Enrol(azimuth=float(np.deg2rad(72)), seconds=0.5, name="ann", consent=True, number=2))
    assert explored.hops_until(Enrolled).source == 1


def test_who_pauses_is_listened_to_for_longer(explored, heard, monkeypatch):
    enough = enrol_talker.enrol

    def patient(voice, rate, model, **how):
        if len(voice) < rate:
            raise AudioError("enrolment: expected at least 1.5 s of voiced speech, got 0.4 s")
        return enough(voice, rate, model, **how)

    monkeypatch.setattr(enrol_talker, "enrol", patient)
    explored.hop(Enrol(source=0, seconds=0.5, name="ann", consent=True, number=2))
    explored.over(2)
    ((voice, rate),) = heard
    assert len(voice) == pytest.approx(rate, abs=100)  # two periods


def test_long_listening_is_separated_in_pieces_and_a_print_is_made_of_the_loudest_of_it(explored, heard, monkeypatch):
    """At once 300 s took 69 s to separate and 3.8 GB, and the print 12 s."""
    pieces, separate = [], enrol_talker.separate

    def counted(context, estimate, listening):
        pieces.append(listening.samples.shape[1])
        groups, voices = separate(context, estimate, listening)
        return groups, voices * (2.0 if len(pieces) == 3 else 1.0)

    monkeypatch.setattr(enrol_talker, "separate", counted)
    monkeypatch.setattr(enrol_talker, "PIECE", 0.5)
    monkeypatch.setattr(enrol_talker, "MOST", 0.3)
    explored.hop(Enrol(source=0, seconds=2.2, name="ann", consent=True, number=2))
    assert explored.over(2).answer is Answer.DONE
    assert pieces == pytest.approx([0.44 * RATE] * 5, abs=HOP)
    ((voice, rate),) = heard
    assert len(voice) == 0.3 * rate
    assert np.abs(voice).max() == pytest.approx(0.2, abs=0.01)  # of the third piece


def test_who_never_speaks_is_not_enrolled(explored, monkeypatch):
    def silent(voice, rate, model, **how):
        raise AudioError("enrolment: expected speech, got silence")

    monkeypatch.setattr(enrol_talker, "enrol", silent)
    explored.hop(Enrol(source=0, seconds=0.2, name="ann", consent=True, number=2))
    assert explored.over(2).answer is Answer.FAILED
    assert explored.reason(2) == "ann: enrolment: expected speech, got silence"
    assert explored.session.target == ""


def test_sources_that_pose_as_one_are_not_enrolled(heard):
    class Together:
        name = "together"

        def batch(self, spectrogram, scene):
            return Groups(spectrogram[:1], ((0, 1, 2),), self.name)

    def together(config):
        kit = make(config)
        tools = kit.tools
        return Kit(kit.settings, type(tools)(tools.explorer, tools.explorer_stft, Together(), tools.stft, None))

    bench = Bench(make=together)
    bench.hop(Explore(number=1))
    bench.over(1)
    bench.hop(Enrol(source=0, seconds=0.2, name="ann", consent=True, number=2))
    assert bench.over(2).answer is Answer.FAILED
    assert "cannot be told from the others" in bench.reason(2)
    assert not heard


class Removed:
    """A model of voices in a folder that somebody else changes."""

    def __init__(self):
        self.there = True

    def __call__(self):
        if not self.there:
            raise ConfigError("voice model 'small' is unknown")
        return built_in_model()


@pytest.fixture
def model():
    return Removed()


@pytest.fixture
def flown(model):
    def kit_of(config):
        kit = make(config)
        return Kit(kit.settings, replace(kit.tools, voice_model=model))

    bench = Bench(make=kit_of)
    bench.hop(Explore(number=1))
    bench.over(1)
    return bench


def test_without_the_model_of_voices_nobody_is_enrolled_and_what_goes_on_is_not_ended(flown, model, heard):
    flown.hop(ListenTo(1, number=2))
    flown.hops_until(lambda event: isinstance(event, StateChanged) and event.state is State.RUN)
    model.there = False
    flown.hop(Enrol(source=2, seconds=0.5, name="ann", consent=True, number=3))
    assert flown.over(3).answer is Answer.REFUSED
    assert flown.reason(3) == "voice model 'small' is unknown"
    assert flown.over(2).answer is Answer.DONE
    assert not heard


@pytest.mark.parametrize("order", [Park(number=2), TurnTo(0.1, number=2), Home(number=2), Seek(number=2)])
def test_without_the_model_of_voices_all_else_goes_on(flown, model, order):
    """Whom the payload seeks is told by a print that has its model with it."""
    model.there = False
    flown.hop(order)
    assert flown.over(2).answer is Answer.DONE


def test_a_model_of_voices_that_is_removed_at_the_last_moment_ends_the_enrolment_alone(flown, model, heard):
    flown.hop(Enrol(source=2, seconds=0.5, name="ann", consent=True, number=2))
    flown.hops_until(lambda event: isinstance(event, Answered) and event.answer is Answer.ACCEPTED)
    model.there = False
    assert flown.over(2).answer is Answer.FAILED
    assert flown.reason(2) == "voice model 'small' is unknown"
    assert not heard


def test_another_task_has_to_wait(explored, heard):
    explored.hop(Enrol(source=2, seconds=0.5, name="ann", consent=True, number=2))
    explored.hops_until(TurnStarted)
    for _ in range(20):
        explored.hop()
    explored.hop(ListenTo(0, number=3))
    assert explored.over(3).answer is Answer.REFUSED
    assert explored.over(2).answer is Answer.DONE


def test_the_voice_is_in_no_log():
    told = plain(Enrolled(1.0, "ann", 2, 0.1, 5.0, model_of()))
    assert told == {"event": "Enrolled", "time": 1.0, "name": "ann", "source": 2, "azimuth": 0.1, "seconds": 5.0}


@pytest.fixture
def store(tmp_path):
    return VoiceStore(tmp_path / "voices")


def test_the_print_is_kept_with_the_consent_for_its_owner_alone(store):
    with VoiceKeeper(store, lambda: datetime(2026, 11, 21, 14, 54, 21, tzinfo=UTC)) as keeper:
        keeper.on_event(Enrolled(1.0, "ann", 2, 0.1, 5.0, model_of()), None)
    path = store.folder / "ann.json"
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700
    assert json.loads(path.read_text())["consent"] == "told by the order to enrol, 2026-11-21T14:54:21Z"
    assert store.load("ann").consent == "told by the order to enrol, 2026-11-21T14:54:21Z"


def test_no_date_is_made_up_for_a_consent(store):
    with VoiceKeeper(store) as keeper:
        keeper.on_event(Enrolled(1.0, "ann", 2, 0.1, 5.0, model_of()), None)
    assert store.load("ann").consent == "told by the order to enrol, at a time that no clock told"


def test_a_print_that_cannot_be_kept_is_told_on_the_pump(store):
    store.folder.write_text("in the way")
    said = []
    with VoiceKeeper(store) as keeper:
        keeper.on_event(Enrolled(1.0, "ann", 2, 0.1, 5.0, model_of()), None)
    keeper.poll(said.append)
    assert len(said) == 1
    assert "voice print of ann not kept" in said[0]


def test_a_print_for_which_no_thread_is_left_is_told_and_written_with_the_next(store, monkeypatch):
    """It ended the mission."""

    def refused(thread):
        raise RuntimeError("can't start new thread")

    said = []
    with VoiceKeeper(store) as keeper:
        with monkeypatch.context() as patch:
            patch.setattr(threading.Thread, "start", refused)
            keeper.on_event(Enrolled(1.0, "ann", 2, 0.1, 5.0, model_of()), None)
        keeper.poll(said.append)
        assert said == ["voice print of ann not kept: can't start new thread"]
        keeper.on_event(Enrolled(1.0, "bob", 2, 0.1, 5.0, model_of()), None)
    assert store.names() == ("ann", "bob")


def test_who_has_no_name_gets_a_number(store):
    store.save("talker-1", model_of())
    with VoiceKeeper(store) as keeper:
        asked = [keeper.named(Enrol(source=0, consent=True)) for _ in range(2)]
        assert [order.name for order in asked] == ["talker-2", "talker-3"]
        assert keeper.named(Enrol(source=0, name="ann", consent=True)).name == "ann"


@pytest.mark.parametrize("answer", [Answer.REFUSED, Answer.FAILED, Answer.CANCELLED])
def test_the_number_of_who_was_not_enrolled_is_free_again(store, answer):
    with VoiceKeeper(store) as keeper:
        assert keeper.named(Enrol(source=0, consent=True, number=7)).name == "talker-1"
        keeper.on_event(Answered(0.5, 7, Answer.ACCEPTED), None)
        keeper.on_event(Answered(1.0, 6, answer, "another order"), None)
        assert keeper.named(Enrol(source=0, consent=True, number=8)).name == "talker-2"
        keeper.on_event(Answered(1.0, 7, answer, "too little speech"), None)
        assert keeper.named(Enrol(source=0, consent=True, number=9)).name == "talker-1"
        keeper.on_event(Enrolled(2.0, "talker-1", 0, 0.0, 5.0, model_of()), None)
        keeper.on_event(Answered(2.0, 9, Answer.DONE), None)
        assert keeper.named(Enrol(source=0, consent=True, number=10)).name == "talker-3"


def test_two_payloads_of_one_user_number_voices_one_after_the_other(store):
    first, second = (replace(model_of(), embedding=row) for row in np.eye(built_in_model().size)[:2])
    said = []
    with VoiceKeeper(store) as two:
        with VoiceKeeper(store) as one:
            names = [keeper.named(Enrol(source=0, consent=True)).name for keeper in (one, two)]
            assert names == ["talker-1", "talker-1"]
            one.on_event(Enrolled(1.0, "talker-1", 0, 0.0, 5.0, first), None)
        two.on_event(Enrolled(2.0, "talker-1", 0, 0.0, 5.0, second), None)
    two.poll(said.append)
    assert store.names() == ("talker-1", "talker-2")
    np.testing.assert_array_equal(store.load("talker-1").embedding, first.embedding)
    np.testing.assert_array_equal(store.load("talker-2").embedding, second.embedding)
    assert said == ["voice print of talker-1 kept as talker-2: another talker-1 was enrolled meanwhile"]


def test_a_number_that_was_enrolled_meanwhile_is_not_given_again(store):
    with VoiceKeeper(store) as keeper:
        store.save("talker-1", model_of())
        assert keeper.named(Enrol(source=0, consent=True)).name == "talker-2"


def test_a_disk_that_fails_gets_one_print_and_not_one_after_the_other(store, monkeypatch):
    """The file is there, and its folder may not be synchronised."""
    said = []

    def fsync(handle):
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr("ross_payload.atomic_files.os.fsync", fsync)
    with VoiceKeeper(store) as keeper:
        name = keeper.named(Enrol(source=0, consent=True)).name
        keeper.on_event(Enrolled(1.0, name, 0, 0.0, 5.0, model_of()), None)
    keeper.poll(said.append)
    assert store.names() == ("talker-1",)
    assert "Input/output error" in said[0]


def test_a_store_that_cannot_be_read_any_more_ends_no_payload(store):
    class Gone:
        def names(self):
            raise ConfigError("voices: cannot be read: Permission denied")

    with VoiceKeeper(store) as keeper:
        keeper._store = Gone()
        assert keeper.named(Enrol(source=0, consent=True)).name == "talker-1"


def test_a_store_on_a_disk_that_hangs_does_not_hold_up_the_pump(store, monkeypatch, caplog):
    """No stop was heard until the disk answered."""
    store.save("talker-1", model_of())
    hangs, names = threading.Event(), VoiceStore.names
    with VoiceKeeper(store) as keeper:
        assert keeper.named(Enrol(source=0, consent=True)).name == "talker-2"
        monkeypatch.setattr(VoiceStore, "names", lambda store: hangs.wait() and names(store))
        began = time.monotonic()
        assert keeper.named(Enrol(source=0, consent=True)).name == "talker-3"
        assert keeper.named(Enrol(source=0, consent=True)).name == "talker-4"
        assert time.monotonic() - began < 1.0
        assert "the store of voices does not answer" in caplog.text
        hangs.set()


def test_a_number_that_was_asked_for_replaces_the_print(store):
    store.save("talker-1", model_of(seconds=2.0))
    with VoiceKeeper(store) as keeper:
        assert keeper.named(Enrol(source=0, name="talker-1", consent=True)).name == "talker-1"
        keeper.on_event(Enrolled(1.0, "talker-1", 0, 0.0, 5.0, model_of(seconds=5.0)), None)
    assert store.names() == ("talker-1",)
    assert store.load("talker-1").seconds == 5.0
