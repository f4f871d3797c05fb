"""The page in a real Chromium: chosen early, and not let in any more."""

import time

import pytest
from ddh_twin_py.nodes.page_documents import page_document
from ddh_twin_py.rig import load_rig
from support.chromium import Chromium, executable

PILL = "document.querySelector('#link').textContent"

pytestmark = pytest.mark.skipif(executable() is None, reason="there is no Chromium on this machine; scripts/browser.sh installs one")


def test_a_window_that_is_chosen_before_data_come_leaves_the_charts(serve):
    page = serve()
    with Chromium() as browser:
        browser.open(page.url)
        browser.value("document.querySelectorAll('#windows button')[1].click()")
        browser.wait(f"{PILL} !== ''", 30.0)
        page.board.put("page", page_document("/ddh", load_rig()))
        while not page.server.viewers:
            time.sleep(0.01)
        page.server.show()
        browser.wait("document.querySelectorAll('#chart-list > *').length > 0", 30.0)
        assert browser.value("document.querySelector('#windows [aria-pressed=true]').textContent") == "2 min"


def test_after_a_restart_with_another_token_the_page_asks_for_it(serve):
    first = serve(token="old")
    with Chromium() as browser:
        browser.open(first.url)
        browser.wait("document.documentElement.dataset.ready === 'yes'", 60.0)
        first.server.stop()
        browser.wait(f"{PILL} === 'connection lost, trying again'", 30.0)
        serve(token="new", port=first.server.access.port)
        assert "token" in browser.wait(f"{PILL}.includes('needs its token') && {PILL}", 30.0)
