"""The manual for hosting: of every released version and of the present tree, each in a folder of its own.

``make site`` runs it. Any server of files serves the result; nothing in it asks another host. The address of the site
itself leads to the newest release, or to the present tree, ``main``, while there is none.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

RELEASE = re.compile(r"v(\d+)\.(\d+)\.(\d+)")
PRESENT = "main"
LEAD = """<!doctype html>
<meta charset="utf-8">
<meta http-equiv="refresh" content="0; url={0}/index.html">
<title>Manual</title>
<a href="{0}/index.html">Manual, version {0}</a>
"""


def releases(root: Path) -> list[str]:
    """Return the tags of releases, the newest first."""
    tags = [tag for tag in _git(root, "tag", "--list").split() if RELEASE.fullmatch(tag)]
    return sorted(tags, key=lambda tag: tuple(map(int, RELEASE.fullmatch(tag).groups())), reverse=True)


def build(root: Path, site: Path) -> list[str]:
    """Build every version of the manual of the repository ``root`` into ``site``; return their names."""
    tags = releases(root)
    versions = [*tags, PRESENT]
    for tag in tags:
        with TemporaryDirectory() as folder:
            tree = Path(folder) / tag
            _git(root, "worktree", "add", "--quiet", "--detach", str(tree), tag)
            try:
                _manual(tree, site / tag, versions)
            finally:
                _git(root, "worktree", "remove", "--force", str(tree))
    _manual(root, site / PRESENT, versions)
    (site / "index.html").write_text(LEAD.format(versions[0]), encoding="utf-8")
    return versions


def _manual(tree: Path, pages: Path, versions: list[str]) -> None:
    """Build the manual of a tree with the code of that tree, also where another version is installed."""
    code = os.pathsep.join(str(tree / folder) for folder in (".", "protocols", "sim"))
    told = os.environ | {"PYTHONPATH": code, "ROSS_DOCS_VERSIONS": " ".join(versions)}
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", tree / "docs", pages]
    subprocess.run(command, check=True, env=told)


def _git(root: Path, *arguments: str) -> str:
    return subprocess.run(["git", "-C", root, *arguments], check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    here = Path(__file__).parent
    site = here / "_build" / "site"
    print("\n".join(f"{site / version}" for version in build(here.parent, site)))
