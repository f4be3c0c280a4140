"""Who may open the page: Host and Origin of the request, and a token where more than this computer can reach it."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import stat
from dataclasses import dataclass, field
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import urlsplit

from ross_payload.ground.errors import GroundError

HEADERS = {
    "Content-Security-Policy": "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
SHORTEST = 16  # characters of a token
TRIES = 5  # wrong tokens from one address before it waits
WAIT = 30.0  # [s]
MOST_ADDRESSES = 1024


def is_loopback(host: str) -> bool:
    """Whether only this computer reaches a host.

    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, True, False)
    """
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def read_token(path: Path) -> str:
    """Read a token from a file that only its owner can read.

    Raises
    ------
    GroundError
        When it cannot be read, others can read it, or it is too short.
    """
    try:
        mode = stat.S_IMODE(path.stat().st_mode)
        token = path.read_text("utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "not a text"
        raise GroundError(f"{path}: {why}; expected a file with a token") from error
    if mode & 0o077:
        raise GroundError(f"{path}: expected mode 0600, got {mode:04o}: chmod 600 {path}")
    if len(token) < SHORTEST or not token.isascii() or not token.isprintable():
        raise GroundError(
            f"{path}: expected a token of at least {SHORTEST} ASCII characters, got {len(token)} characters"
        )
    return token


def new_token() -> str:
    """Return a token that nobody guesses."""
    return secrets.token_urlsafe(24)


def origin_fits(origin: str | None, host: str) -> bool:
    """Whether a request comes from the page that was loaded from the same host; programs say no origin.

    >>> origin_fits("http://127.0.0.1:8765", "127.0.0.1:8765"), origin_fits("http://evil.example", "127.0.0.1:8765")
    (True, False)
    >>> origin_fits("http://[", "127.0.0.1:8765")
    False
    """
    try:
        return origin is None or urlsplit(origin).netloc == host
    except ValueError:
        return False


def host_fits(host: str) -> bool:
    """Whether a Host header names this computer: another name that leads here is an attack (DNS rebinding).

    >>> host_fits("localhost:8765"), host_fits("[::1]:8765"), host_fits("evil.example:8765")
    (True, True, False)
    """
    try:
        return is_loopback(urlsplit(f"//{host}").hostname or "")
    except ValueError:
        return False


def shown(text: str) -> str:
    r"""Return what a stranger has sent as it can stand in an answer of one line.

    >>> shown("evil\r\n\udcff")
    'evil\\r\\n\\udcff'
    """
    return ascii(text)[1:-1][:80]


@dataclass(slots=True)
class Gate:
    """Lets in who knows the token; whoever guesses waits."""

    token: str | None  # None: everybody who reaches the page may open it
    wrong: dict[str, tuple[int, float]] = field(default_factory=dict)  # by address: how often, the latest [s]

    @property
    def cookie(self) -> str:
        """What a browser shows after it has shown the token; it is good for as long as the token is."""
        return hmac.new((self.token or "").encode(), b"ross ground", hashlib.sha256).hexdigest()

    def lets_in(self, cookie: str) -> bool:
        """Whether a request with this cookie may pass."""
        return self.token is None or hmac.compare_digest(cookie.encode("utf-8", "replace"), self.cookie.encode())

    def waits(self, address: str, now: float) -> float:
        """Return how long [s] an address has to wait before its next try."""
        times, latest = self.wrong.get(address, (0, -WAIT))
        return max(latest + WAIT - now, 0.0) if times >= TRIES else 0.0

    def tried(self, token: str, address: str, now: float) -> bool:
        """Whether a token is right; wrong ones are counted, and a right one is none while its address waits."""
        if self.waits(address, now) or self.token is None:
            return False
        if hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode()):
            self.wrong.pop(address, None)
            return True
        times, latest = self.wrong.pop(address, (0, now))
        self.wrong[address] = (1 if now - latest > WAIT else times + 1, now)
        if len(self.wrong) > MOST_ADDRESSES:
            del self.wrong[next(iter(self.wrong))]
        return False
