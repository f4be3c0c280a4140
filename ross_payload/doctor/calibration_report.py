"""What a calibration says beside a configuration: in words, as JSON, and as keys to be written."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.calibration.estimate import Calibration
from ross_payload.config import Config
from ross_payload.doctor.findings import Finding, ok, warn
from ross_protocols.angle_text import bearing, rotation

APART = 2.0  # standard deviations by which a configured value must differ to be wrong
LATE_S = 5e-6  # a delay between the channels that is worth a word [s]
INAUDIBLE_DB = 0.05  # [dB]
LEAST_HZ = 2.0  # of a difference of roll-off that is worth a correction: 0.2 deg at 500 Hz
HIGHEST_HZ = 300.0  # that a roll-off may be configured to
TOLD_AT_HZ = 500.0  # what a roll-off does to the phase is told there
LOUDEST_DB = 60.0  # that a gain may be configured to [dB]


def changes(config: Config, found: Calibration) -> dict[str, Any]:
    """Keys of the configuration that what was heard contradicts, ``table.key``, and what they should be.

    Of two gains the louder one is lowered, so that nothing clips that did not before.
    """
    wanted: dict[str, Any] = {}
    if abs(found.spacing - config.array.spacing_m) > APART * found.spacing_sigma:
        wanted["array.spacing_m"] = round(found.spacing, 4)
    if found.swapped:
        first, second = ChannelMap.of(config.audio).channels
        wanted["audio.channels"] = [second, first]
    if found.offset is not None and abs(found.offset) > APART * found.azimuth_sigma:
        turned = config.array.offset_deg + math.degrees(found.offset)
        wanted["array.offset_deg"] = round((turned + 180) % 360 - 180, 2)
    gains, inverted = list(config.audio.gain_db), list(config.audio.invert)
    corners = list(config.audio.roll_off_hz)
    if abs(found.gain_db) > max(APART * found.gain_sigma_db, INAUDIBLE_DB):
        louder = 1 if found.gain_db > 0 else 0
        gains[louder] = round(max(gains[louder] - abs(found.gain_db), -LOUDEST_DB), 2)
    if found.inverted:
        inverted[1] = not inverted[1]
    higher, sigma = found.roll_off, found.roll_off_sigma
    if higher is not None and sigma is not None and abs(higher) > max(APART * sigma, LEAST_HZ):
        apart = corners[1] - corners[0] + higher
        corners = [round(min(max(each, 0.0), HIGHEST_HZ), 1) for each in (-apart, apart)]
    if found.swapped:  # they belong to the microphones, which change places
        gains.reverse()
        inverted.reverse()
        corners.reverse()
    if gains != list(config.audio.gain_db):
        wanted["audio.gain_db"] = gains
    if inverted != list(config.audio.invert):
        wanted["audio.invert"] = inverted
    if corners != list(config.audio.roll_off_hz):
        wanted["audio.roll_off_hz"] = corners
    return wanted


def findings(config: Config, found: Calibration, *, earth: bool) -> Iterator[Finding]:
    """Say what was found, number by number."""
    wanted = changes(config, found)
    spacing = f"{1e3 * found.spacing:.1f} ± {1e3 * found.spacing_sigma:.1f} mm"
    yield _against(
        "spacing", spacing, f"{1e3 * config.array.spacing_m:.1f} mm configured", wrong="array.spacing_m" in wanted
    )
    yield from _offset(found, wanted, earth=earth)
    gain = f"microphone 2 is {found.gain_db:+.2f} ± {found.gain_sigma_db:.2f} dB louder than 1"
    gains = config.audio.gain_db
    yield _against("gain", gain, f"with gain_db = [{gains[0]:g}, {gains[1]:g}]", wrong="audio.gain_db" in wanted)
    if found.inverted:
        yield warn("polarity", "the microphones have opposite polarity", "audio.invert, for one of them")
    else:
        yield ok("polarity", "the same at both microphones")
    if found.roll_off is not None and found.roll_off_sigma is not None:
        yield _roll_off(config, found.roll_off, found.roll_off_sigma, wrong="audio.roll_off_hz" in wanted)
    if found.delay is not None and found.delay_sigma is not None:
        yield from _delay(found.delay, found.delay_sigma)
    yield ok("sound", f"{found.direct:.2f} of it came straight, at {found.headings} headings")


def as_values(found: Calibration, wanted: dict[str, Any]) -> dict[str, Any]:
    """Return all of it for JSON: SI, radians, counter-clockwise, and the keys to be written."""
    return {"calibration": asdict(found), "changes": wanted}


def _offset(found: Calibration, wanted: dict[str, Any], *, earth: bool) -> Iterator[Finding]:
    sigma = math.degrees(found.azimuth_sigma)
    if found.offset is None:
        heard = f"heard at {bearing(found.azimuth)} ± {sigma:.1f} deg {'from north' if earth else 'from the nose'}"
        why = "heading offset and swap cannot be told: of this sound no azimuth is known (--azimuth)"
        yield ok("azimuth", f"{heard}, as headings are configured; {why}")
        return
    if found.swapped:
        yield warn("channels", "microphones 1 and 2 are swapped, or the array is mounted back to front", "see below")
    text = f"off by {rotation(found.offset)} ± {sigma:.1f} deg"
    yield _against("offset", text, "beyond what is configured", wrong="array.offset_deg" in wanted)


def _roll_off(config: Config, higher: float, sigma: float, *, wrong: bool) -> Finding:
    phase = math.degrees(math.atan2(abs(higher), TOLD_AT_HZ))
    found = f"of microphone 2 {round(higher):+d} ± {sigma:.0f} Hz above 1, {phase:.1f} deg at {TOLD_AT_HZ:.0f} Hz"
    corners = config.audio.roll_off_hz
    return _against("roll-off", found, f"with roll_off_hz = [{corners[0]:g}, {corners[1]:g}]", wrong=wrong)


def _delay(delay: float, sigma: float) -> Iterator[Finding]:
    if abs(delay) > max(3 * sigma, LATE_S):
        late = 1 if delay > 0 else 2
        found = f"channel {late} comes {1e6 * abs(delay):.0f} us late whatever the heading"
        yield warn("delay", found, "take both channels from one converter, raw; no key corrects this")
    else:
        yield ok("delay", f"none between the channels (± {1e6 * sigma:.1f} us)")


def _against(check: str, measured: str, configured: str, *, wrong: bool) -> Finding:
    said = f"{measured}, {configured}"
    return warn(check, said, "the configuration is wrong; `--write` corrects it") if wrong else ok(check, said)
