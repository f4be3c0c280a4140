"""What an operator reads: few words about what matters, and not too often."""

from __future__ import annotations

from collections.abc import Callable

from ross_payload import events
from ross_payload.health import AudioHealth, AudioTrouble, RecordingState, RecordingStatus
from ross_payload.token_bucket import TokenBucket
from ross_protocols.angle_text import rotation
from ross_protocols.mavlink.codec import TEXT_SIZE, chunks
from ross_protocols.mavlink.values import Severity, Text

PREFIX = "RoSS: "
SEVERITIES = {
    events.Outcome.TARGET_FOUND: Severity.NOTICE,
    events.Outcome.COMPLETED: Severity.INFO,
    events.Outcome.FAULT: Severity.CRITICAL,
}
BURST = 8  # lines
PERIOD = 2.0  # [s]
LONGEST = 19 * TEXT_SIZE  # characters of a line: 20 parts, which find room on every link and at the ground station
ALWAYS = Severity.ERROR  # this and worse is never held back

Line = tuple[Severity, str]


def line(event: events.Event) -> Line | None:
    """Return what to tell an operator about an event; None: nothing."""
    text: Line | None = None
    match event:
        case events.StateChanged(state=events.State.LEAD_IN):
            text = Severity.INFO, "mission started"
        case events.NoiseMeasured(level_db=None):
            text = Severity.WARNING, "no quiet lead-in: the noise level is unknown"
        case events.SourcesEstimated(informed=True):
            text = Severity.INFO, f"using {_count(event.estimate.k, 'known source')}, not exploring"
        case events.SourcesEstimated(final=True):
            found = f"{_count(event.estimate.k, 'source')} found after {_count(event.rotations, 'turn')}"
            text = Severity.INFO, found
        case events.SourcesReconsidered(dropped=(_, *_)):
            text = Severity.NOTICE, f"{_count(len(event.dropped), 'source')} dropped: most probably nobody"
        case events.AlignmentPlanned():
            text = Severity.INFO, f"{_count(len(event.candidates), 'heading')} to try"
        case events.Checked(accepted=int(group)):
            text = Severity.NOTICE, f"target recognised: {_who(event.groups[group])}"
        case events.ScoreDropped():
            lost = f"target lost, score {event.value:.1f} below {event.criterion:.1f}"
            rival = f"source {event.other} may be the target, score {event.criterion:.1f} beside {event.value:.1f}"
            text = Severity.WARNING, lost if event.other is None else rival
        case events.Slipped():
            text = Severity.WARNING, f"all azimuths shifted by {rotation(event.shift, 0)}: the array has slipped"
        case events.ArrayContradicted():
            text = Severity.WARNING, f"array: {contradicted(event)}: ross calibrate"
        case events.Doubted():
            text = Severity.WARNING, f"exploring after all: {event.reason}"
        case events.Finished():
            text = SEVERITIES.get(event.outcome, Severity.WARNING), f"mission over: {event.reason}"
    return text


def contradicted(event: events.ArrayContradicted) -> str:
    """Say what of the array is not as it is configured.

    >>> contradicted(events.ArrayContradicted(9.0, spacing=0.064, configured=0.05, gain_db=-2.0, inverted=False))
    'spacing seems 64 mm, not 50, microphone 2 is 2.0 dB softer'
    """
    parts = []
    if event.inverted:
        parts.append("polarity of one microphone is reversed")
    if event.fixed:
        parts.append("what it hears turns with it, as interference and its own noise do")
    if event.delay is not None:
        late = 1 if event.delay > 0 else 2
        parts.append(f"microphone {late} seems about {1e6 * abs(event.delay):.0f} us late at all headings")
    if event.spacing is not None:
        parts.append(f"spacing seems {1e3 * event.spacing:.0f} mm, not {1e3 * event.configured:.0f}")
    if event.roll_off is not None:
        higher = 1 if event.roll_off < 0 else 2
        parts.append(f"microphone {higher} rolls off about {abs(event.roll_off):.0f} Hz higher")
    if event.gain_db is not None:
        parts.append(f"microphone 2 is {abs(event.gain_db):.1f} dB {'louder' if event.gain_db > 0 else 'softer'}")
    return ", ".join(parts)


def microphone_text(before: AudioHealth, now: AudioHealth) -> Line | None:
    """Return what to tell an operator about the microphones; None: nothing has changed."""
    if now.trouble == before.trouble:
        return None
    if not now.trouble:
        return Severity.NOTICE, "microphones recovered"
    names = (trouble.name or "" for trouble in AudioTrouble if trouble and trouble in now.trouble)
    return Severity.WARNING, f"microphones: {', '.join(name.lower().replace('_', ' ') for name in names)}"


def recorder_text(before: RecordingStatus, now: RecordingStatus) -> Line | None:
    """Return what to tell an operator about the recorder; None: nothing has changed."""
    if now.state is before.state:
        return None
    if now.state in (RecordingState.FULL, RecordingState.BROKEN):
        return Severity.WARNING, f"recording stopped: {now.reason}"
    if now.state is RecordingState.ON:
        return Severity.INFO, f"recording to {now.path}" if now.path else f"recording {now.name}"
    return Severity.INFO, f"recorded {now.seconds:.0f} s to {now.path}" if now.path else "recording ended"


def _who(group: events.GroupScore) -> str:
    who = " or ".join(str(member) for member in group.members) or "unknown"
    return f"source {who}, score {group.value:.1f}"


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"


def operator_texts() -> TokenBucket:
    """Return how many lines an operator reads at once and in the long run."""
    return TokenBucket(BURST, 1 / PERIOD)


def may_say(bucket: TokenBucket, severity: Severity, now: float) -> bool:
    """Tell whether a line may go out at ``now`` [s]; errors always may."""
    return severity <= ALWAYS or bucket.spend(now)


class OperatorTexts:
    """Puts lines into words that fit, not too many at once, and hands them on."""

    def __init__(self, give: Callable[[list[Text]], None], now: Callable[[], float]) -> None:
        self._give = give
        self._now = now
        self._bucket = operator_texts()
        self._count = 0

    def send(self, severity: Severity, text: str) -> None:
        """Say a line, its beginning where it is too long, unless there were too many of late."""
        if may_say(self._bucket, severity, self._now()):
            self._count += 1
            whole = PREFIX + text
            shown = whole if len(whole) <= LONGEST else whole[: LONGEST - 3] + "..."
            self._give(chunks(severity, shown, self._count % 65535 + 1))
