"""TLS for the page: a certificate and its key, tried before anybody connects."""

from __future__ import annotations

import ssl
from pathlib import Path

from ross_payload.ground.errors import GroundError

_OUT_OF_DATE = {9: "is not valid yet", 10: "has expired"}  # X509_V_ERR_*


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
