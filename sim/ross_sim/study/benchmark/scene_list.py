"""The scenes of the benchmark: who speaks where, and where the array points, in three small files of text.

``rooms.csv`` says how many layouts every room has, ``layouts.csv`` what they are, ``recordings.csv`` who speaks. All
rooms have the same layouts. `python -m ross_sim.study.benchmark.scene_list FOLDER` draws rooms and layouts for the
recordings of a folder, and other ones for another seed; those of this package are what it makes with the default, and
stay as they are whatever becomes of the code. With `--describe SPEECH` it first writes ``recordings.csv`` itself, about
the first recording that is long enough of every reader in ``SPEECH``, which is laid out as LibriSpeech is or flat:
READER-CHAPTER-NUMBER, or any name.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from ross_payload.atomic_files import write_whole
from ross_payload.errors import ConfigError, refused_as, unknown
from ross_sim.study.benchmark.recordings import RATE, Recording, one_of_each_reader
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.scenes.mixtures import aligned_heading, spread
from ross_sim.study.scenes.room_settings import FAR, HIGH, LOW, NEAR, SETTINGS
from ross_sim.study.script_errors import told_in_a_line

HERE = Path(__file__).parent
CORPUS = "LibriSpeech"
SEED = 2016
SECONDS = 10.0  # of a mixture
SHORTEST = round(SECONDS * RATE)  # samples of a recording
COUNTS = (3, 4, 5)  # K
ALIGNED, RANDOM, TURNING = "aligned", "random", "turning"  # orientation of the array
FILES = ("rooms.csv", "layouts.csv", "recordings.csv")
QUICK_K, QUICK_LAYOUTS = 3, 2


@dataclass(frozen=True, slots=True)
class RoomLine:
    """How many layouts of every K a room has: to separate, and to localize."""

    room: str
    separation: int
    localization: int


ROOMS = (
    RoomLine("S1", 20, 20),
    RoomLine("S2", 20, 20),
    RoomLine("S3", 20, 20),
    RoomLine("A0.45", 40, 40),
    RoomLine("B0.45", 40, 40),
    RoomLine("A0.7", 40, 0),
)


@dataclass(frozen=True, slots=True)
class Layout:
    """Who speaks where; lists have one entry for every talker."""

    layout: str
    k: int
    target: int  # index in the lists
    talkers: tuple[str, ...]  # utterances
    starts: tuple[int, ...]  # first sample of the 10 s that are heard in a mixture
    azimuths_deg: tuple[float, ...]  # counter-clockwise
    distances_m: tuple[float, ...]  # along the floor, in true rooms
    heights_m: tuple[float, ...]  # of the mouths, in true rooms
    aligned_deg: float  # heading aligned for the target by the paper's rule
    random_deg: float  # any heading; a turn begins there, too
    seed: int  # of the noise


@dataclass(frozen=True, slots=True)
class BenchmarkScene:
    """One layout in one room with one orientation of the array."""

    room: str
    layout: Layout
    orientation: str

    @property
    def name(self) -> str:
        """What its folder is called.

        >>> layout = Layout("k3-07", 3, 0, (), (), (), (), (), 0.0, 0.0, 0)
        >>> BenchmarkScene("A0.45", layout, ALIGNED).name
        'A0.45-k3-07-aligned'
        """
        return f"{self.room}-{self.layout.layout}-{self.orientation}"

    @property
    def heading_deg(self) -> float:
        """Where the array points, or begins to turn [deg]."""
        return self.layout.aligned_deg if self.orientation == ALIGNED else self.layout.random_deg


@dataclass(frozen=True, slots=True)
class SceneList:
    """Everything that a benchmark consists of."""

    rooms: tuple[RoomLine, ...]
    layouts: tuple[Layout, ...]
    recordings: tuple[Recording, ...]
    fingerprint: str  # of the files

    def scenes(self, quick: bool = False) -> tuple[BenchmarkScene, ...]:
        """All scenes, or a few of them: K = 3, two layouts in every room."""
        return tuple(self._scenes(quick))

    def _scenes(self, quick: bool) -> Iterator[BenchmarkScene]:
        for line in self.rooms:
            for k in sorted({layout.k for layout in self.layouts}):
                if quick and k != QUICK_K:
                    continue
                some = [layout for layout in self.layouts if layout.k == k]
                most = QUICK_LAYOUTS if quick else len(some)
                for orientations, n in (((ALIGNED, RANDOM), line.separation), ((TURNING,), line.localization)):
                    for layout in some[: min(n, most)]:
                        yield from (BenchmarkScene(line.room, layout, orientation) for orientation in orientations)


def read_list(folder: Path | None = None) -> SceneList:
    """Read the scenes of a folder, None: of this package.

    Raises
    ------
    ConfigError
        When a file cannot be read, or names something that there is not; says what.
    """
    folder = folder or HERE
    rooms, layouts, recordings = (
        tuple(read_rows(folder / name, [kind])[1])
        for name, kind in zip(FILES, (RoomLine, Layout, Recording), strict=True)
    )
    digest = hashlib.sha256(b"".join((folder / name).read_bytes() for name in FILES))
    scenes = SceneList(rooms, layouts, recordings, digest.hexdigest())
    _check(folder, scenes)
    return scenes


def _check(folder: Path, scenes: SceneList) -> None:
    known = {recording.utterance: recording for recording in scenes.recordings}
    for line in scenes.rooms:
        if line.room not in SETTINGS:
            raise ConfigError(f"{folder / FILES[0]}: {unknown('room', line.room, SETTINGS)}")
    for layout in scenes.layouts:
        lists = (layout.talkers, layout.starts, layout.azimuths_deg, layout.distances_m, layout.heights_m)
        where = f"{folder / FILES[1]}: {layout.layout}"
        if {len(each) for each in lists} != {layout.k} or not 0 <= layout.target < layout.k:
            raise ConfigError(f"{where}: expected lists of {layout.k} and a target among them")
        for talker, start in zip(layout.talkers, layout.starts, strict=True):
            if talker not in known:
                raise ConfigError(f"{where}: {unknown('utterance', talker, known)}")
            last = known[talker].samples - SHORTEST
            if not 0 <= start <= last:
                raise ConfigError(f"{where}: expected a start from 0 to {last} in {talker}, got {start}")


def drawn(recordings: Sequence[Recording], rooms: Sequence[RoomLine] = ROOMS, seed: int = SEED) -> tuple[Layout, ...]:
    """Draw the layouts that the rooms need; azimuths are at least 25 deg apart."""
    most = max(max(line.separation, line.localization) for line in rooms)
    return tuple(_drawn(k, n, recordings, seed) for k in COUNTS if k <= len(recordings) for n in range(most))


def _drawn(k: int, n: int, recordings: Sequence[Recording], seed: int) -> Layout:
    rng = np.random.default_rng([seed, k, n])
    chosen = [recordings[int(i)] for i in rng.permutation(len(recordings))[:k]]
    azimuths = np.round(np.rad2deg(spread(k, rng)), 2)
    target = int(rng.integers(k))
    return Layout(
        f"k{k}-{n:02d}",
        k,
        target,
        tuple(recording.utterance for recording in chosen),
        tuple(int(rng.integers(recording.samples - SHORTEST + 1)) for recording in chosen),
        tuple(azimuths.tolist()),
        tuple(rng.uniform(NEAR, FAR, k).round(3).tolist()),
        tuple(rng.uniform(LOW, HIGH, k).round(3).tolist()),
        round(float(np.rad2deg(aligned_heading(np.deg2rad(azimuths), target))), 2),
        round(float(rng.uniform(-180.0, 180.0)), 2),
        1000 * k + n,
    )


def write_list(folder: Path, rooms: Sequence[RoomLine] = ROOMS, seed: int = SEED) -> None:
    """Draw rooms and layouts for the recordings of a folder, and write them beside those.

    Raises
    ------
    ConfigError
        When there are too few recordings for a scene, or one is too short; says what was expected.
    """
    path = folder / FILES[2]
    recordings = read_rows(path, [Recording])[1]
    for recording in recordings:
        if recording.samples < SHORTEST:
            raise ConfigError(
                f"{path}: {recording.utterance}: expected at least {SHORTEST} samples, got {recording.samples}"
            )
    _expect_enough(path, recordings)
    with refused_as(ConfigError, f"{folder}: cannot be written"):
        write_whole(folder / FILES[0], as_csv(rooms, RoomLine))
        write_whole(folder / FILES[1], as_csv(drawn(recordings, rooms, seed), Layout))


def describe(folder: Path, speech: Path, corpus: str, licence: str) -> None:
    """Write ``recordings.csv`` of a folder, about one recording of every reader in ``speech``.

    Raises
    ------
    ConfigError
        When a recording does not fit, or the file is there or cannot be written.
    """
    of_the_corpus = {"corpus": corpus, "subset": speech.resolve().name, "licence": licence, "sex": ""}
    path = folder / FILES[2]
    if path.exists():
        raise ConfigError(f"{path}: is there already; remove it, or leave out --describe")
    recordings = one_of_each_reader(speech, SHORTEST, **of_the_corpus)
    _expect_enough(speech, recordings)
    with refused_as(ConfigError, f"{folder}: cannot be written"):
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, as_csv(recordings, Recording))


def _expect_enough(path: Path, recordings: Sequence[Recording]) -> None:
    if len(recordings) < min(COUNTS):
        raise ConfigError(f"{path}: expected at least {min(COUNTS)} recordings, got {len(recordings)}")


@click.command(help=__doc__)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option(
    "--describe", "speech", type=click.Path(path_type=Path), help="Folder of recordings, 16 kHz, one channel."
)
@click.option("--corpus", show_default=CORPUS, help="What --describe says they are of.")
@click.option("--licence", help="What --describe says they are under, such as 'CC BY 4.0'.")
@click.option("--seed", type=click.IntRange(0), default=SEED, show_default=True, help="Of the layouts.")
def main(folder: Path, speech: Path | None, corpus: str | None, licence: str | None, seed: int) -> None:
    """Draw rooms and layouts for the recordings of FOLDER."""
    with told_in_a_line():
        if speech is not None:
            if not licence:
                raise ConfigError("--describe: expected --licence, too: that of the recordings")
            describe(folder, speech, corpus or CORPUS, licence)
        elif corpus is not None or licence is not None:
            raise ConfigError("--corpus and --licence: expected --describe, too: they are of what it writes")
        write_list(folder, seed=seed)


if __name__ == "__main__":
    main()
