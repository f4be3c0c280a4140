"""What can go wrong on the ground side, each as one clear line.

::

    GroundError                  only the user can mend it: a URL, a file, a key (the commands exit with code 2)
    +-- NoPayload                no payload to talk to
    +-- UnknownParameter         the payload has no parameter of that name; also a KeyError
    +-- RequestError             what was asked of a payload has not been done
        +-- RefusedByPayload     it was refused, and ``reason`` says why
        +-- TaskFailed           it was begun, and could not be completed
        +-- TaskCancelled        a cancel, a stop or another command ended it
        +-- LinkLost             no answer, or none that says how it ended
"""

from __future__ import annotations

from collections.abc import Sequence

import click


class GroundError(click.ClickException):
    """Something that only the user can mend; its message says what was found and what was wanted."""

    exit_code = 2


class NoPayload(GroundError):
    """None was received, or not the one that was wanted, or several and none was named.

    Attributes
    ----------
    received
        The ids of the payloads that were received, such as ``1-191``.
    """

    def __init__(self, message: str, received: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.received = tuple(received)


class UnknownParameter(GroundError, KeyError):
    """The payload has no parameter of that name."""


class RequestError(GroundError):
    """What was asked of a payload has not been done.

    Attributes
    ----------
    request
        What was asked for, such as ``turn to 10 deg``.
    reason
        Why it was not done: the payload's own words, where it sent any.
    """

    outcome = "was not done"

    def __init__(self, request: str, reason: str) -> None:
        super().__init__(f"{request} {self.outcome}: {reason}")
        self.request = request
        self.reason = reason


class RefusedByPayload(RequestError):
    """The payload did not accept it."""

    outcome = "was refused"


class TaskFailed(RequestError):
    """It was begun and could not be completed."""

    outcome = "failed"


class TaskCancelled(RequestError):
    """A cancel, a stop or another command ended it."""

    outcome = "was cancelled"


class LinkLost(RequestError):
    """No answer came, or none that says how it ended: the payload may have done it nevertheless."""

    outcome = "was not answered"
