"""Build what is published into ``dist``: wheel, sdist, bill of materials, checksums; refuse what is not ready.

``python .ci/release.py [CHECKOUT]`` (``make release``). The version is that of ``ross_payload/__init__.py``; the
changelog must date it and hold nothing unreleased, and every file must be committed. The wheel is installed into an
empty environment, where it flies a mission and serves its page. ``dist`` is replaced when all of that is done, else it
stays as it was. Exit codes: 0 built, 2 not ready, with one line that says what was expected; 1 a step failed.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any
from urllib.request import urlopen

EXTRAS = "sim,ground,stream"  # of the environment in which it is tried: those of `make demo`
ASSET = re.compile(r'(?:src|href)="([^"]+)"')
FOREIGN = re.compile(r"^(?:https?:)?//")


class NotReady(Exception):
    """What was expected, and what was got."""


class StepFailed(Exception):
    """Which step, and how."""


def main(checkout: Path) -> int:
    """Check, build, try, and replace ``dist``; return the exit code."""
    try:
        version = ready(checkout)
    except NotReady as reason:
        print(reason, file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        try:
            made = build(checkout, folder / "dist")
            python = install(checkout, made, folder / "environment")
            fly(python, folder)
            serve(python, folder)
            describe(python, folder / "dist" / f"ross_payload-{version}.cdx.json")
        except StepFailed as reason:
            print(reason, file=sys.stderr)
            return 1
        sums(folder / "dist")
        publish(folder / "dist", checkout / "dist")
    print(f"{version}: {', '.join(sorted(path.name for path in (checkout / 'dist').iterdir()))}")
    return 0


def ready(checkout: Path) -> str:
    """Return the version of a checkout that may be released.

    Raises
    ------
    NotReady
        When files are not committed, or the changelog does not date the version or has unreleased entries.
    """
    changed = run("git", "-C", checkout, "status", "--porcelain").splitlines()
    if changed:
        raise NotReady(f"expected every file committed, got {len(changed)} that are not, such as '{changed[0][3:]}'")
    found = re.search(r'^__version__ = "(.+)"$', (checkout / "ross_payload" / "__init__.py").read_text(), re.M)
    if found is None:
        raise NotReady("expected __version__ in ross_payload/__init__.py, got none")
    version = found[1]
    sections = re.findall(r"^## (.+)\n((?:(?!## ).*\n?)*)", (checkout / "CHANGELOG.md").read_text(), re.M)
    unreleased = "".join(text for title, text in sections if title == "Unreleased")
    if re.search(r"^- ", unreleased, re.M):
        raise NotReady(f"CHANGELOG.md: expected the entries under {version} and its date, got some under Unreleased")
    titles = [title for title, _ in sections if title != "Unreleased"]
    if not titles or not re.fullmatch(rf"{re.escape(version)} - \d{{4}}-\d\d-\d\d", titles[0]):
        got = f"'## {titles[0]}'" if titles else "none"
        raise NotReady(f"CHANGELOG.md: expected '## {version} - YEAR-MONTH-DAY' as the newest version, got {got}")
    return version


def build(checkout: Path, folder: Path) -> Path:
    """Build wheel and sdist, the same bytes for the same commit; return the wheel."""
    epoch = run("git", "-C", checkout, "log", "-1", "--format=%ct").strip()
    environment = os.environ | {"SOURCE_DATE_EPOCH": epoch}
    run(sys.executable, "-m", "build", "--outdir", folder, checkout, env=environment)
    run(sys.executable, "-m", "twine", "check", "--strict", *folder.iterdir())
    return next(folder.glob("*.whl"))


def install(checkout: Path, wheel: Path, folder: Path) -> Path:
    """Install a wheel into an empty environment; return its interpreter."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    pip = (python, "-m", "pip", "--disable-pip-version-check", "--quiet")
    run(*pip, "install", "--constraint", checkout / "constraints.txt", f"{wheel}[{EXTRAS}]")
    run(*pip, "check")
    return python


def fly(python: Path, folder: Path) -> None:
    """Fly a mission away from the checkout; its exit code is 0 when the target was found."""
    run(python.with_name("ross"), "sitl", "--scenario", "one-talker", "--out", folder / "flight", cwd=folder)


def serve(python: Path, folder: Path) -> None:
    """Fetch the page and all that it names from the installed ground station; nothing of it may lie elsewhere."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        link = f"udpin:127.0.0.1:{probe.getsockname()[1]}"
    command = (python.with_name("ross"), "ground", link, "--port", "0")
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as ground:
        try:
            line = ground.stdout.readline() if ground.stdout else ""
            address = re.search(r"(https?://[^/\s]+)\S*", line)
            if address is None:
                raise StepFailed(f"ross ground: expected the address of its page, got '{line.strip()}'")
            with urlopen(address[0]) as page:  # noqa: S310  loopback
                named = ASSET.findall(page.read().decode())
            elsewhere = [name for name in named if FOREIGN.match(name)]
            if elsewhere or not named:
                raise StepFailed(f"ross ground: expected a page of its own parts, got {elsewhere or 'none'}")
            for name in named:
                urlopen(address[1] + name).close()  # noqa: S310  loopback
        except OSError as error:
            raise StepFailed(f"ross ground: {error}") from error
        finally:
            ground.terminate()


def describe(python: Path, path: Path) -> None:
    """Write the bill of materials of an environment, as CycloneDX."""
    run(sys.executable, "-m", "cyclonedx_py", "environment", "--output-reproducible", "-o", path, python)


def sums(folder: Path) -> None:
    """Write ``SHA256SUMS`` of a folder, as `sha256sum --check` reads it."""
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in sorted(folder.iterdir())]
    (folder / "SHA256SUMS").write_text("".join(lines))


def publish(made: Path, dist: Path) -> None:
    """Put a folder in place of another one, which is kept until the new one is there."""
    new = dist.with_name("dist.new")
    shutil.rmtree(new, ignore_errors=True)
    shutil.copytree(made, new)
    shutil.rmtree(dist, ignore_errors=True)
    new.rename(dist)


def run(*command: object, **options: Any) -> str:
    """Run a command to its end and return what it printed; a failed one shows it.

    Raises
    ------
    StepFailed
        When its exit code is not 0.
    """
    words = list(map(str, command))
    done = subprocess.run(words, capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        sys.stderr.write(done.stdout + done.stderr)
        raise StepFailed(f"{' '.join(words[:4])} ended with exit code {done.returncode}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()))
