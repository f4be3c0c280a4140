"""The probe of an actuator that is a plug-in, in a world of its own: both keep to real time.

Nobody listens there, so the world renders no sound: five of them at once would keep it from telling where it is.
"""

import os
import re
import subprocess

import pytest

from own_plugin import run
from processes import ROSS
from short_mission import SHORT


@pytest.mark.soak
def test_the_probe_looks_at_one_in_another_process(folder):
    environment = os.environ | {"PYTHONPATH": str(folder / "site")}
    world = [*ROSS, "world", "--actuator", "my_turntable"]
    (folder / "short.toml").write_text(SHORT)
    command = [*world[:4], "short.toml", *world[4:]]
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as serving:
        try:
            port = next(found[1] for line in serving.stdout if (found := re.search(r'port = "(serial:.+)"', line)))
            text = (folder / "bench.toml").read_text().replace("serial:/dev/ttyUSB0:115200", port)
            (folder / "served.toml").write_text(f"{text}watchdog_s = 5\n")  # the computer may be busy
            probed = run(folder, "ross_payload.cli", "actuators", "probe", "served.toml", "--move", "--yes")
        finally:
            serving.terminate()
            serving.wait(60)
    assert probed.returncode in {0, 1}, probed.stdout + probed.stderr
    assert "it turns the way it is commanded" in probed.stdout
