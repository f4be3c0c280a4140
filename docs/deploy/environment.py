#!/usr/bin/python3
"""Make the virtual environment of a payload that a package or an image carries.

    /usr/bin/python3 docs/deploy/environment.py TARGET [--place /opt/ross] [--extras capture,serial] [--wheels DIR]

It holds the wheel of this checkout and the packages of requirements-hashed.txt, each verified by its SHA-256, without
what no payload runs: pip, tests, stubs, other dialects of MAVLink. TARGET is where it is made, the place is where it
will be. With `--wheels` nothing is fetched: that folder must hold the packages, and hatchling, which builds the wheel.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
EXTRAS = "capture,serial,can,gpio,ground"
DIALECTS = ("ardupilotmega.py", "common.py", "__init__.py")  # of pymavlink, version 2; ours is in ross_protocols
STUBS = ("*.pyi", "*.pxd", "*.pyx", "*.h", "*.a")
SMALLEST = (  # without what no part of the payload imports, and a plug-in hardly ever
    "lxml",  # with which pymavlink generates dialects
    "pygments",  # with which rich colours source text
    "pymavlink/dfindexer", "pymavlink/tools", "numpy/distutils",
    *(f"scipy/{name}" for name in ("cluster", "datasets", "differentiate", "fftpack", "io", "misc", "odr")),
)  # fmt: skip
COMMAND = """#!{place}/bin/python
import sys

from ross_payload.cli import main

sys.exit(main())
"""


def main() -> None:
    """Make the environment that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("target", type=Path)
    parser.add_argument("--place", type=Path, help="where it will be (default: where it is made)")
    parser.add_argument("--extras", default=EXTRAS, help=f"default: {EXTRAS}")
    parser.add_argument("--smallest", action="store_true", help="leave out what only a plug-in might import")
    parser.add_argument("--wheels", type=Path, help="folder of wheels to install from (default: they are fetched)")
    asked = parser.parse_args()
    target = asked.target.resolve()
    venv.create(target, clear=True, symlinks=True, with_pip=False)
    with tempfile.TemporaryDirectory() as work:
        install(target, asked.extras, Path(work), asked.wheels)
    site = next(target.glob("lib/python3*/site-packages"))
    prune(site, SMALLEST if asked.smallest else ())
    settle(target, asked.place or target)
    place = asked.place / site.relative_to(target) if asked.place else site
    compiling = Path(__file__).with_name("compile_used.py")
    subprocess.run([target / "bin" / "python", "-I", compiling, site, place], check=True)


def install(target: Path, extras: str, work: Path, wheels: Path | None) -> None:
    """Install the payload and what it needs, from verified files alone."""
    venv.create(work / "tools", with_pip=True)
    pip = [work / "tools" / "bin" / "python", "-m", "pip", "--disable-pip-version-check", "--quiet"]
    offline = [] if wheels is None else ["--no-index", "--find-links", wheels]
    subprocess.run([*pip, "wheel", "--no-deps", *offline, "--wheel-dir", work / "own", SOURCE], check=True)
    hashed = ["--only-binary", ":all:", "--require-hashes", "--requirement", SOURCE / "requirements-hashed.txt"]
    subprocess.run([*pip, "download", *hashed, *offline, "--dest", work / "wheels"], check=True)
    verified = ["--isolated", "--no-index", "--find-links", work / "wheels", "--no-compile"]
    (wheel,) = (work / "own").glob("ross_payload-*.whl")
    inside = ["--python", target / "bin" / "python"]
    subprocess.run([*pip, *inside, "install", *verified, f"{wheel}[{extras}]"], check=True)


def prune(site: Path, also: tuple[str, ...]) -> None:
    """Remove what no payload runs."""
    for folder in [*site.rglob("tests"), *(site / name for name in also)]:
        shutil.rmtree(folder, ignore_errors=True)
    dialects = site / "pymavlink" / "dialects"
    shutil.rmtree(dialects / "v10", ignore_errors=True)
    for path in (dialects / "v20").iterdir():
        if path.name not in DIALECTS:
            path.unlink()
    for pattern in STUBS:
        for path in site.rglob(pattern):
            if not path.relative_to(site).parts[0].startswith("ross_"):  # those are data
                path.unlink()
    for path in site.glob("*.dist-info/direct_url.json"):  # names the folder in which the wheel was
        path.unlink()


def settle(target: Path, place: Path) -> None:
    """Have the command start at its place, and remove scripts that would start elsewhere."""
    for path in (target / "bin").iterdir():
        if not path.name.startswith("python") and path.name != "ross":
            path.unlink()
    (target / "bin" / "ross").write_text(COMMAND.format(place=place))
    settings = target / "pyvenv.cfg"
    kept = [line for line in settings.read_text().splitlines() if not line.startswith("command")]
    settings.write_text("\n".join(kept) + "\n")


if __name__ == "__main__":
    sys.exit(main())
