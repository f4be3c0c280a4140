"""What is wrong when nothing, or too little, is heard: in words, with what to do about it."""

from __future__ import annotations

from collections.abc import Sequence

from ross_payload.ground.links.link import LinkState
from ross_payload.ground.picture.known import Payload
from ross_protocols.address import LOOPBACK, Serial, Tcp, Udp, parse

PATIENCE = 5.0  # [s] before something is said of what is missing
QUIET = 10.0  # [s] after which a payload counts as silent
AUTOPILOT = 1  # component id
LOOPBACKS = (LOOPBACK, "localhost", "::1")
NO_KEY = "who speaks there signs, and obeys nobody without its key"
SAME_KEY = "both sides need the same key and about the same time"
TUNNEL = 'behind an ArduPilot it needs role = "autopilot" in the [[links]] table of the payload'


def advice(
    links: Sequence[LinkState],
    payloads: Sequence[Payload],
    now: float,
    began: float,
    key: bool,
    *,
    patience: float = PATIENCE,
) -> str:
    """Return what is wrong with what is heard at ``now`` [s] since the station ``began``; empty: all is well.

    ``key`` tells whether the station signs; before ``patience`` [s] are over nothing is missed.
    """
    unkeyed = [f"{link.url}: {NO_KEY}" for link in links if link.signed and not key]
    if now - began < patience:
        return "; ".join(unkeyed) if payloads else "waits for telemetry at " + ", ".join(link.url for link in links)
    heard = [known for known in payloads if now - known.last < QUIET]
    if heard:
        return "; ".join(unkeyed + [_of_mirrors(known) for known in heard if _mirrors_only(known, now)])
    return "; ".join(_of_link(link, now, began) for link in links)


def _mirrors_only(known: Payload, now: float) -> bool:
    """Tell whether a payload had time to say more than its mirrors, and did not."""
    return known.status is None and bool(known.mirrors) and now - known.first > QUIET


def _of_mirrors(known: Payload) -> str:
    return f"of {known.who} only the mirrored values arrive: {TUNNEL}"


def _of_link(link: LinkState, now: float, began: float) -> str:
    if link.frames_s:
        return _of_others(link)
    if link.bytes_s and link.refused:
        return f"{link.url}: what comes is unsigned, signed with another key, or a minute old: {SAME_KEY}"
    if link.bytes_s:
        return f"{link.url}: {link.bytes_s:.0f} bytes/s come and no MAVLink is among them: {_other_noise(link.url)}"
    if link.error:
        return f"{link.url}: {link.error}: {_remedy(link)}"
    if link.last is not None:
        return f"nothing heard at {link.url} for {now - link.last:.0f} s: {_vanished(link.url)}"
    return f"nothing heard at {link.url} for {now - began:.0f} s: {_wanted(link.url)}"


def _of_others(link: LinkState) -> str:
    names = ", ".join(f"{who} (an autopilot)" if who.component == AUTOPILOT else str(who) for who in link.senders)
    flies = any(who.component == AUTOPILOT for who in link.senders)
    tunnel = f" {TUNNEL};" if flies else ""
    damaged = f" {link.bad} frames have a wrong checksum: has it another version of our dialect?" if link.bad else ""
    return f"{link.url}: heard {names}, and no payload: is it on?{tunnel}{damaged}".rstrip(";")


def _vanished(url: str) -> str:
    match parse(url):
        case Serial():
            return "is the radio still in reach, and the payload on?"
        case _:
            return "is the payload still on, and the network there?"


def _other_noise(url: str) -> str:
    match parse(url):
        case Serial(device=device):
            return f"another baud rate? Try serial:{device}:auto"
        case _:
            return "something else talks there"


def _remedy(link: LinkState) -> str:
    match parse(link.url):
        case Serial():
            return "look with ls -l /dev/serial/by-id; who may not open it joins the group dialout; tried again"
        case Tcp(port=port) | Udp(port=port):
            return f"is the other side on, and is it host and port {port}? (nc -zv, ping); tried again"


def _wanted(url: str) -> str:
    match parse(url):
        case Udp(listen=True, host=host, port=port):
            near = f"; payloads elsewhere reach only udpin:0.0.0.0:{port}" if host in LOOPBACKS else ""
            return f'the [[links]] of the payload need url = "udpout:HOST:{port}" with this computer as HOST{near}; \
check with tcpdump -ni any udp port {port}'
        case Tcp(listen=True, host=host, port=port):
            near = f"; payloads elsewhere reach only tcpin:0.0.0.0:{port}" if host in LOOPBACKS else ""
            return f'the [[links]] of the payload need url = "tcp:HOST:{port}" with this computer as HOST{near}; \
check with ss -tn'
        case Udp(port=port):
            return f'the [[links]] of the payload need url = "udpin:0.0.0.0:{port}"; check with ping and ross doctor'
        case Tcp():
            return "connected, and the other side says nothing: is it the right port?"
        case Serial(device=device):
            return f"look at the wires (RX to TX) and the rate; serial:{device}:auto tries them all"
