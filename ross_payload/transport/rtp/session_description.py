"""What a stream of RTP is, and its session description (SDP, RFC 8866): written by a sink, read by who listens.

L16 is RFC 3551, Opus RFC 7587. The profile is RTP/AVP: players exist that know no other, and an attribute that they do
not know, such as ``rtcp-fb``, is ignored.
"""

from __future__ import annotations

import ipaddress
import re
from dataclasses import dataclass

from ross_payload.errors import ConfigError, shown
from ross_payload.transport.link_url import MAX_PORT

L16, OPUS = "L16", "opus"
OPUS_CLOCK = 48000  # of the timestamps of Opus, whatever was encoded [Hz], RFC 7587
OPUS_RATES = (8000, 12000, 16000, 24000, 48000)  # that Opus encodes and decodes [Hz]
STATIC_L16 = 11  # payload type of mono L16 at 44.1 kHz, RFC 3551
DYNAMIC_L16, DYNAMIC_OPUS = 96, 111
LARGEST_PAYLOAD = 1400  # of a packet [bytes]: what Ethernet and Wi-Fi carry in one piece
PACKET_S = 0.02  # of sound in a packet, where it fits
LONGEST = 65536  # description that is read [characters]
_MAP = re.compile(r"rtpmap:(\d{1,3}) ([A-Za-z0-9._-]+)/(\d{1,6})(?:/(\d{1,2}))?")
_CAPTURE_RATE = re.compile(r"fmtp:(\d{1,3}) .*sprop-maxcapturerate=(\d{1,6})")


@dataclass(frozen=True, slots=True)
class Media:
    """How one voice is carried.

    >>> Media.of("L16", 44100).payload_type, Media.of("L16", 48000).packet
    (11, 480)
    >>> Media.of("opus", 16000)
    Media(codec='opus', rate=16000, payload_type=111)
    """

    codec: str  # L16 or opus
    rate: int  # of the samples that come out [Hz]
    payload_type: int

    @classmethod
    def of(cls, codec: str, rate: int) -> Media:
        """Return what carries samples of a rate [Hz]; what Opus does not know is carried at 48 kHz."""
        if codec == OPUS:
            return cls(OPUS, rate if rate in OPUS_RATES else OPUS_CLOCK, DYNAMIC_OPUS)
        return cls(L16, rate, STATIC_L16 if rate == 44100 else DYNAMIC_L16)

    @property
    def clock(self) -> int:
        """Rate of the timestamps [Hz]."""
        return OPUS_CLOCK if self.codec == OPUS else self.rate

    @property
    def packet(self) -> int:
        """Samples of a packet at `rate`: 20 ms, of L16 only 10 ms where they would not fit."""
        samples = round(PACKET_S * self.rate)
        return samples // 2 if self.codec == L16 and 2 * samples > LARGEST_PAYLOAD else samples


@dataclass(frozen=True, slots=True)
class Session:
    """Where a stream goes, and what it is."""

    media: Media
    host: str  # that it is sent to, an address
    port: int
    title: str = "voice"
    origin: str = "127.0.0.1"  # who sends it, an address
    number: int = 1  # that tells this session from others of the same origin


def described(session: Session) -> str:
    r"""Return the session description.

    >>> text = described(Session(Media.of("opus", 16000), "192.0.2.7", 5004, "target"))
    >>> print(*text.split("\r\n")[:7], sep="\n")
    v=0
    o=- 1 1 IN IP4 127.0.0.1
    s=target
    c=IN IP4 192.0.2.7
    t=0 0
    m=audio 5004 RTP/AVP 111
    a=rtpmap:111 opus/48000/2
    """
    media, kind = session.media, session.media.payload_type
    lines = [
        "v=0",
        f"o=- {session.number} 1 {_family(session.origin)} {session.origin}",
        f"s={' '.join(session.title.split()) or '-'}",
        f"c={_family(session.host)} {session.host}",
        "t=0 0",
        f"m=audio {session.port} RTP/AVP {kind}",
    ]
    if media.codec == OPUS:  # two channels whatever is encoded, RFC 7587, section 7
        lines += [f"a=rtpmap:{kind} opus/{OPUS_CLOCK}/2"]
        lines += [f"a=fmtp:{kind} stereo=0;sprop-stereo=0;useinbandfec=1;sprop-maxcapturerate={media.rate}"]
    else:
        lines += [f"a=rtpmap:{kind} L16/{media.rate}/1"]
    lines += [f"a=ptime:{1000 * media.packet // media.rate}", "a=rtcp-mux", f"a=rtcp-fb:{kind} nack", ""]
    return "\r\n".join(lines)


def parsed(text: str, where: str) -> Session:
    """Read a session description: its first stream of sound that we can play; ``where`` names it in messages.

    Raises
    ------
    ConfigError
        When there is none; says what was expected.
    """
    lines = [line.strip() for line in text[:LONGEST].splitlines()]
    if not lines or lines[0] != "v=0":
        raise ConfigError(f"{where}: expected a session description (SDP), which begins with v=0")
    host, title, found = "", "voice", None
    attributes: list[str] = []
    for line in lines[1:]:
        kind, _, value = line.partition("=")
        if kind == "s":
            title = value
        elif kind == "c" and len(value.split()) == 3:
            host = value.split()[2].partition("/")[0]
        elif kind == "m" and found is not None:
            break  # the first one is enough
        elif kind == "m" and value.startswith("audio "):
            found = value.split()
        elif kind == "a":
            attributes.append(value)
    if found is None or len(found) < 4 or not found[2].startswith("RTP/AVP"):
        raise ConfigError(f"{where}: expected a line m=audio PORT RTP/AVP TYPE, got {shown(' '.join(found or ()))}")
    port = int(found[1]) if found[1].isascii() and found[1].isdigit() and len(found[1]) < 6 else 0
    if not 1 <= port <= MAX_PORT:
        raise ConfigError(f"{where}: expected a port from 1 to {MAX_PORT}, got {shown(found[1])}")
    return Session(_media(found[3], attributes, where), _checked_address(host, where), port, title)


def _media(kind: str, attributes: list[str], where: str) -> Media:
    if kind == str(STATIC_L16):
        return Media(L16, 44100, STATIC_L16)
    maps = [match.groups() for text in attributes if (match := _MAP.fullmatch(text)) and match[1] == kind]
    rates = [int(match[2]) for text in attributes if (match := _CAPTURE_RATE.match(text)) and match[1] == kind]
    for number, name, rate, channels in maps:
        if name.lower() == OPUS and int(rate) == OPUS_CLOCK:
            wanted = rates[0] if rates and rates[0] in OPUS_RATES else OPUS_CLOCK
            return Media(OPUS, wanted, int(number))
        if name.upper() == L16 and (channels or "1") == "1" and 4000 <= int(rate) <= 192_000:
            return Media(L16, int(rate), int(number))
    got = "/".join(each for each in maps[0][1:] if each) if maps else f"payload type {kind}"
    raise ConfigError(f"{where}: expected opus/48000/2 or L16 with one channel, got {shown(got)}")


def _checked_address(host: str, where: str) -> str:
    try:
        return str(ipaddress.ip_address(host))
    except ValueError as error:
        raise ConfigError(f"{where}: expected a line c=IN IP4 ADDRESS, got {shown(host)}") from error


def _family(host: str) -> str:
    return "IN IP6" if ":" in host else "IN IP4"
