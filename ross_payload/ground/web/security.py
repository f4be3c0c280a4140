"""Who may open the page: Host and Origin of the request, a token where others can reach it; and TLS."""

from __future__ import annotations

import hashlib
import hmac
import secrets
import ssl
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
PRIVATE = {"Cache-Control": "no-store"}  # what people said, and where they are: browsers and proxies keep no copy
SHORTEST = 16  # characters of a token
TRIES = 5  # wrong tokens from one address before it waits
WAIT = 30.0  # [s]
MAX_ADDRESSES = 1024
_OUT_OF_DATE = {9: "is not valid yet", 10: "has expired"}  # X509_V_ERR_*


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
    """Lets in whoever knows the token; whoever guesses waits."""

    token: str | None  # None: everybody who reaches the page may open it
    wrong: dict[str, tuple[int, float]] = field(default_factory=dict)  # by address: how often, the latest [s]

    @property
    def cookie(self) -> str:
        """What a browser shows after it has shown the token; it is good for as long as the token is."""
        return hmac.new((self.token or "").encode(), b"ross ground", hashlib.sha256).hexdigest()

    def lets_in(self, cookie: str) -> bool:
        """Whether a request with this cookie may pass."""
        return self.token is None or hmac.compare_digest(cookie.encode("utf-8", "replace"), self.cookie.encode())

    def knows(self, token: str) -> bool:
        """Whether a token is right; wrong ones are not counted."""
        return self.token is not None and hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode())

    def waits(self, address: str, now: float) -> float:
        """Return how long [s] an address has to wait before its next try."""
        times, latest = self.wrong.get(address, (0, -WAIT))
        return max(latest + WAIT - now, 0.0) if times >= TRIES else 0.0

    def tried(self, token: str, address: str, now: float) -> bool:
        """Whether a token is right; wrong ones are counted, and a right one is none while its address waits."""
        if self.waits(address, now) or self.token is None:
            return False
        if self.knows(token):
            self.wrong.pop(address, None)
            return True
        times, latest = self.wrong.pop(address, (0, now))
        self.wrong[address] = (1 if now - latest > WAIT else times + 1, now)
        if len(self.wrong) > MAX_ADDRESSES:
            del self.wrong[next(iter(self.wrong))]
        return False


def tls_of(certificate: Path | None, key: Path | None) -> ssl.SSLContext | None:
    """Return what serves with a certificate; None: without one.

    Raises
    ------
    GroundError
        When a file is missing or is none, or when the two do not belong together.
    """
    if certificate is None:
        if key is not None:
            raise GroundError("--key: expected --certificate with it, got none")
        return None
    for name, path in (("--certificate", certificate), ("--key", key or certificate)):
        if not path.is_file():
            raise GroundError(f"{name} {path}: expected a PEM file, got none of that name")
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key, password="")
    except (ssl.SSLError, OSError) as error:
        raise GroundError(_why(certificate, key or certificate, error)) from error
    return context


def out_of_date(context: ssl.SSLContext, certificate: Path) -> str:
    """Return why browsers will not like a certificate's dates, found by shaking hands with it; empty: they will."""
    reader = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    reader.check_hostname = False
    reader.verify_flags |= ssl.VerifyFlags.VERIFY_X509_PARTIAL_CHAIN
    reader.load_verify_locations(certificate)
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    sides = (reader.wrap_bio(back, there), context.wrap_bio(there, back, server_side=True))
    for side in sides * 2:
        try:
            side.do_handshake()
        except ssl.SSLWantReadError:
            continue
        except ssl.SSLCertVerificationError as error:
            return _OUT_OF_DATE.get(error.verify_code, "")
    return ""


def _why(certificate: Path, key: Path, error: OSError) -> str:
    reason = getattr(error, "reason", "") or ""
    if reason == "KEY_VALUES_MISMATCH":
        return f"--key {key}: expected the key of {certificate}, got that of another certificate"
    if isinstance(error, PermissionError):
        return f"{error.filename or key}: may not be read by this user"
    return f"--certificate {certificate}, --key {key}: expected a certificate and its key in PEM, without a password"
