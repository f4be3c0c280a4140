"""The ``ross`` command; a user's mistake gets one clear line and exit code 2."""

from __future__ import annotations

import atexit
import errno
import os
import signal
import sys
from pathlib import Path
from typing import Any

import click

from ross_payload import __version__, plugins
from ross_payload.bounded_files import printable
from ross_payload.end_signals import Interrupter, end_signals
from ross_payload.errors import UNWRITABLE, ActuatorError, OutputError, PluginError, RossError, near, reason
from ross_payload.program_end import STANDARD_ERROR, ending

COMMANDS = "ross_payload.commands"
LONGEST = 1500  # line about a mistake [characters]: a file may hold a name of a megabyte
OF_UNIX = ("fcntl", "grp", "pty", "pwd", "resource", "termios", "tty")  # modules that Python lacks elsewhere
EXIT_CODES = "Exit codes: 0 target found, 3 no target, 2 bad input, 1 fault, 130 stopped by the user."


class _WithPlugins(click.Group):
    """Own commands, and those that other packages bring by entry point; a broken one does not hurt another."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            raise click.UsageError(f"No such command '{args[0]}'{near(args[0], self.list_commands(ctx))}") from error

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted({*super().list_commands(ctx), *plugins.available(COMMANDS)})

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        own = super().get_command(ctx, name)
        if own is not None or name not in plugins.available(COMMANDS):
            return own
        try:
            command: click.Command = plugins.load(COMMANDS, name)
        except PluginError as error:
            return _broken(name, str(error))
        return command


def _broken(name: str, why: str) -> click.Command:
    def fail(**_: Any) -> None:
        raise PluginError(why)

    rest = click.Argument(["rest"], nargs=-1, type=click.UNPROCESSED)
    settings = {"ignore_unknown_options": True}
    return click.Command(name, callback=fail, params=[rest], short_help="(cannot be loaded)", context_settings=settings)


@click.group(cls=_WithPlugins, epilog=EXIT_CODES, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="ross")
def ross() -> None:
    """Hear several talkers, turn until interferers have the same delay, and separate the target voice."""


@ross.group()
def config() -> None:
    """Look at configuration files."""


@config.command("check")
@click.argument("file", type=click.Path(path_type=Path))
def check(file: Path) -> None:
    """Check a payload's TOML FILE: what `ross run` refuses before it opens a device is refused in the same words."""
    from ross_payload.service.check import loaded
    from ross_payload.service.state_folder import recording_path, unusable_recordings

    why = unusable_recordings(recording_path(loaded(file)))
    click.echo(f"{file}: good")
    if why:  # it may be there in flight: a stick that is not plugged in, another computer, the service's user
        click.echo(f"note: {why}; you could record nothing there")


@config.command("show")
@click.argument("file", type=click.Path(path_type=Path))
def show(file: Path) -> None:
    """Show every key of a payload's TOML FILE as it is in force, and why: file, default, or set in flight."""
    from ross_payload.config import load
    from ross_payload.config.parameter_listing import listing
    from ross_payload.service.check import check_settable
    from ross_payload.service.state_folder import state_path

    loaded = load(file)
    for line in listing(loaded, state_path(loaded) / "params.toml", check_settable):
        click.echo(line)


@ross.command(short_help="Make or delete the voice print of NAME.")
@click.argument("name")
@click.argument("file", metavar="[AUDIO]", type=click.Path(path_type=Path), required=False)
@click.option("--forget", is_flag=True, help="Delete the voice print of NAME instead.")
@click.option("--model", default="auto", help="As [voice_print] model of the payload; see ross voice-model.")
def enroll(name: str, file: Path | None, forget: bool, model: str) -> None:
    """Make the voice print of NAME from a file of AUDIO with a few seconds of clean speech, two minutes at most.

    A voice print is personal data: it is kept on this computer only, readable by you alone, until you --forget it.
    """
    from ross_payload.audio.audio_files import read_mono
    from ross_payload.voiceprint import VoiceStore, enrol
    from ross_payload.voiceprint.model_folder import ModelFolder
    from ross_payload.voiceprint.speaker_model import LONGEST as LONGEST_SPEECH

    store = VoiceStore.default()
    if forget and file is not None:
        raise click.UsageError(f"AUDIO: expected none with --forget, got {file}")
    if forget:
        store.forget(name)
        click.echo(f"forgot {name}")
        return
    if file is None:
        raise click.UsageError("AUDIO: expected an audio file with a few seconds of speech, got none")
    voice, rate, goes_on = read_mono(file, LONGEST_SPEECH)
    if goes_on:
        click.echo(printable(f"{file}: the first {LONGEST_SPEECH:g} s are used, the rest is left out"), err=True)
    store.save(name, enrol(voice, rate, ModelFolder.default().in_use(model)))
    click.echo(f"enrolled {name}; 'ross enroll {name} --forget' deletes the voice print")


def main() -> None:
    """Run the command line; a user's mistake gets one line and exit code 2."""
    interrupter = Interrupter()
    for number in end_signals():  # the same clean end as Ctrl-C, also while setting up
        signal.signal(number, interrupter)
    atexit.register(_hear_no_more)
    _occupy_closed_streams()
    code, why = 1, ""
    try:
        code, why = _outcome(interrupter)
    finally:
        with ending(code):
            if why:
                _complain(why)
    sys.exit(code)


def _hear_no_more() -> None:
    """Ignore signals to end from now on: Python's own end gives them back to the system, which ends with their code."""
    for number in end_signals():
        signal.signal(number, signal.SIG_IGN)


def _outcome(interrupter: Interrupter) -> tuple[int, str]:
    """Run the command; return the exit code, and what there is to complain of."""
    output = sys.stdout
    try:
        code, why = ross.main(standalone_mode=False), ""
    except click.exceptions.NoArgsIsHelpError as error:  # `ross` alone, or `ross config`: what it says is the help
        error.show()
        code, why = error.exit_code, ""
    except click.ClickException as error:
        code, why = error.exit_code, error.format_message()
    except (click.Abort, KeyboardInterrupt):
        code, why = 130, "interrupted"
    except (ActuatorError, OutputError) as error:
        code, why = 1, str(error)
    except RossError as error:
        code, why = 2, str(error)
    except ModuleNotFoundError as error:
        code, why = 2, _lacking(error)
    except (SystemExit, MemoryError) as error:
        unread = sys.stdout is not output  # click has put another in its place, and asks Python to exit
        code, why = 1, "" if unread else _end_in_words(error)
    except BrokenPipeError:
        code, why = 1, ""
    except OSError as error:
        code, why = 1 if error.filename is None else 2, _unusable(error)
    except Exception as error:
        if isinstance(error, RuntimeError) and "start new thread" in str(error):
            return 1, f"the system refuses another thread: {error}"
        if interrupter.caught is None:
            raise
        code, why = 130, "interrupted"  # pydantic and others raise their own instead of a KeyboardInterrupt
    return code if isinstance(code, int) else 0, why


def _occupy_closed_streams() -> None:
    """Have nothing that is opened later become standard input, output or error, to which libraries write as well."""
    while (handle := os.open(os.devnull, os.O_RDWR)) <= STANDARD_ERROR:
        os.set_inheritable(handle, True)
    os.close(handle)
    sys.stdin = sys.stdin or Path(os.devnull).open(encoding="utf-8")  # noqa: SIM115 - until the program ends
    sys.stdout = sys.stdout or Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 - until the program ends
    sys.stderr = sys.stderr or Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115


def _end_in_words(error: SystemExit | MemoryError) -> str:
    """Say what ended a command; we raise no SystemExit in one, and its code would be taken for that of a mission."""
    if isinstance(error, MemoryError):
        return f"out of memory: {error}".rstrip(": ")
    if isinstance(error.__context__, BrokenPipeError) or _unread():  # rich, and click, make one of that
        return ""
    return f"ended by a plug-in or a library, which asked Python to exit with {error.code!r}"


def _unread() -> bool:
    """Whether click has replaced standard output because its reader has gone; its SystemExit has no context then."""
    return type(sys.stdout).__module__.partition(".")[0] == "click"


def _lacking(error: ModuleNotFoundError) -> str:
    """Say which extra, or system, brings what a command needs; raise the error again when none does."""
    from ross_payload.plugins import EXTRA_OF, install_line

    package = (error.name or "").partition(".")[0]
    if package in OF_UNIX:
        return f"this command needs Linux: Python has no module {package} on {sys.platform}"
    if package not in EXTRA_OF:
        raise error
    return f"this command needs the package {package}: {install_line(EXTRA_OF[package])}"


def _unusable(error: OSError) -> str:
    """Say which file cannot be used, and why; one without a name is the output. Anything else is raised again."""
    if error.filename is None and error.errno in UNWRITABLE:
        return f"the output cannot be written: {reason(error)}"
    if not isinstance(error.filename, str | bytes):
        raise error
    verb = {errno.EACCES: "used", **dict.fromkeys(UNWRITABLE, "written")}.get(error.errno or 0, "read")
    return f"{os.fsdecode(error.filename)}: cannot be {verb}: {reason(error)}"


def _complain(text: str) -> None:
    """Say what is wrong in one line, whatever stands in the file or argument that it quotes."""
    shown = printable(text)
    click.echo(f"ross: {shown if len(shown) <= LONGEST else shown[: LONGEST - 3] + '...'}", err=True)


if __name__ == "__main__":
    main()
