"""The shortest scenario that is a whole mission, and its three talkers."""

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
