"""What `make release` refuses, and that it leaves what was there; the whole of it is a long test."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

import ross_payload

ROOT = Path(__file__).parents[2]
DATED = f"# Changelog\n\n## Unreleased\n\nNothing yet.\n\n## {ross_payload.__version__} - 2026-11-23\n\n- A thing.\n"


def git(folder, *arguments):
    who = ("-c", "user.name=Ross", "-c", "user.email=ross@example.org")
    subprocess.run(["git", *who, "-C", folder, *arguments], check=True, capture_output=True)


@pytest.fixture
def checkout(tmp_path):
    folder = tmp_path / "checkout"
    (folder / "ross_payload").mkdir(parents=True)
    (folder / "ross_payload" / "__init__.py").write_text(f'__version__ = "{ross_payload.__version__}"\n')
    (folder / "CHANGELOG.md").write_text(DATED)
    git(folder.parent, "init", "--quiet", folder)
    commit(folder)
    return folder


def commit(folder):
    git(folder, "add", "--all")
    git(folder, "commit", "--quiet", "--message", "ross: Change something")


def release(folder):
    command = [sys.executable, ROOT / ".ci" / "release.py", folder]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=900)


def refused(folder):
    done = release(folder)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    return done.stderr


def test_a_file_that_is_not_committed(checkout):
    (checkout / "more.py").write_text("")
    assert refused(checkout) == "expected every file committed, got 1 that are not, such as 'more.py'\n"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (("Nothing yet.", "- Another thing."), "got some under Unreleased"),
        ((" - 2026-11-23", ""), f"got '## {ross_payload.__version__}'"),
        ((ross_payload.__version__, "0.0.9"), "got '## 0.0.9 - 2026-11-23'"),
        ((DATED, "# Changelog\n"), "as the newest version, got none"),
    ],
)
def test_a_changelog_that_is_not_that_of_the_version(checkout, wrong, words):
    (checkout / "CHANGELOG.md").write_text(DATED.replace(*wrong))
    commit(checkout)
    assert words in refused(checkout)


def test_a_step_that_fails_leaves_what_was_built_before(checkout):
    dist = checkout / "dist"
    dist.mkdir()
    (dist / "ross_payload-0.0.9.tar.gz").write_text("before")
    (checkout / ".gitignore").write_text("dist\n")
    commit(checkout)  # there is no pyproject.toml
    done = release(checkout)
    assert done.returncode == 1
    assert re.search(r"-m build --outdir ended with exit code \d+\n$", done.stderr)
    assert [path.name for path in dist.iterdir()] == ["ross_payload-0.0.9.tar.gz"]


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.skipif(importlib.util.find_spec("venv") is None, reason="needs apt package python3-venv")
def test_the_whole_of_it(tmp_path):
    """From a clone whose changelog is dated."""
    folder = tmp_path / "clone"
    subprocess.run(["git", "clone", "--quiet", ROOT, folder], check=True)
    changelog = (folder / "CHANGELOG.md").read_text()
    (folder / "CHANGELOG.md").write_text(re.sub(r"## Unreleased\n.*?(?=\n## )", "", changelog, flags=re.DOTALL))
    commit(folder)
    subprocess.run(["make", "release"], cwd=folder, check=True, timeout=1800)
    names = {path.name for path in (folder / "dist").iterdir()}
    version = ross_payload.__version__
    assert names == {
        f"ross_payload-{version}-py3-none-any.whl",
        f"ross_payload-{version}.tar.gz",
        f"ross_payload-{version}.cdx.json",
        "SHA256SUMS",
    }
    subprocess.run(["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=folder / "dist", check=True)
