"""A signed link of a payload in another process: what is played again, or not signed, is not obeyed."""

import secrets

import pytest

from waiting import wait_for

pytestmark = pytest.mark.process
MEASURE_NOISE = 54007
ACCEPTED = 0


@pytest.fixture(scope="module")
def signed(ross_run, ground_stations, weather, tmp_path_factory):
    """How to start a payload with a signed link, its ground station, and the path between them."""
    key, folder = secrets.token_bytes(32), tmp_path_factory.mktemp("signed")
    (folder / "key").write_bytes(key)
    (folder / "key").chmod(0o600)
    ground = ground_stations()
    ground.link.setup_signing(key)
    path = weather(ground.port)

    def start():
        return ross_run(folder, f'url = "udpout:127.0.0.1:{path.port}"\nkey_file = "key"')

    return start, ground, path


def session(ground):
    """Do something that changes the payload."""
    ground.wait("HEARTBEAT")
    ground.set("EXP_UNIT", 2.5)
    assert ground.obeyed(MEASURE_NOISE, 0.2) == ACCEPTED


def replayed(ground, path, payload, captured):
    """Send what was captured once more; return what has become of it."""
    answers, accepted = len(ground.of("COMMAND_ACK")), len(payload.answers("accepted"))
    for datagram in captured:
        path.up(datagram)
    ground.rest(1.5)
    return len(ground.of("COMMAND_ACK")) - answers, len(payload.answers("accepted")) - accepted, payload.kept()


def test_a_session_that_is_played_again_changes_nothing_also_after_a_restart(signed):
    start, ground, path = signed
    with start() as payload:
        session(ground)
        captured = [*path.captured]
        ground.set("EXP_UNIT", 3.5)
        assert replayed(ground, path, payload, captured) == (0, 0, {"EXP_UNIT": 3.5})
    beats = len(ground.of("HEARTBEAT"))
    with start() as payload:
        ground.wait("HEARTBEAT", since=beats)
        assert replayed(ground, path, payload, captured) == (0, 0, {"EXP_UNIT": 3.5})
        assert ground.obeyed(MEASURE_NOISE, 0.2) == ACCEPTED, "the true sender is still believed"
        obeyed = payload.answers("accepted")
        ground.link.disable_signing()
        ground.command(MEASURE_NOISE, 0.3)
        ground.rest(1.5)
        assert payload.answers("accepted") == obeyed, "what is not signed is not obeyed"


def test_without_a_key_a_session_that_is_played_again_has_effect(ross_run, ground_stations, weather, tmp_path):
    """So that the tests above can fail: this is what a key is for."""
    ground = ground_stations()
    path = weather(ground.port)
    with ross_run(tmp_path, f'url = "udpout:127.0.0.1:{path.port}"') as payload:
        session(ground)
        captured = [*path.captured]
        ground.set("EXP_UNIT", 3.5)
        for datagram in captured:
            path.up(datagram)
        wait_for(lambda: payload.kept() == {"EXP_UNIT": 2.5})
