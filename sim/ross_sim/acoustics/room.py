"""Rooms by the image method (pyroomacoustics): what two omnidirectional microphones hear at any heading."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples

Real = NDArray[np.floating[Any]]

PYROOMACOUSTICS = version("pyroomacoustics")  # needed here; imported when a room is computed, which takes a second
CLEARANCE = 0.2  # [m], nearest a source may come to the centre of the array
WALL = 0.01  # [m], nearest anything may come to a wall
MOST_IMAGES = (
    50_000_000  # of one source: each takes 250 bytes while a room is computed, and 60 for every further source
)
SPEED_OF_SOUND = 343.0  # [m/s]
SINC = 81  # taps of a fractional delay; every response starts SINC // 2 samples late
_ONE_AT_A_TIME = threading.Lock()  # a room that is kept has one array, and the library's constants are everybody's


@dataclass(frozen=True, slots=True)
class RoomSpec:
    """A shoebox, the array in it and who stands where.

    Raises
    ------
    ConfigError
        When something lies outside the room or on top of the array, or a number is impossible.
    """

    size: tuple[float, ...]  # [m], two numbers (a plane, as in the paper) or three
    t60: float  # nominal reverberation time [s]; 0: no walls
    rate: int  # [Hz]
    array_centre: tuple[float, ...]  # [m]
    spacing: float  # d [m]
    sources: tuple[tuple[float, ...], ...]  # [m], one position per source
    speed_of_sound: float = SPEED_OF_SOUND  # v_p [m/s]

    def __post_init__(self) -> None:
        """Check everything before any of it is simulated."""
        _check_numbers(self)
        _check_places(self)
        _walls(self)


def respond(spec: RoomSpec, headings: Sequence[float]) -> Samples:
    """Impulse responses from every source to both microphones at every heading, (n_headings, 2, n_sources, n_taps).

    The axis from microphone 1 to microphone 2 points along the heading h [rad]: with u = (cos h, sin h), microphone 1
    is at centre - d/2 u and microphone 2 at centre + d/2 u. The absorption of the walls comes from the nominal T60 by
    Sabine's formula (in its two-dimensional form for a plane); all images that arrive within T60 count and nothing
    later. With T60 = 0 only the direct path does. Every response starts 40 samples late: half a fractional delay
    filter.

    A source 2 m ahead on the axis is 0.343 m nearer to microphone 2, which is 16 samples at 16 kHz:

    >>> response = respond(RoomSpec((10, 10), 0.0, 16000, (5, 5), 0.343, ((7, 5),)), [0.0])
    >>> response.shape[:3]
    (1, 2, 1)
    >>> first, second = np.abs(response[0, :, 0]).argmax(axis=-1)
    >>> int(first - second)
    16
    """
    n_sources = len(spec.sources)
    if not n_sources or not len(headings):
        return np.zeros((len(headings), 2, n_sources, n_taps(spec)), dtype=np.float32)
    with _ONE_AT_A_TIME, _single_thread(spec.t60 > 0):
        room = _room_with_images(spec)
        _hear_at(room, microphones(spec, headings))
        room.compute_rir()
        heard, room.rir = room.rir, None
    taps = n_taps(spec)
    padded = np.zeros((2 * len(headings), n_sources, taps), dtype=np.float32)
    for row, responses in zip(padded, heard, strict=True):
        for out, response in zip(row, responses, strict=True):
            out[: min(taps, len(response))] = response[:taps]
    return padded.reshape(len(headings), 2, n_sources, taps)


def n_taps(spec: RoomSpec) -> int:
    """Length of every response of a room: T60, or the longest direct path, and a fractional delay filter."""
    reach = max((math.dist(source, spec.array_centre) for source in spec.sources), default=0.0) + spec.spacing / 2
    return math.ceil(max(spec.t60, reach / spec.speed_of_sound) * spec.rate) + SINC + 2


def microphones(spec: RoomSpec, headings: Sequence[float]) -> Real:
    """Positions of both microphones at every heading, (dim, 2 n_headings), microphones side by side.

    >>> spec = RoomSpec((4, 4), 0.0, 16000, (2, 2), 0.1, ())
    >>> microphones(spec, [0.0, np.pi / 2]).round(3).T.tolist()
    [[1.95, 2.0], [2.05, 2.0], [2.0, 1.95], [2.0, 2.05]]
    """
    along = np.zeros((len(headings), 1, len(spec.size)))
    along[:, 0, 0], along[:, 0, 1] = np.cos(headings), np.sin(headings)
    ends = np.asarray(spec.array_centre) + np.array([[-0.5], [0.5]]) * spec.spacing * along
    return np.asarray(ends.reshape(-1, len(spec.size)).T)


@lru_cache(maxsize=2)  # talkers, and what sounds beside them; an image takes 16 bytes, a large room has a million
def _room_with_images(spec: RoomSpec) -> Any:
    """A room with the images of its sources, which do not depend on where the microphones are."""
    import pyroomacoustics as pra  # noqa: PLC0415

    absorption, order = _walls(spec)
    room = pra.ShoeBox(list(spec.size), fs=spec.rate, materials=pra.Material(absorption), max_order=order)
    room.set_sound_speed(spec.speed_of_sound)
    room.add_microphone(list(spec.array_centre))
    for source in spec.sources:
        room.add_source(list(source))
    try:
        room.image_source_model()
    except MemoryError as error:
        raise ConfigError(
            f"t60 = {spec.t60:g} s in a room of {_text(spec.size)} m: its reflections do not fit into the memory; "
            "use a shorter T60 or a larger room"
        ) from error
    for source in room.sources:  # what is of use to directive sources alone
        source.orders = source.orders_xyz = source.walls = source.generators = None
    return room


def _hear_at(room: Any, places: Real) -> None:
    """Put microphones, (dim, n_microphones), in a room whose images are known: all are seen from everywhere."""
    import pyroomacoustics as pra  # noqa: PLC0415

    room.mic_array = pra.MicrophoneArray(places, room.fs)
    n_microphones = places.shape[1]
    room.visibility = [np.ones((n_microphones, source.images.shape[1]), dtype=bool) for source in room.sources]
    for source in room.sources:
        source.directions = np.broadcast_to(np.float32(0), (n_microphones, *source.images.shape))


def _walls(spec: RoomSpec) -> tuple[float, int]:
    """Absorption of the walls, and the order of reflections up to which images count."""
    if spec.t60 <= 0:
        return 1.0, 0
    import pyroomacoustics as pra  # noqa: PLC0415

    try:
        absorption, order = pra.inverse_sabine(spec.t60, list(spec.size), c=spec.speed_of_sound)
    except ValueError as error:
        raise ConfigError(
            f"t60 = {spec.t60:g} s is too short for a room of {_text(spec.size)} m: even walls that absorb "
            "everything would ring longer by Sabine's formula; use a longer T60, a smaller room, or 0 for no walls"
        ) from error
    images = n_images(max(order, 0), len(spec.size))
    if images > MOST_IMAGES:
        raise ConfigError(
            f"t60 = {spec.t60:g} s is too long for a room of {_text(spec.size)} m: expected at most "
            f"{MOST_IMAGES / 1e6:g} million reflections, got {images / 1e6:.1f}; use a shorter T60 or a larger room"
        )
    return float(absorption), max(order, 0)


def n_images(order: int, dimensions: int) -> int:
    """How many images of a source a shoebox has up to an order, the source among them: points of a grid (Allen, 1979).

    In a plane one source, and four more at the next order:

    >>> n_images(0, 2), n_images(1, 2), n_images(1, 3)
    (1, 5, 7)
    """
    if dimensions == 2:
        return 2 * order * (order + 1) + 1
    return (2 * order + 1) * (2 * order * (order + 1) + 3) // 3


@contextmanager
def _single_thread(high_pass: bool) -> Iterator[None]:
    """One thread, so that sums are formed in one order; the library's constants are put back."""
    import pyroomacoustics as pra  # noqa: PLC0415

    wanted = {"num_threads": 1, "rir_hpf_enable": high_pass, "frac_delay_length": SINC}
    before = {name: pra.constants.get(name) for name in wanted}
    try:
        for name, value in wanted.items():
            pra.constants.set(name, value)
        yield
    finally:
        for name, value in before.items():
            pra.constants.set(name, value)


def _check_numbers(spec: RoomSpec) -> None:
    if len(spec.size) not in (2, 3) or not all(0 < side < math.inf for side in spec.size):
        raise ConfigError(f"room: expected two or three positive sides [m], got {_text(spec.size)}")
    for name, value, lowest in (("t60", spec.t60, 0.0), ("speed_of_sound", spec.speed_of_sound, 1.0)):
        if not lowest <= value < math.inf:
            raise ConfigError(f"{name}: expected at least {lowest:g}, got {value:g}")
    if spec.rate <= 0:
        raise ConfigError(f"rate: expected a positive rate, got {spec.rate} Hz")
    if not 0 < spec.spacing < 2 * CLEARANCE:
        raise ConfigError(f"spacing: expected more than 0 and less than {2 * CLEARANCE:g} m, got {spec.spacing:g} m")


def _check_places(spec: RoomSpec) -> None:
    reach = np.array([spec.spacing / 2, spec.spacing / 2, 0.0])[: len(spec.size)]
    _check_inside(spec, "the array", spec.array_centre, reach)
    for index, source in enumerate(spec.sources):
        _check_inside(spec, f"source {index}", source, np.zeros(len(spec.size)))
        distance = math.dist(source, spec.array_centre)
        if distance < CLEARANCE:
            raise ConfigError(
                f"source {index}: expected at least {CLEARANCE:g} m from the centre of the array, got {distance:.2f} m"
            )


def _check_inside(spec: RoomSpec, who: str, place: tuple[float, ...], reach: Real) -> None:
    if len(place) != len(spec.size):
        raise ConfigError(f"{who}: expected {len(spec.size)} coordinates, as the room has sides, got {_text(place)} m")
    margin = reach + WALL
    if not bool(np.all((np.asarray(place) >= margin) & (np.asarray(place) <= np.asarray(spec.size) - margin))):
        raise ConfigError(f"{who}: expected a place inside the room of {_text(spec.size)} m, got {_text(place)} m")


def _text(values: Sequence[float]) -> str:
    return " x ".join(f"{value:.3g}" for value in values)
