"""A link in bad weather: frames are lost, doubled, late and damaged between a payload and its ground station."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega

from ross_payload.config.parameter_table import TABLE
from waiting import wait_for

MEASURE_NOISE = 54007
ACCEPTED = 0
TIMES = (0.5, 0.6, 0.7)  # [s]; no motor that a busy computer might starve
FOUL = {"loss": 0.2, "double": 0.2, "late": 0.2, "damage": 0.05}


def parameters_of(ground):
    """Ask for the list of parameters, and again for what is missing."""
    questions = [ardupilotmega.MAVLink_param_request_list_message(1, 191)]
    have, asked = {}, 0
    while questions:
        for question in questions:
            ground.link.mav.send(question)
        asked += len(questions)
        ground.rest(1.2 if asked == 1 else 0.5)
        have |= {one.param_index: one for one in ground.of("PARAM_VALUE")}
        count = next(iter(have.values())).param_count if have else 1
        missing = [index for index in range(count) if index not in have]
        questions = [ardupilotmega.MAVLink_param_request_read_message(1, 191, b"", index) for index in missing]
        assert asked < 300, f"{len(have)} of {count} parameters"
    return {one.param_id: one.param_value for one in have.values()}


@pytest.fixture(scope="module")
def flight(ross_run, ground_stations, weather, tmp_path_factory):
    """A payload, a ground station, and the weather between them."""
    ground = ground_stations()
    path = weather(ground.port, **FOUL)
    folder = tmp_path_factory.mktemp("foul")
    with ross_run(folder, f'url = "udpout:127.0.0.1:{path.port}"') as payload:
        ground.wait("HEARTBEAT")
        yield payload, ground, path


def test_every_command_is_obeyed_once(flight):
    payload, ground, path = flight
    for time in TIMES:
        assert ground.obeyed(MEASURE_NOISE, time) == ACCEPTED
        ground.rest(0.5)  # an answer that comes late or twice could not be told from the next one
    assert len(set(payload.answers("done"))) == len(TIMES)
    assert len(payload.answers("accepted")) == len(TIMES)
    heard = [line for line in payload.lines() if line.startswith("mission over: noise measured")]
    assert heard == [f"mission over: noise measured for {time} s" for time in TIMES]
    assert path.fates["lost"] > 0


def test_the_parameters_are_complete_after_the_missing_were_asked_for_again(flight):
    _, ground, _ = flight
    found = parameters_of(ground)
    assert set(found) == set(TABLE)


def test_what_is_set_is_in_force_whatever_came_first_or_twice(flight):
    payload, ground, _ = flight
    for value in (2.0, 4.0, 2.5, 3.5):
        ground.set("EXP_UNIT", value)
    wait_for(lambda: payload.kept() == {"EXP_UNIT": 3.5}, what=payload.kept)  # the file is written beside the link
