"""The paper's methods and numbers, as scenarios and as a preset for any configuration."""

import pytest

from ross_payload.config import Config, as_in_paper
from ross_sim.scenario import load
from ross_sim.sitl.talker_selection import directed

NOTHING = {"actuator": None, "separator": None, "urls": (), "seed": None, "target": None, "informed": False}


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_preset_and_the_scenarios_differ_in_what_is_printed_only(number):
    """The scenarios run Algorithms 1 and 2 as printed; the preset takes the paper's methods that serve best."""
    printed = load(f"paper-setting-{number}")
    preset = directed(f"setting-{number}", NOTHING | {"paper": True})
    assert preset.talkers == printed.talkers
    assert preset.payload.audio == printed.payload.audio
    assert preset.payload.guard == printed.payload.guard
    explore, exploit = printed.payload.explore, printed.payload.exploit
    assert (explore.method, exploit.separator) == ("markov-plain", "paper")
    assert preset.payload.explore == explore.model_copy(update={"method": "markov"})
    assert preset.payload.exploit == exploit.model_copy(update={"separator": "duet"})


def test_the_preset_leaves_everything_else_alone():
    mine = Config.model_validate(
        {
            "audio": {"rate_hz": 48000, "hop_ms": 20},
            "guard": {"lower_deg": -90},
            "explore": {"lead_in_s": 5},
            "exploit": {"run_s": 20, "criterion": 1.0},
            "mount": {"yaw_deg": 10},
        }
    )
    papers = as_in_paper(mine)
    assert (papers.audio.rate_hz, papers.audio.hop_ms, papers.guard.lower_deg) == (48000, 20, -90)
    assert (papers.explore.lead_in_s, papers.exploit.run_s, papers.exploit.criterion) == (5, 20, 1.0)
    assert papers.mount == mine.mount


def test_the_command_line_still_chooses_the_separator():
    preset = directed("setting-1", NOTHING | {"paper": True, "separator": "paper"})
    assert preset.payload.exploit.separator == "paper"
    assert preset.payload.exploit.rules == "paper"
