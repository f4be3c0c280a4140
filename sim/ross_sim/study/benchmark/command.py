"""``ross study benchmark``: build the audio of the public benchmark, run a method over it, score estimates."""

from __future__ import annotations

from pathlib import Path

import click

FOLDER = click.Path(path_type=Path)
audio_folder = click.option("--audio", type=FOLDER, required=True, help="Folder that `build` made.")


@click.group("benchmark")
def benchmark() -> None:
    """Compare methods on fixed scenes that anybody can build from LibriSpeech.

    Exit codes: 0 done, 1 the disk is full, 2 bad input, 130 stopped by the user.
    """


@benchmark.command("build")
@click.option("--recordings", type=FOLDER, required=True, help="Folder of LibriSpeech, or with the 15 recordings.")
@click.option("--out", type=FOLDER, required=True, help="Folder of the audio; a build that was stopped goes on.")
@click.option("--list", "lists", type=FOLDER, help="Folder of another list of scenes; default: the benchmark's.")
@click.option("--quick", is_flag=True, help="A few scenes: K = 3, two layouts in every room.")
def build_command(*, recordings: Path, out: Path, lists: Path | None, quick: bool) -> int:
    """Build the audio of every scene, after checking the hash of every recording."""
    from ross_sim.study.benchmark.build_audio import SUMS, build
    from ross_sim.study.benchmark.scene_list import read_list

    scenes = read_list(lists)
    with _Shown(len(scenes.scenes(quick))) as view:
        made = build(scenes, recordings, out, quick=quick, done=view.done)
    if made.mended:
        names = ", ".join(made.mended[:3]) + (", ..." if len(made.mended) > 3 else "")
        click.echo(f"{out}: {len(made.mended)} scenes were not as they had been built, and were built anew: {names}")
    click.echo(f"{out}: {made.scenes} scenes; hashes of all files are in {SUMS}")
    return 0


@benchmark.command("run")
@audio_folder
@click.option("--method", required=True, help="A separator, an explorer, or the oracle irm.")
@click.option("--out", type=FOLDER, required=True, help="Folder of the estimates.")
def run_command(*, audio: Path, method: str, out: Path) -> int:
    """Run a method of ours or a plug-in over the scenes of its task, and write its estimates."""
    from ross_sim.study.benchmark.build_audio import built
    from ross_sim.study.benchmark.methods import run

    with _Shown(len(built(audio))) as view:
        task = run(method, audio, out, view.done)
    click.echo(f"{out}: estimates of {method} for {task}")
    return 0


@benchmark.command("score")
@audio_folder
@click.option("--estimates", type=FOLDER, required=True, help="Folder of SCENE.wav files, azimuths.json, or both.")
@click.option("--name", help="Of the method; default: that of the folder.")
@click.option("--out", type=FOLDER, required=True, help="Folder of rows and tables; those of other methods stay.")
def score_command(*, audio: Path, estimates: Path, name: str | None, out: Path) -> int:
    """Score estimates, whoever made them, and print the tables with all methods of --out."""
    from ross_sim.study.benchmark.score_estimates import kept, score

    for table in kept(score(audio, estimates, name or estimates.resolve().name), out, audio):
        click.echo(table.markdown())
    return 0


class _Shown:
    """How far it is."""

    def __init__(self, total: int) -> None:
        from ross_payload.clock import SystemClock
        from ross_sim.study.runs.study_run import view_of
        from ross_sim.unread_console import UnreadConsole

        self._view = view_of(UnreadConsole("the build"), total, 0, SystemClock().now)

    def __enter__(self) -> _Shown:
        return self

    def done(self, name: str) -> None:
        """One scene is done."""
        self._view.done(name)

    def __exit__(self, *_: object) -> None:
        self._view.close()
