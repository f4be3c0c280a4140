"""A file that can be written no more, for whatever user a test runs as."""

from pathlib import Path


def lose(path: Path) -> None:
    """Put a folder in the place of a file: as on a full disk, nothing that is written takes its place."""
    path.unlink()
    path.mkdir()
    (path / "lost").touch()
