"""Known arrays of microphones: which channels are microphones, and where those stand.

Channels and places are the makers' (descriptions, firmware's own answers) and users' reports; none was tried here.
Firmwares differ: ``ross devices --tap`` tells channels, ``ross calibrate`` measures the spacing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

Place = tuple[float, float]  # in the plane of the array [m]


@dataclass(frozen=True, slots=True)
class ArrayPreset:
    """A known array of microphones, or a kind of them."""

    channels: tuple[int, int]  # of microphones 1 and 2, where the configuration does not choose
    device_channels: int
    names: tuple[str, ...] = ()  # parts of the names under which sound systems list it, in lower case
    places: dict[int, Place] = field(default_factory=dict)  # of the raw microphones, by channel; empty: unknown

    def spacing(self, channels: tuple[int, int]) -> float | None:
        """Distance between the microphones on two channels [m]; None when it is not known.

        >>> round(PRESETS["respeaker-usb"].spacing((1, 3)), 4)
        0.064
        """
        first, second = (self.places.get(channel) for channel in channels)
        return None if first is None or second is None else math.dist(first, second)


def square(first: int, half: float) -> dict[int, Place]:
    """Four microphones at the corners of a square, counted around it; ``half`` of a side [m].

    >>> places = square(2, 0.033)
    >>> round(math.dist(places[2], places[3]), 3), round(math.dist(places[2], places[4]), 4)
    (0.066, 0.0933)
    """
    corners = ((half, -half), (half, half), (-half, half), (-half, -half))
    return dict(enumerate(corners, first))


XVF3000_HALF = 0.064 / math.sqrt(8)  # [m]: opposite microphones of the USB array v2.0 are 64 mm apart
HAT_4_HALF = 0.08127 / math.sqrt(8)  # [m]: 81.27 mm, as the maker's program for directions has it
XVF3800_HALF = 0.033  # [m]: as the firmware answers AEC_MIC_ARRAY_GEO

PRESETS = {
    "respeaker-2mic": ArrayPreset((0, 1), 2, ("seeed-2mic", "seeed2mic", "wm8960")),
    "respeaker-4mic": ArrayPreset((0, 1), 4, ("seeed-4mic", "seeed4mic", "ac108"), square(0, HAT_4_HALF)),
    "respeaker-usb": ArrayPreset((1, 2), 6, ("respeaker 4 mic array", "arrayuac10"), square(1, XVF3000_HALF)),
    # XVF3800: conference, ASR, then four raw channels, which are zeros in firmware 6chl v2.0.8
    "respeaker-xvf3800": ArrayPreset((2, 3), 6, ("xvf3800",), square(2, XVF3800_HALF)),
    # its firmwares of two channels, told to give microphones 0 and 1: AUDIO_MGR_OP_L 3 0, AUDIO_MGR_OP_R 3 1
    "respeaker-xvf3800-2ch": ArrayPreset((0, 1), 2, ("xvf3800",), {0: (0.033, -0.033), 1: (0.033, 0.033)}),
    "usb-stereo": ArrayPreset((0, 1), 2),
    "i2s-stereo": ArrayPreset((0, 1), 2, ("googlevoicehat", "i2smic", "i2s-mems")),
}


def fitting(name: str, channels: int = 64) -> str:
    """Return the preset that fits a device of this name and so many channels; empty when none does.

    >>> fitting("ReSpeaker 4 Mic Array (UAC1.0): USB Audio (hw:1,0)")
    'respeaker-usb'
    >>> fitting("reSpeaker XVF3800 4-Mic Array: USB Audio (hw:2,0)", 2)
    'respeaker-xvf3800-2ch'
    """
    words = name.lower()
    there = [key for key, preset in PRESETS.items() if any(part in words for part in preset.names)]
    return next((key for key in there if PRESETS[key].device_channels <= channels), "")
