"""The numbers of grbl 1.1 in words, after its own tables of error and alarm codes."""

from __future__ import annotations

ERRORS = {
    1: "a letter was expected",
    2: "a number is missing or malformed",
    3: "it does not know this '$' command",
    4: "a value must not be negative",
    5: "homing is not enabled: $22=1 enables it",
    6: "a step pulse must be longer than 3 us",
    7: "its settings could not be read and are the defaults now",
    8: "it must be idle for this '$' command",
    9: "locked out while in alarm or jogging",
    10: "soft limits need homing: $22=1 enables it",
    11: "the line is too long",
    12: "the step rate would be too high",
    13: "the safety door is open",
    14: "the line is too long to be stored",
    15: "the goal is beyond its soft limits",
    16: "not a valid jog",
    17: "laser mode needs a PWM output",
    20: "it does not know this command",
    21: "two commands of one modal group",
    22: "no feed rate",
    23: "a whole number was expected",
    24: "two commands that use the axes",
    25: "a word is there twice",
    26: "the command needs an axis",
    27: "the line number is out of range",
    28: "the command lacks a value",
    29: "it has no such coordinate system",
    30: "G53 goes with G0 and G1 only",
    31: "axes without a command that uses them",
    32: "an arc lacks its axes",
    33: "the target of the motion is not valid",
    34: "the radius of the arc is not valid",
    35: "the arc lacks its offsets",
    36: "words are left over",
    37: "the tool offset is for another axis",
    38: "the tool's number is too high",
}

ALARMS = {
    1: "a limit switch was hit; the position is lost",
    2: "the goal is beyond its soft limits; the position is kept",
    3: "reset while it moved; the position is lost",
    4: "the probe was not at rest before its cycle",
    5: "the probe touched nothing",
    6: "reset while it homed",
    7: "the safety door opened while it homed",
    8: "after homing the switch stays closed: is the pull-off $27 too short?",
    9: "no limit switch found while homing: is the travel $130 too short, or the switch not wired?",
}


def error_words(number: int) -> str:
    """Return an error of grbl 1.1 in words.

    >>> error_words(15)
    'error 15: the goal is beyond its soft limits'
    >>> error_words(99)
    'error 99, which grbl 1.1 does not have'
    """
    return f"error {number}: {ERRORS[number]}" if number in ERRORS else f"error {number}, which grbl 1.1 does not have"


def alarm_words(number: int) -> str:
    """Return an alarm of grbl 1.1 in words.

    >>> alarm_words(1)
    'alarm 1: a limit switch was hit; the position is lost'
    """
    return f"alarm {number}: {ALARMS[number]}" if number in ALARMS else f"alarm {number}, which grbl 1.1 does not have"
