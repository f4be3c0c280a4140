"""The shortest scenario that is a whole mission, its three talkers, and a live payload that hears a file of noise."""

THREE = """
[[talkers]]
azimuth_deg = 40
[[talkers]]
azimuth_deg = 155
[[talkers]]
azimuth_deg = -80
"""

SHORT = """
title = "a short mission"
[payload.explore]
lead_in_s = 2.0
unit_s = 0.5
min_rotations = 1
max_rotations = 2
[payload.exploit]
check_s = 1.0
run_s = 1.0
max_restarts = 0
"""
SHORT += THREE

NOISE = """
[audio]
source = "file:noise.wav"
[actuator]
kind = "tb6600"
options = {{ ahead_ms = 100 }}
[explore]
unit_s = 1.0
min_rotations = 2
max_rotations = 2
[service]
state_dir = "state"
[[links]]
url = "udpin:127.0.0.1:{port}"
"""  # of `ross run`; explores, and finds nobody
