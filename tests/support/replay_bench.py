"""A short mission to be recorded, and its replay."""

import json

from short_mission import TWO

SHORT = """
title = "a short mission"
[payload.explore]
lead_in_s = 1.0
unit_s = 1.0
min_rotations = 1
max_rotations = 1
[payload.exploit]
separator = "gaussian"
track = false
check_s = 1.0
run_s = 1.5
max_restarts = 0
"""
SHORT += TWO


def replayed(session, out, run, *settings):
    """Replay a session with changed settings: the exit code, and what it says as JSON or its complaint."""
    options = [part for setting in settings for part in ("--set", setting)]
    code, said, error = run("replay", session, "--out", out, "--json", *options)
    return code, (json.loads(said) if said else error)
