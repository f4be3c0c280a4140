"""A client with the package `dronecan` loads our types as the manual says, in a process of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.process

pytest.importorskip("can")
pytest.importorskip("dronecan")

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "dronecan-node.md"
CLIENT = """
import sys, time
import can, dronecan
from dronecan.app.node_monitor import NodeMonitor
from dronecan_bus import peer
from ross_protocols.dronecan.messages import NodeStatus
from ross_protocols.dronecan.ross_types import RossStatus
from ross_protocols.dronecan.node_messages import Encoder

for folder in sys.argv[1:]:
    dronecan.load_dsdl(folder)
node, heard = peer("bus", 9), []
monitor = NodeMonitor(node)
node.add_handler(dronecan.TYPENAMES["ross.Status"], lambda event: heard.append(event.message.state))
bus, voice = can.Bus("bus", "virtual", ignore_config=True), Encoder(121)
for message in (NodeStatus(1), RossStatus(state=5)):
    for frame in voice.broadcast(message):
        bus.send(can.Message(arbitration_id=frame.id, data=frame.data, is_extended_id=True))
end = time.monotonic() + 60
while time.monotonic() < end and not heard:  # it came last
    node.spin(0.01)
print(heard, monitor.exists(121))
"""


@pytest.mark.soak
def test_the_folder_of_vendor_types_lets_a_client_read_us_and_load_dsdl_does_not(tmp_path):
    with_folder, without = tmp_path / "with", tmp_path / "without"
    for home in (with_folder, without):
        home.mkdir()
        shutil.copy(ROOT / "tests" / "support" / "dronecan_bus.py", home)

    def said(home, *folders):
        environment = os.environ | {"HOME": str(home), "PYTHONPATH": str(home)}
        command = [sys.executable, "-c", CLIENT, *folders]
        done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=True)
        return done.stdout.strip()

    block = PAGE.read_text(encoding="utf-8").split("mkdir -p ~/dronecan", 1)[1].split("```", 1)[0]
    shell = f"mkdir -p ~/dronecan{block}"
    subprocess.run(["sh", "-ec", shell], env=os.environ | {"HOME": str(with_folder)}, cwd=ROOT, check=True)
    assert said(with_folder) == "[5] True"
    assert said(without, "protocols/dronecan/ross") == "[5] False", "the page warns of nothing"
