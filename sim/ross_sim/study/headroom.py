"""What the missions of a scenario compute per second of sound, state by state.

`python -m ross_sim.study.headroom OUT.csv` flies them in lock-step, one after the other, and writes a row for every
state of each.
"""

from __future__ import annotations

from pathlib import Path

import click

from ross_sim.sitl.mission_session import perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.talker_selection import directed, talkers_of
from ross_sim.study.option_types import CommaSeparated
from ross_sim.study.rows.headroom_rows import WORDS, HeadroomRow, headroom
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.script_errors import expect_writable, told_in_a_line, write_result


def flown(scenario: str, seed: int, speech: Path | None = None) -> list[HeadroomRow]:
    """Fly one mission; the rows of its states.

    Raises
    ------
    ConfigError
        When the scenario or the speech is wrong.
    """
    changes = dict.fromkeys(("actuator", "separator", "paper", "informed", "target"))
    asked = directed(scenario, {**changes, "speech": speech, "seed": seed, "urls": ()})
    payload = asked.payload
    cost = perform(asked, talkers_of(asked, speech, None), MissionView(), None, None).cost
    hop_s = payload.hop / payload.audio.rate_hz
    return [
        HeadroomRow(
            scenario, seed, state.name, round(spent.hops * hop_s, 3), round(spent.cpu_s, 6), round(spent.longest_s, 6)
        )
        for state, spent in sorted(cost.states.items())
        if state.name in WORDS and spent.hops
    ]


@click.command()
@click.argument("out", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--scenario", default="demo", show_default=True, help="As of ross sitl.")
@click.option("--seeds", type=CommaSeparated(int, low=0), default="0", show_default=True)
@click.option("--speech", type=click.Path(path_type=Path, exists=True, file_okay=False), help="Folder of talkers.")
def main(out: Path, scenario: str, seeds: tuple[int, ...], speech: Path | None) -> None:
    """Fly the missions of a scenario in lock-step; write what each computes in every state into OUT."""
    with told_in_a_line():
        expect_writable(out)
        rows = [row for seed in seeds for row in flown(scenario, seed, speech)]
        write_result(out, as_csv(rows, HeadroomRow))
        click.echo(headroom(rows).body())


if __name__ == "__main__":
    main()
