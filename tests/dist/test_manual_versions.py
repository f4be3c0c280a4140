"""The manual for hosting has a folder for every release, built with the code of that release."""

import importlib.util
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.soak  # what only a release builds
CONF = """
import os
import made
project = "x"
version = made.version
extensions = []
html_theme = "basic"
templates_path = ["_templates"]
html_sidebars = {"**": ["sidebar/variant-selector.html"]}
html_context = {"versions": os.environ["ROSS_DOCS_VERSIONS"].split()}
"""


def site_of_the_manual():
    spec = importlib.util.spec_from_file_location("site_of_the_manual", ROOT / "docs" / "site.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A repository with two releases and a change since, and its site."""
    root, site = tmp_path_factory.mktemp("repository"), tmp_path_factory.mktemp("site")
    who = {f"GIT_{role}_{what}": "a@b.c" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}

    def git(*arguments):
        subprocess.run(["git", "-C", root, *arguments], check=True, env=os.environ | who, capture_output=True)

    git("init", "-q")
    pages = root / "docs"
    shutil.copytree(ROOT / "docs" / "_templates", pages / "_templates")
    (pages / "conf.py").write_text(CONF)
    (pages / "index.rst").write_text("Title\n=====\n\nof |version|\n\n.. toctree::\n\n   deep/page\n")
    (pages / "deep").mkdir()
    (pages / "deep" / "page.rst").write_text("Page\n====\n")
    for version in ("0.9.0", "0.10.0", "next"):
        (root / "made.py").write_text(f'version = "{version}"\n')
        git("add", ".")
        git("commit", "-q", "-m", version)
        if version != "next":
            git("tag", f"v{version}")
    git("tag", "nightly")
    return site, site_of_the_manual().build(root, site)


def test_every_release_and_the_present_tree_have_a_manual_of_their_own_code(site):
    folder, versions = site
    assert versions == ["v0.10.0", "v0.9.0", "main"]
    told = {each: (folder / each / "index.html").read_text() for each in versions}
    assert ["of 0.10.0" in told["v0.10.0"], "of 0.9.0" in told["v0.9.0"], "of next" in told["main"]] == [True] * 3


def test_the_address_leads_to_the_newest_release(site):
    assert "url=v0.10.0/index.html" in (site[0] / "index.html").read_text()


def test_every_page_leads_to_the_other_versions(site):
    folder, versions = site
    for page in ("index.html", "deep/page.html"):
        place = folder / "v0.9.0" / page
        for version in versions:
            link = next(part for part in place.read_text().split('href="') if f"{version}/index.html" in part)
            assert (place.parent / link.partition('"')[0]).resolve() == (folder / version / "index.html").resolve()
