"""The files that people copy are right: configurations validate, parameter files parse, names agree."""

import configparser
import re
from pathlib import Path

import pytest

from ross_payload import plugins
from ross_payload.actuators.registry import GROUP, checked_options
from ross_payload.config import Config, load, read_toml, validated
from ross_payload.service.assemble import explorer_of, settings_of, tools_of
from ross_payload.transport.link_url import parse

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
CONFIGURATIONS = sorted(EXAMPLES.glob("*.toml"))
RULE = re.compile(r'(SUBSYSTEM|KERNELS?|ATTRS?\{\w+\}|ENV\{\w+\})(==|=)"[^"]*"|SYMLINK\+="[\w-]+"')


def test_there_is_a_configuration_for_every_kind_of_mount():
    assert [path.stem for path in CONFIGURATIONS] == [
        "drone-mavlink-gimbal",
        "drone-vehicle-yaw",
        "pan-unit-can-servo",
        "pan-unit-canopen-drive",
        "pan-unit-grbl",
        "paper-bench",
    ]


@pytest.mark.parametrize("path", CONFIGURATIONS, ids=lambda path: path.stem)
def test_a_configuration_is_good_but_for_back_ends_that_are_not_installed(path):
    config = load(path)
    if config.actuator.kind in plugins.available(GROUP):
        checked_options(config)
    else:
        assert "`ross actuators`" in path.read_text().splitlines()[1]
    tools_of(config, None)
    settings_of(config, 0.0, 1.0)
    explorer_of(config)
    assert all(parse(link.url) for link in config.links)


@pytest.mark.parametrize("path", CONFIGURATIONS, ids=lambda path: path.stem)
def test_an_example_moves_nothing_by_itself_and_reaches_every_axis(path):
    config = load(path)
    assert config.service.autostart == "nothing"
    assert config.guard.upper_deg - config.guard.lower_deg >= 180


def test_the_paper_s_bench_is_the_paper_s():
    values = read_toml(EXAMPLES / "paper-bench.toml")
    del values["actuator"], values["links"], values["service"], values["recording"], values["audio"]["source"]
    bench = validated(Config, values, "bench")
    assert (bench.array.spacing_m, bench.audio.rate_hz, bench.explore.step_deg) == (0.05, 16000, 15.0)
    assert (bench.explore.method, bench.exploit.separator, bench.exploit.rules) == ("markov", "duet", "paper")


def rows(name):
    lines = (EXAMPLES / name).read_text().splitlines()
    return [line.split() for line in lines if line and not line.startswith("#")]


def test_ardupilot_s_parameters_are_names_and_numbers():
    for name, value in rows("ardupilot.parm"):
        assert re.fullmatch(r"[A-Z][A-Z0-9_]{0,15}", name)
        float(value)


def test_px4_s_parameters_are_in_qgroundcontrol_s_format():
    for system, component, name, value, kind in rows("px4.params"):
        assert (system, component, kind) == ("1", "1", "6")
        assert re.fullmatch(r"[A-Z][A-Z0-9_]{0,15}", name)
        int(value)


def test_the_router_gives_the_payload_a_port_of_its_own():
    router = configparser.ConfigParser()
    router.read(EXAMPLES / "mavlink-router.conf")
    assert router["UdpEndpoint payload"]["Mode"] == "Normal"
    assert router["UdpEndpoint payload"]["Port"] != router["UdpEndpoint ground"]["Port"]


def test_the_udev_rules_are_comparisons_and_one_name_each():
    lines = (EXAMPLES / "99-ross.rules").read_text().splitlines()
    for line in (line for line in lines if line and not line.startswith("#")):
        parts = line.split(", ")
        assert all(RULE.fullmatch(part) for part in parts), line
        assert sum("==" not in part for part in parts) == 1


def test_can_comes_up_by_itself():
    network = configparser.ConfigParser()
    network.read(EXAMPLES / "80-can.network")
    assert network["CAN"]["BitRate"] == "1M"
