"""What is wrong when nothing, or too little, is heard: in words, with what to do about it."""

from __future__ import annotations

from collections.abc import Sequence

from ross_payload.ground.links.link import LinkState
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.transport.link_url import LOOPBACK, Serial, Tcp, Udp, parse
from ross_protocols.mavlink.vehicle import AUTOPILOT

DIAGNOSIS_DELAY_S = 5.0  # [s] before something is said of what is missing
SILENT_AFTER_S = 10.0  # [s] after which a payload counts as silent
LOOPBACKS = (LOOPBACK, "localhost", "::1")
NO_KEY = "the payload signs its messages, and accepts commands only from stations with its key (--mavlink-key)"
SAME_KEY = "both sides need the same key, and clocks that agree within a minute"
TUNNEL = 'behind ArduPilot, set role = "autopilot" in the [[links]] table of the payload'


def advice(
    links: Sequence[LinkState],
    payloads: Sequence[PayloadState],
    now: float,
    began: float,
    key: bool,
    *,
    delay: float = DIAGNOSIS_DELAY_S,
) -> str:
    """Return what is wrong with what is heard at ``now`` [s] since the station ``began``; empty: all is well.

    ``key`` tells whether the station signs; before ``delay`` [s] are over nothing is missed.
    """
    unkeyed = [f"{link.url}: {NO_KEY}" for link in links if link.signed and not key]
    if now - began < delay:
        return "; ".join(unkeyed) if payloads else "waiting for telemetry on " + ", ".join(link.url for link in links)
    heard = [known for known in payloads if now - known.last < SILENT_AFTER_S]
    if heard:
        terse = [one for one in heard if one.mirrors and one.status is None and now - one.first > SILENT_AFTER_S]
        return "; ".join(unkeyed + [f"only summary values arrive from {one.who}: {TUNNEL}" for one in terse])
    return "; ".join(_of_link(link, now, began) for link in links)


def _of_link(link: LinkState, now: float, began: float) -> str:
    if link.frames_s:
        return _of_others(link)
    if link.bytes_s and link.refused:
        return f"{link.url}: messages are unsigned, signed with another key, or a minute old: {SAME_KEY}"
    if link.bytes_s:
        return f"{link.url}: receiving {link.bytes_s:.0f} bytes/s, but no MAVLink: {_other_noise(link.url)}"
    if link.error:
        return f"{link.url}: {link.error}: {_remedy(link)}"
    if link.last is not None:
        return f"nothing received on {link.url} for {now - link.last:.0f} s: {_vanished(link.url)}"
    return f"nothing received on {link.url} for {now - began:.0f} s: {_wanted(link.url)}"


def _of_others(link: LinkState) -> str:
    names = ", ".join(f"{who} (an autopilot)" if who.component == AUTOPILOT else str(who) for who in link.senders)
    flies = any(who.component == AUTOPILOT for who in link.senders)
    tunnel = f" {TUNNEL};" if flies else ""
    damaged = (
        f" {link.bad} frames have a wrong checksum: does it use another version of the dialect?" if link.bad else ""
    )
    return f"{link.url}: receiving {names}, but no payload: is it on?{tunnel}{damaged}".rstrip(";")


def _vanished(url: str) -> str:
    match parse(url):
        case Serial():
            return "check that the radio is in range and the payload is on"
        case _:
            return "check that the payload is on and the network is up"


def _other_noise(url: str) -> str:
    match parse(url):
        case Serial(device=device):
            return f"the baud rate may differ, try serial:{device}:auto"
        case _:
            return "another program is sending there"


def _remedy(link: LinkState) -> str:
    match parse(link.url):
        case Serial():
            return "check ls -l /dev/serial/by-id, and join the group dialout if access is denied; retrying"
        case Tcp(port=port) | Udp(port=port):
            return f"check that the other side is on, and the host and port {port} (nc -zv, ping); retrying"


def _any(host: str) -> str:
    """All addresses of a computer, of the kind that ``host`` is."""
    return "[::]" if ":" in host else "0.0.0.0"  # noqa: S104  what to type, not what is listened on


def _wanted(url: str) -> str:
    match parse(url):
        case Udp(listen=True, host=host, port=port):
            near = f"; for payloads on other computers listen on udpin:{_any(host)}:{port}" if host in LOOPBACKS else ""
            return f'the [[links]] of the payload need url = "udpout:HOST:{port}" where HOST is this computer{near}; \
check with tcpdump -ni any udp port {port}'
        case Tcp(listen=True, host=host, port=port):
            near = f"; for payloads on other computers listen on tcpin:{_any(host)}:{port}" if host in LOOPBACKS else ""
            return f'the [[links]] of the payload need url = "tcp:HOST:{port}" where HOST is this computer{near}; \
check with ss -tn'
        case Udp(host=host, port=port):
            wanted = f"udpin:{_any(host)}:{port}"
            return f'the [[links]] of the payload need url = "{wanted}"; check with ping and ross doctor'
        case Tcp():
            return "connected, but the other side sends nothing: is it the right port?"
        case Serial(device=device):
            return f"check the wires (RX to TX) and the baud rate; serial:{device}:auto tries all rates"
