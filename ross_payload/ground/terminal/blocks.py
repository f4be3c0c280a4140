"""The view of a payload as blocks of text lines, each from one or two sections of its view."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from rich.text import Text

from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.view import view as view_of
from ross_payload.ground.terminal.polar_plot import colour, letter
from ross_protocols.angle_text import frame, rounded

SILENT_S = 2.5  # without a message, from which a payload is lost
LEAST_RATE_DEG_S, LEAST_SILENCE_S = 0.5, 1.0  # that are told of a tracked source
BARS = " ▁▂▃▄▅▆▇█"
PLAIN_BARS = " .:-=+*%#"
MARKS = {"good": ("ok ", "green"), "watch": ("!  ", "yellow"), "act": ("!! ", "bold red"), "unknown": ("?  ", "dim")}
FATES = {"done": "green", "refused": "bold red", "failed": "bold red", "no_answer": "yellow", "cancelled": "yellow"}
View = dict[str, Any]


def direction(degrees: float | None, unit: str = "") -> str:
    """Write a direction [deg] that may not be known, from 0 to 359.9.

    >>> direction(359.97, " deg"), direction(None, " deg")
    ('0.0 deg', '-')
    """
    return number(None if degrees is None else rounded(degrees), ".1f", unit)


def number(value: float | None, form: str, unit: str = "") -> str:
    """Write a number that may not be known.

    >>> number(3.14159, ".1f", " s"), number(None, ".1f", " s")
    ('3.1 s', '-')
    """
    return "-" if value is None else f"{value:{form}}{unit}"


def last_heard(last: float, now: float) -> Text:
    """Say how long ago a payload was heard of."""
    age = max(now - last, 0.0)
    if age > SILENT_S:
        return Text(f"NO TELEMETRY FOR {age:.0f} s", "bold red")
    return Text(f"last telemetry {age:.1f} s ago", "green")


def head(view: View, now: float) -> list[Text]:
    """Say who it is and what it does."""
    standing = view["standing"]
    ended = f" ({standing['outcome'].replace('_', ' ')})" if standing["outcome"] else ""
    state = (standing["state"] or "state unknown").replace("_", " ").upper() + ended
    line = Text(f"RoSS {standing['who']}  ", "bold")
    line.append(state, "bold red" if standing["state"] == "fault" else "bold yellow")
    if standing["streaming"]:
        line.append("  LISTENED TO", "bold magenta")
    if standing["recording"]:
        line.append("  RECORDING", "bold magenta")
    line.append("  ").append_text(last_heard(standing["last"], now))
    line.append(f"  {standing['state_meaning']}", "dim")
    return [line]


def strip(view: View) -> list[Text]:
    """The mission and where the axis points, each on a line."""
    mission, pointing = view["mission"], view["pointing"]
    expected = f" of about {mission['expected']:.0f} s" if mission.get("expected") else ""
    score, criterion = mission["score"], mission.get("criterion")
    wanted = "" if score is None or criterion is None else f" {'>' if score > criterion else '<='} {criterion:.2f}"
    parts = [
        f"{number(mission.get('elapsed'), '.1f', ' s')}{expected}",
        f"orientation {number(mission.get('rotation'), 'd')} of {number(mission.get('rotation_max'), 'd')}",
        f"K {number(mission['k'], 'd')}{' final' if mission.get('certain') else ''}",
        f"target {number(mission['target'], 'd')}",
        f"score {number(score, '.2f')}{wanted}",
        f"SI-SDR {number(mission.get('si_sdr'), '.1f', ' dB')}",
    ]
    goal = "" if pointing["goal"] is None else f" turning to {direction(pointing['goal'])} deg"
    where = f"axis {direction(pointing['heading'], ' deg')}{goal}, {frame(pointing['earth'])}"
    joint, gain = number(pointing.get("joint"), "+.1f", " deg"), number(mission.get("gain"), "+.1f", " dB")
    return [Text("  ".join(parts)), Text(f"{where}  joint {joint}  gain {gain}")]


def sources(view: View, *, chosen: int | None) -> list[Text]:
    """The table of sources."""
    rows = [Text("source azimuth mirror   +-  conf  score", "underline")]
    for each in view["sources"]:
        mark = "*" if each["target"] else " "
        line = Text(f"{'>' if each['source'] == chosen else ' '}", "bold")
        line.append(f"{each['source']:>3}{mark}", f"bold {colour(each['source'])}")
        line.append(
            f" {direction(each['azimuth']):>7} {direction(each['mirror']):>6} {number(each['sigma'], '.1f'):>4}"
        )
        line.append(f" {number(each['confidence'], '.2f'):>5} {number(each['score'], '.2f'):>6}{_motion(each)}")
        rows.append(line)
    if not view["sources"]:
        rows.append(Text(" none yet", "dim"))
    announced = max((each["announced"] for each in view["sources"]), default=0)
    if announced > len(view["sources"]):
        rows.insert(1, Text(f" {announced} announced, {len(view['sources'])} received", "yellow"))
    return rows


def _motion(source: View) -> str:
    """Say how fast a tracked source moves, and for how long it has been silent."""
    rate, age = source["rate"] or 0.0, source["age"] or 0.0
    moving = f"  {rate:+.0f} deg/s" if abs(rate) >= LEAST_RATE_DEG_S else ""
    return moving + (f"  silent {age:.0f} s" if age >= LEAST_SILENCE_S else "")


def plan(view: View) -> list[Text]:
    """The table of alignment candidates."""
    candidates = view["plan"]["candidates"]
    if not candidates:
        return []
    rows = [Text("heading  isolates  aliased   us    gain  state", "underline")]
    for each in candidates:
        aliased = "+".join(map(str, each["aliased"])) or "-"
        now = each["candidate"] == view["plan"]["current"]
        line = Text(f"{letter(each['candidate'])} {direction(each['heading']):>5}  {each['source']:>8}  {aliased:<6}")
        line.append(
            f" {each['isolation_us']:5.0f}  {number(each['gain'], '+.1f'):>6}  {each['state']} ({each['rule']})"
        )
        line.stylize("bold blue" if now else "dim" if each["state"] == "rejected" else "")
        rows.append(line)
    return rows


def groups(view: View) -> list[Text]:
    """The latest separation."""
    if not view["groups"]:
        return []
    first = view["groups"][0]
    rows = [Text(f"separated ({first['phase']}, {first['method']})  score  SI-SDR", "underline")]
    for each in view["groups"]:
        members = "+".join(map(str, each["members"])) or "unknown"
        line = Text(f" {members:<24} {number(each['score'], '.2f'):>6} {number(each['si_sdr'], '.1f', ' dB'):>8}")
        line.append("  target" if each["target"] else "  accepted" if each["accepted"] else "", "green")
        rows.append(line)
    return rows


def streams(view: View) -> list[Text]:
    """One line per stream of live listening."""
    rows = []
    for each in view["streams"]:
        mark, style = MARKS[each["level"]]
        way = ", ".join(filter(None, (each["sink"], each["codec"], f"{each['rate']} Hz")))
        line = Text(mark, style).append(f"stream {each['number']:<5} ", "")
        line.append(f"{each['whom']} to {each['place']} ({way}): {each['words']}{_audible(each)}", style)
        rows.append(line if each["on"] or each["fault"] else Text(line.plain, "dim"))
    return rows


def _audible(stream: View) -> str:
    """Level, delay and losses of a stream that is on."""
    if not stream["on"]:
        return ""
    parts = [number(stream["level_db"], ".0f", " dB") if stream["level_db"] is not None else ""]
    parts.append(f"{1e3 * stream['delay']:.0f} ms" if stream["delay"] is not None else "")
    parts.append(f"{stream['lost']} samples lost" if stream["lost"] else "")
    parts.append(f"{stream['packets_lost']} packets lost" if stream["packets_lost"] else "")
    return "".join(f", {part}" for part in parts if part)


def health(view: View) -> list[Text]:
    """One line per part, with its level in a mark and a colour."""
    rows = []
    for name, part in view["health"].items():
        for each in part if isinstance(part, list) else [part]:
            label = name.removesuffix("s") if isinstance(part, list) else name
            mark, style = MARKS[each["level"]]
            rows.append(Text(mark, style).append(f"{label:<12} ", "").append(f"{each['words']}{_details(each)}", style))
    return rows


def _details(part: dict[str, Any]) -> str:
    details = [part["url"]] if "url" in part else []
    if "level_db" in part:
        details.append("/".join(f"{level:.0f}" for level in part["level_db"]) + " dB")
    if part.get("error") is not None:
        details.append(f"{part['error']:.1f} deg to goal")
    if part.get("temperature") is not None:
        details.append(f"{part['temperature']:.0f} degC")
    if part.get("loads"):
        details.append(f"load {max(part['loads']):.0%}")
    if part.get("duration"):
        details.append(f"{part['duration']:.0f} s")
    return f" ({', '.join(details)})" if details else ""


def links(states: Sequence[Any]) -> list[Text]:
    """Our own ends of the links; each a `LinkState`."""
    rows = []
    for each in states:
        mark, style = MARKS["good" if each.up else "act"]
        lost = "loss unknown" if each.lost is None else f"{each.lost} lost"
        words = f"{each.bytes_s / 1e3:.1f} kB/s, {each.frames_s:.0f} frames/s, {lost}, {each.bad} bad"
        rows.append(Text(mark, style).append(f"link {each.url} ").append(words if each.up else each.error or "", style))
    return rows


def curves(view: View, width: int, *, braille: bool) -> list[Text]:
    """What each orientation heard, and how well each heading isolates a source; for screens with room."""
    rows: list[Text] = []
    wide = max(min(width - 20, 80), 8)  # beside a label and a number
    if view["densities"]:
        first = view["densities"][0]
        span = f"{first['first_us']:.0f} to {first['last_us']:.0f} us"
        rows.append(Text(f"ITD density of each orientation, {span}", "underline"))
        rows += [
            _curve(f"{direction(each['heading']):>5} deg", each["density"], wide, braille) for each in view["densities"]
        ]
    if view["isolation"]:
        first = view["isolation"][0]
        span = f"headings {first['first']:.0f} to {first['last']:.0f} deg"
        rows.append(Text(f"isolation of each source, {span}", "underline"))
        for each in view["isolation"]:
            line = _curve(f"source {each['source']:>2}", each["isolation"], wide, braille)
            line.stylize(colour(each["source"]))
            rows.append(line.append(f" {each['maximum_us']:.0f} us"))
    return rows + _history(view, wide, braille=braille)


def _history(view: View, wide: int, *, braille: bool) -> list[Text]:
    """K and score over time, the latest at the right."""
    rows = []
    for label, name in (("K", "k"), ("score", "score")):
        values = [each[name] or 0.0 for each in view["history"]][-wide:]
        lower, upper = min(values, default=0.0), max(values, default=0.0)
        if upper > lower:
            rows.append(_curve(label, [(value - lower) / (upper - lower) for value in values], wide, braille))
            rows[-1].append(f" {lower:.3g} to {upper:.3g}")
    return [Text("over time", "underline"), *rows] if rows else []


def _curve(label: str, shares: Sequence[float], wide: int, braille: bool) -> Text:
    bars = BARS if braille else PLAIN_BARS
    return Text(
        f"{label:>10} " + "".join(bars[round(8 * min(max(share, 0.0), 1.0))] for share in _spread(shares, wide))
    )


def _spread(shares: Sequence[float], wide: int) -> list[float]:
    """Return the largest share of each of ``wide`` equal parts, or fewer."""
    wide = min(wide, len(shares))
    edges = [index * len(shares) // wide for index in range(wide + 1)]
    return [max(shares[start:end]) for start, end in pairwise(edges)]


def events(view: View, now: float, room: int) -> list[Text]:
    """The latest texts, newest last."""
    if room <= 0:
        return []
    rows = []
    for each in view["events"][-room:]:
        style = "bold red" if each["severity"] <= 3 else "yellow" if each["severity"] == 4 else ""
        rows.append(Text(f"{max(now - each['at'], 0.0):6.0f} s ago  {each['text'].removeprefix('RoSS: ')}", style))
    return rows


def orders(doings: Sequence[Any], room: int) -> list[Text]:
    """What was ordered and what became of it, newest last; each a `CommandStatus`."""
    rows = []
    for each in doings[-room:] if room > 0 else []:
        share = "" if each.progress is None or each.state != "in_progress" else f" {each.progress:.0%}"
        reason = f": {clean(each.reason)}" if each.reason else ""
        line = Text(f"{each.who} {each.words}: ")
        rows.append(line.append(f"{each.state.replace('_', ' ')}{share}{reason}", FATES.get(each.state, "cyan")))
    return rows


def clean(section: Any) -> Any:
    r"""Return plain JSON in which no text can move a cursor or change a terminal.

    >>> clean({"text": "RoSS: \x1b[2J", "k": [3]})
    {'text': 'RoSS: ?[2J', 'k': [3]}
    """
    if isinstance(section, str):
        return section if section.isprintable() else "".join(c if c.isprintable() else "?" for c in section)
    if isinstance(section, dict):
        return {key: clean(value) for key, value in section.items()}
    return [clean(value) for value in section] if isinstance(section, list) else section


def safe_view(known: PayloadState) -> View:
    """Return the sections of a payload's view, as they can be shown in a terminal."""
    made: View = clean(view_of(known))
    return made
