"""What a user of the ground side did wrong, or what is wrong around it: one clear line and exit code 2."""

from __future__ import annotations

import click


class GroundError(click.ClickException):
    """Something that only the user can mend; its message says what was found and what was wanted."""

    exit_code = 2
