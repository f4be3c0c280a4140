"""The word ``ross`` on MAVProxy's command line, without MAVProxy."""

import pytest

from emulated_scene import full
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.mavproxy.shell import Shell
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import Result, acknowledgement, command_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.values import Severity, Text


class Prompt:
    """A command line beside payloads whose answers the test gives."""

    def __init__(self, *systems):
        self.said, self.sent = [], []
        orders = CommandProtocol(lambda message, who: self.sent.append((who, command_of(message))), 255, 230)
        self.shell = Shell(orders, self.said.append)
        self._encoders = {system: Encoder(system, 191) for system in systems}
        self.now = 0.0
        for system in systems:
            for value in full(30.0, 3, system):
                self.hear(system, value)

    def hear(self, system, value):
        for packet in Decoder().feed(self._encoders[system].encode(value)):
            self.shell.on_packet(packet, self.now)

    def type(self, line):
        before = len(self.said)
        self.shell.execute(line.split())
        return "\n".join(self.said[before:])

    def wait(self, seconds):
        self.now += seconds
        self.shell.tick(self.now)


@pytest.mark.parametrize(
    ("line", "number", "numbers"),
    [
        ("explore", 54000, []),
        ("listen voice", 54001, [0]),
        ("listen 2", 54001, [1, 2]),
        ("listen azimuth -90", 54001, [2, 0, -90]),
        ("turn 30.5", 54003, [30.5]),
        ("stop", 54004, []),
        ("STOP", 54004, []),
        ("cancel", 54005, []),
        ("park", 54006, []),
        ("noise", 54007, [0]),
        ("noise 2.5", 54007, [2.5]),
        ("record on", 54008, [1]),
        ("record off", 54008, [0]),
        ("rearm", 54009, []),
        ("home", 54010, []),
    ],
)
def test_every_order_is_sent_and_said(line, number, numbers):
    prompt = Prompt(1)
    assert "RoSS 1-191 " in prompt.type(line)
    [(who, command)] = prompt.sent
    assert (str(who), command.number) == ("1-191", number)
    assert list(command.numbers)[: len(numbers)] == numbers


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("listen", "expected ross listen voice|SOURCE|azimuth DEG"),
        ("listen somebody", "expected a number, got 'somebody'"),
        ("listen 1.5", "expected a whole number"),
        ("turn", "expected ross turn DEG"),
        ("turn nan", "heading: expected -360 to 360, got NaN"),
        ("turn 1000", "heading: expected -360 to 360, got 1000.0"),
        ("record maybe", "expected ross record on|off"),
        ("noise 61", "seconds: expected 0 to 60, got 61.0"),
        ("rearm now", "expected ross park|home|rearm"),
        ("dance", "expected a word that ross help lists, got 'dance'"),
        ("payload x", "expected system-component, as in 1-191, got 'x'"),
        ("payload 9-191", "9-191 was not received"),
    ],
)
def test_a_mistake_is_one_line_and_orders_nothing(line, words):
    prompt = Prompt(1)
    said = prompt.type(line)
    assert words in said
    assert said.startswith("ross: ")
    assert len(said.splitlines()) == 1
    assert prompt.sent == []


@pytest.mark.parametrize("line", ["explore", "status", "sources", "payload"])
def test_without_a_payload_it_says_what_to_check(line):
    prompt = Prompt()
    assert "received yet" in prompt.type(line)
    assert prompt.sent == []


def test_nothing_typed_is_the_status():
    said = Prompt(1).type("")
    assert "RoSS 1-191  RUN" in said
    assert "axis " in said
    assert "microphones" in said


def test_sources_are_a_table():
    lines = Prompt(1).type("sources").splitlines()
    assert lines[0].startswith("source azimuth")
    assert [line.split()[0].rstrip("*") for line in lines[1:4]] == ["0", "1", "2"]
    assert any(line.startswith("heading  isolates") for line in lines)


def test_help_names_every_command():
    said = Prompt().type("help")
    for word in ("status", "sources", "explore", "listen", "turn", "stop", "cancel", "park", "record", "noise"):
        assert f"ross {word}" in said


def test_a_refusal_is_said_once_and_with_its_reason():
    prompt = Prompt(1)
    prompt.type("explore")
    prompt.hear(1, acknowledgement(54000, Result.TEMPORARILY_REJECTED, ComponentId(255, 230)))
    prompt.hear(1, Text(Severity.WARNING, "RoSS: explore refused: stopped: re-arm first"))
    prompt.wait(1.0)
    assert prompt.said == ["RoSS 1-191 explore: sent", "RoSS 1-191 explore: refused: stopped: re-arm first"]


def test_a_refusal_without_a_reason_is_said_too():
    prompt = Prompt(1)
    prompt.type("explore")
    prompt.hear(1, acknowledgement(54000, Result.UNSUPPORTED, ComponentId(255, 230)))
    prompt.wait(1.0)
    assert prompt.said[-1] == "RoSS 1-191 explore: refused: this payload does not support the command"


def test_what_is_done_is_said_and_progress_only_begins():
    prompt = Prompt(1)
    prompt.type("turn 40")
    for share in (0.1, 0.5, 0.9):
        prompt.hear(1, acknowledgement(54003, Result.IN_PROGRESS, ComponentId(255, 230), share))
    prompt.hear(1, acknowledgement(54003, Result.ACCEPTED, ComponentId(255, 230)))
    assert [line.rpartition(": ")[2] for line in prompt.said] == ["sent", "in progress", "done"]


def test_an_order_that_nobody_answers_is_sent_again_and_given_up():
    prompt = Prompt(1)
    prompt.type("turn 40")
    for _ in range(100):
        prompt.wait(0.1)
    assert len(prompt.sent) > 2
    assert "no answer" in prompt.said[-1]


def test_another_payload_can_be_chosen():
    prompt = Prompt(2, 5)
    prompt.type("stop")
    assert "commands go to 5-191" in prompt.type("payload 5-191")
    prompt.type("stop")
    assert [str(who) for who, _ in prompt.sent] == ["2-191", "5-191"]


def test_the_status_bar_says_state_and_silence():
    prompt = Prompt(1)
    assert prompt.shell.summary() == ("RoSS 1-191 run K 3", "good")
    prompt.wait(3.0)
    assert prompt.shell.summary() == ("RoSS 1-191 no data", "act")
    assert Prompt().shell.summary() == ("RoSS -", "unknown")


def test_texts_of_others_cannot_move_the_cursor():
    prompt = Prompt(1)
    prompt.type("explore")
    prompt.hear(1, acknowledgement(54000, Result.DENIED, ComponentId(255, 230)))
    prompt.hear(1, Text(Severity.WARNING, "RoSS: explore refused: \x1b[2J"))
    prompt.wait(1.0)
    assert "\x1b" not in "".join(prompt.said)
