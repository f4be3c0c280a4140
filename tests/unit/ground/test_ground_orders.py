"""Orders to a payload that is scripted: what is said again, what every answer means, and what is shown."""

from collections import Counter

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from client_bench import OVER, WHO
from examples import examples
from ross_payload.ground.client.command_types import Cancel, Explore, Listen, Rearm, Record, Stop, Turn
from ross_payload.ground.model.payload_state import PayloadState as Known
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.values import Severity, Text
from scripted_payload import Script

TURN, LISTEN, STOP = ross.MAV_CMD_ROSS_TURN, ross.MAV_CMD_ROSS_LISTEN, ross.MAV_CMD_ROSS_STOP


def test_an_order_that_nobody_answers_is_said_five_times_in_four_seconds(script):
    script.orders.order(WHO, Turn(40))
    script.wait(20)
    assert [at for at, _ in script.heard] == pytest.approx([0, 1, 2, 3, 4], abs=0.06)
    assert [message.confirmation for _, message in script.heard] == [0, 1, 2, 3, 4]
    assert {(m.target_system, m.target_component, m.command, m.param1) for _, m in script.heard} == {(1, 191, TURN, 40)}
    (doing,) = script.orders.doing
    assert (doing.state, doing.at) == ("no_answer", pytest.approx(5.0, abs=0.06))
    assert "accept" in doing.reason


def test_a_stop_that_nobody_answers_is_said_for_half_a_minute_and_told_after_two_seconds(script):
    script.orders.order(WHO, Stop())
    script.wait(2.1)
    assert script.states() == ["sent"]
    script.wait(0.2)
    (told,) = script.orders.doing
    assert told.state == "no_answer"
    script.wait(27)
    tries = [0.2 * k for k in range(11)]
    assert [at for at, _ in script.heard] == pytest.approx([*tries, *(2.2 + k for k in range(28))], abs=0.06)
    assert script.orders.doing == (told,)
    script.wait(5)
    assert (len(script.heard), script.orders.doing) == (11 + 28, (told,))


def test_a_stop_that_was_told_as_unanswered_is_done_when_the_link_returns(script):
    script.orders.order(WHO, Stop())
    script.wait(12)
    assert script.states() == ["no_answer"]
    script.ack(STOP, Result.ACCEPTED)
    said = len(script.heard)
    script.wait(5)
    assert (script.states(), len(script.heard)) == (["done"], said)


@pytest.mark.parametrize("order", [Rearm(), Stop()])
def test_an_unanswered_stop_is_said_no_more_after_an_arming_or_its_like(order, script):
    script.orders.order(WHO, Stop())
    script.wait(5)
    said = len(script.heard)
    script.orders.order(WHO, order)
    script.ack(order.number, Result.ACCEPTED)
    script.wait(5)
    assert len(script.heard) == said + 1
    assert script.states()[-1] == "done"


def test_of_many_stops_in_a_row_the_latest_is_sent_five_times_a_second_and_all_end_alike(script):
    """A key that is held gives thirty a second, and a slow link carries a hundred frames."""
    for _ in range(60):
        script.orders.order(WHO, Stop())
        script.wait(0.05)
    pressed = len(script.heard)
    assert pressed <= 60 * 1.2
    script.wait(2.0)
    assert len(script.heard) - pressed == pytest.approx(10, abs=1)
    script.wait(1.0)
    assert set(script.states()) == {"no_answer"}
    script.ack(STOP, Result.ACCEPTED)
    assert set(script.states()) == {"done"}


def test_a_second_stop_counts_its_frames_so_that_a_log_has_two(script):
    """With the confirmation 0 every one of a hundred frames would be a stop of its own."""
    for _ in range(2):
        script.orders.order(WHO, Stop())
        script.wait(5)
    first, second = (sent for _, sent in script.heard if sent.confirmation == 0)
    assert first.command == second.command == STOP


def test_a_stop_cannot_be_cancelled(script):
    """Nothing ends it but a re-arming; to cancel it would only keep it from being sent again."""
    number = script.orders.order(WHO, Stop())
    script.wait(1)
    script.orders.cancel(number)
    script.wait(3)
    script.orders.cancel(number)
    said = len(script.heard)
    script.wait(2)
    assert {message.get_type() for _, message in script.heard} == {"COMMAND_LONG"}
    assert len(script.heard) - said == pytest.approx(2, abs=1)


def test_a_payload_that_restarts_is_told_the_stop_that_it_has_not_answered(script):
    script.orders.order(WHO, Turn(40))
    script.orders.order(WHO, Stop())
    script.wait(8)
    script.orders.on_state(Known(WHO, 0.0, script.now, boots=2))
    script.wait(0.05)
    assert script.heard[-1] == (pytest.approx(8.0, abs=0.06), script.heard[-1][1])
    assert script.heard[-1][1].command == STOP
    script.ack(STOP, Result.ACCEPTED)
    assert script.states() == ["cancelled", "done"]


def test_a_stop_for_a_payload_that_was_never_heard_is_sent_for_half_a_minute():
    script = Script(met=False)
    script.orders.order(WHO, Turn(40))
    script.orders.order(WHO, Stop())
    script.wait(29)
    assert script.states() == ["cancelled", "sent"]
    script.wait(2)
    assert script.states() == ["cancelled", "no_answer"]
    said = len(script.heard)
    script.wait(5)
    assert len(script.heard) == said


def test_a_stop_is_sent_again_as_soon_as_its_payload_is_heard_for_the_first_time():
    script = Script(met=False)
    script.orders.order(WHO, Stop())
    script.wait(20.05)
    script.orders.on_state(Known(WHO, 0.0, script.now))
    said = len(script.heard)
    script.wait(0.05)
    assert len(script.heard) == said + 1
    script.ack(STOP, Result.ACCEPTED)
    assert script.states() == ["done"]


def test_a_stop_waits_for_nothing_and_silences_what_was_never_heard(script):
    for order in (Turn(40), Rearm(), Explore()):
        script.orders.order(WHO, order)
    script.orders.order(WHO, Stop())
    assert script.heard[-1] == (0.0, script.heard[-1][1])
    assert script.heard[-1][1].command == STOP
    script.wait(6)
    assert script.states() == ["cancelled", "cancelled", "cancelled", "no_answer"]
    assert {message.command for at, message in script.heard if at > 0} == {STOP}


def test_a_cancel_that_was_not_heard_does_not_end_the_order_after_it(script):
    script.orders.order(WHO, Cancel())
    script.orders.order(WHO, Explore())
    script.wait(3)
    assert {message.command for at, message in script.heard if at > 0} == {Explore.number}


@pytest.mark.parametrize(
    ("result", "state", "word"),
    [
        (Result.ACCEPTED, "done", ""),
        (Result.TEMPORARILY_REJECTED, "refused", "not possible now"),
        (Result.DENIED, "refused", "accept"),
        (Result.UNSUPPORTED, "refused", "does not support"),
        (Result.FAILED, "failed", "did not complete"),
        (Result.CANCELLED, "cancelled", "ended by"),
    ],
)
def test_every_result_has_a_state_and_words_even_without_a_text(script, result, state, word):
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, result)
    (doing,) = script.orders.doing
    assert doing.state == state
    assert word in doing.reason


def test_an_answer_to_somebody_else_is_none(script):
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, Result.ACCEPTED, to=(254, 190))
    script.ack(TURN, Result.ACCEPTED, to=(255, 1))
    script.ack(TURN, Result.ACCEPTED, encoder=Encoder(2, 191))
    script.ack(TURN, Result.ACCEPTED, encoder=Encoder(1, 154))
    script.ack(LISTEN, Result.ACCEPTED)
    assert script.states() == ["sent"]
    script.ack(TURN, Result.ACCEPTED, to=(0, 0))
    assert script.states() == ["done"]


def test_a_text_about_another_order_is_no_reason(script):
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, Result.DENIED)
    script.say(Text(Severity.WARNING, "RoSS: listen refused: nobody there"))
    assert "nobody" not in script.orders.doing[-1].reason


def test_a_reason_that_comes_before_its_refusal_counts_and_a_late_one_does_not(script):
    text = Text(Severity.WARNING, "RoSS: turn refused: beyond the limit")
    script.orders.order(WHO, Turn(40))
    script.say(text)
    script.wait(0.2)
    script.ack(TURN, Result.DENIED)
    assert script.orders.doing[-1].reason == "beyond the limit"
    script.wait(5)
    script.orders.order(WHO, Turn(41))
    script.ack(TURN, Result.DENIED)
    script.wait(2)
    script.say(text)
    assert script.orders.doing[-1].reason != "beyond the limit"


def test_why_an_order_was_refused_is_no_reason_for_the_next_one(script):
    script.orders.order(WHO, Turn(400))
    script.ack(TURN, Result.DENIED)
    script.say(Text(Severity.WARNING, "RoSS: turn refused: heading: got 400"))
    script.wait(1.2)
    script.orders.order(WHO, Turn(30))
    script.ack(TURN, Result.TEMPORARILY_REJECTED)
    first, second = script.orders.doing
    assert (first.reason, second.reason) == ("heading: got 400", "not possible now")
    script.say(Text(Severity.WARNING, "RoSS: turn refused: stopped: re-arm first"))
    first, second = script.orders.doing
    assert (first.reason, second.reason) == ("heading: got 400", "stopped: re-arm first")


def test_a_failure_is_told_in_the_words_of_the_missions_end(script):
    script.orders.order(WHO, Explore())
    script.ack(Explore.number, Result.IN_PROGRESS)
    script.say(Text(Severity.CRITICAL, "RoSS: mission over: the actuator is blocked"))
    script.ack(Explore.number, Result.FAILED)
    assert script.orders.doing[-1].reason == "the actuator is blocked"


def test_a_doubled_end_of_one_order_does_not_end_the_next(script):
    for heading in (40, 41):
        script.orders.order(WHO, Turn(heading))
        script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done", "sent"]
    script.ack(TURN, Result.IN_PROGRESS)
    script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done", "acknowledged"]
    script.wait(1.0)
    assert script.heard[-1][1].confirmation == 1, "it asks whose answer that was"
    script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done", "done"]


def test_a_second_stop_is_in_doubt_only_when_something_was_armed_in_between(script):
    for order in (Stop(), Stop(), Rearm(), Stop()):
        script.orders.order(WHO, order)
        script.ack(order.number, Result.ACCEPTED)
    assert script.states() == ["done", "done", "done", "sent"]


def test_a_second_stop_does_not_cancel_the_first_while_the_disk_is_slow(script):
    for _ in range(2):
        script.orders.order(WHO, Stop())
        script.ack(STOP, Result.IN_PROGRESS)
        script.wait(0.5)
    script.ack(STOP, Result.IN_PROGRESS)
    assert script.states() == ["acknowledged", "in_progress"]
    script.ack(STOP, Result.ACCEPTED)
    assert script.states() == ["done", "done"]


def test_a_stop_in_progress_that_falls_silent_is_said_again_whatever_came_after_it(script):
    script.orders.order(WHO, Stop())
    script.ack(STOP, Result.IN_PROGRESS)
    script.orders.order(WHO, Stop())
    script.wait(3.9)
    assert script.heard[-1][0] > 3.0


def test_an_answer_after_all_is_shown_though_it_was_given_up(script):
    script.orders.order(WHO, Turn(40))
    script.wait(8)
    assert script.states() == ["no_answer"]
    script.ack(TURN, Result.IN_PROGRESS, progress=0.5)
    assert (script.states(), script.orders.doing[-1].progress) == (["in_progress"], 0.5)
    script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done"]


def test_a_payload_that_restarts_does_not_do_what_it_was_told_before(script):
    script.orders.on_state(Known(WHO, 0.0, 0.0, boots=1))
    script.orders.order(WHO, Turn(40))
    script.orders.order(ComponentId(2, 191), Turn(40))
    script.orders.on_state(Known(WHO, 0.0, 1.0, boots=2))
    assert script.states() == ["failed", "sent"]
    assert script.orders.doing[0].reason == "the payload restarted"
    script.wait(3)
    assert {message.target_system for at, message in script.heard if at > 0} == {2}


def test_the_latest_fifty_are_kept(script):
    for heading in range(60):
        script.orders.order(WHO, Turn(heading))
    assert [doing.words for doing in script.orders.doing] == [f"turn to {h} deg" for h in range(10, 60)]
    script.wait(1.1)
    assert len(script.heard) == 60 + 1  # the others would undo the last one


def test_of_more_orders_than_are_kept_a_stop_is_told_until_it_is_answered(script):
    fleet = [ComponentId(system, 191) for system in range(1, 65)]
    for who in fleet:
        script.orders.order(who, Stop())
    for _ in range(60):
        script.orders.order(WHO, Record(True))
    script.wait(2.0)
    told = Counter(message.target_system for _, message in script.heard if message.command == STOP)
    assert all(told[who[0]] >= 9 for who in fleet)
    script.wait(30.0)
    script.orders.order(WHO, Turn(40))
    assert len(script.orders.doing) == 50


def test_a_result_that_nobody_knows_changes_nothing(script):
    script.orders.order(WHO, Turn(40))
    script.say(ross.MAVLink_command_ack_message(TURN, 77, target_system=255, target_component=190))
    assert script.states() == ["sent"]


KINDS = [Explore(), Turn(40.0), Turn(41.0), Listen(source=1), Stop(), Rearm(), Cancel(), Record(True), Record(False)]

actions = st.one_of(
    st.tuples(st.just("order"), st.sampled_from(KINDS)),
    st.tuples(st.just("ack"), st.sampled_from(KINDS), st.sampled_from(Result), st.sampled_from([None, 0.0, 0.7])),
    st.tuples(st.just("wait"), st.sampled_from([0.05, 0.3, 1.0, 2.5, 6.0])),
    st.tuples(st.just("cancel"), st.integers(0, 12)),
    st.tuples(st.just("restart"), st.just(0)),
)


@settings(max_examples=examples(300))
@given(st.lists(actions, max_size=25))
@example([("order", Turn(40.0)), ("cancel", 1), ("wait", 6.0), ("ack", Turn(40.0), Result.IN_PROGRESS, None)])
def test_whatever_is_answered_what_is_over_stays_over_and_silence_ends_every_talk(story):
    script, boots, over = Script(), 1, {}
    for what, *how in story:
        match what:
            case "order":
                script.orders.order(WHO, how[0])
            case "ack":
                script.ack(how[0].number, how[1], progress=how[2])
            case "wait":
                script.wait(how[0])
            case "cancel":
                script.orders.cancel(how[0])
            case "restart":
                boots += 1
                script.orders.on_state(Known(WHO, 0.0, script.now, boots=boots))
        now = {doing.number: doing.state for doing in script.orders.doing if doing.state in OVER[:-1]}
        assert over.items() <= now.items()
        over = now
    script.wait(31)
    said = len(script.heard)
    script.wait(5)
    assert len(script.heard) == said
    assert set(script.states()) <= set(OVER)
