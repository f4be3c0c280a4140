"""A real Chromium for tests of the page.

``browser``     one for all tests of this folder (a package for that reason alone); its driver keeps asyncio from
                the thread, and ends before a test of another folder begins
``profile``     its profile (`browsing.Profile`), one for all tests, which forgets a test when it ends
``board``       draws the instruments alone (`gallery`), for all tests of a file
``crew``        `ross ground` with a payload, for all tests of a file
``window``      the pages of a test (`browsing.Watched`): the test fails when one of them asks another machine for
                something, or complains; a complaint that a test causes goes into ``window.expected``
``keep_page``   opens one that stays for all tests of a file, which ask for ``window``, too: to open a page costs more
                than most tests do in it
``open_page``   opens a page of the window: ``open_page(url, width=..., height=..., scheme="dark")``

No test beside these may use asyncio in its own thread.
"""

import pytest

from browsing import FLAGS, PATIENCE_S, Profile, chromium
from fleet_bench import FleetThread
from gallery import board_of
from served_ground import served


@pytest.fixture(scope="package")
def browser():
    executable = chromium()
    if executable is None:
        pytest.skip("needs a browser: apt-get install chromium-headless-shell (or CHROMIUM=path)")
    from playwright.sync_api import expect, sync_playwright

    expect.set_options(timeout=1000 * PATIENCE_S)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture(scope="package")
def profile(browser):
    return Profile(browser)


@pytest.fixture(scope="module")
def board(profile):
    with board_of(profile) as board:
        yield board


@pytest.fixture(scope="module")
def crew(browser):
    with served() as ground, FleetThread(ground.port):
        yield ground


@pytest.fixture(scope="module")
def keep_page(profile):
    with profile.watched() as watched:

        def kept(url):
            page = watched.new_page()
            page.set_viewport_size({"width": 1280, "height": 800})
            page.emulate_media(color_scheme="light")
            watched.open(page, url)
            return page

        yield kept


@pytest.fixture
def window(profile):
    with profile.watched() as watched:
        yield watched
    assert not watched.strangers, f"asked other machines: {watched.strangers}"
    assert not watched.unexpected(), f"the page complains: {watched.unexpected()}"


@pytest.fixture
def open_page(window):
    def opened(url, *, width=1280, height=800, scheme="light"):
        page = window.new_page()
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=scheme)
        window.open(page, url)
        return page

    return opened
