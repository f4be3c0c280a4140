"""Who may order: one browser at a time; whoever wants may take it, and all see it at once."""

from __future__ import annotations

GRACE = 10.0  # [s] that control waits for a browser that went, to come back


class Control:
    """Holds the id of the browser that orders; ``version`` grows with every change.

    >>> control = Control()
    >>> control.may_order("a1", "chrome"), control.may_order("b2", "firefox"), control.name
    (True, False, 'chrome')
    """

    def __init__(self) -> None:
        self.holder: str | None = None
        self.name: str | None = None
        self.version = 1
        self._gone: float | None = None  # since when the holder is not there [s]

    def may_order(self, browser: str, name: str) -> bool:
        """Whether a browser may order; it takes control when nobody has it."""
        if self.holder is None:
            self.take(browser, name)
        return self.holder == browser

    def take(self, browser: str, name: str) -> None:
        """Give control to a browser, whoever had it."""
        self._set(browser, name)

    def give_up(self, browser: str) -> None:
        """Free control when this browser has it."""
        if self.holder == browser:
            self._set(None, None)

    def went(self, browser: str, now: float) -> None:
        """Notice that a browser is not there any more."""
        if self.holder == browser:
            self._gone = now

    def came(self, browser: str) -> None:
        """Notice that a browser is there again."""
        if self.holder == browser:
            self._gone = None

    def tick(self, now: float) -> None:
        """Free control when its holder has been away for too long."""
        if self._gone is not None and now - self._gone > GRACE:
            self._set(None, None)

    def _set(self, browser: str | None, name: str | None) -> None:
        self.holder, self.name, self._gone = browser, name, None
        self.version += 1
