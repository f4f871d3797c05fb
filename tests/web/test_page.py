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


def shown(page, browser, **documents):
    """Show documents of the board to one browser."""
    browser.open(page.url)
    page.board.put("page", page_document("/ddh", load_rig()))
    while not page.server.viewers:
        time.sleep(0.01)
    for name, document in documents.items():
        page.board.put(name, document)
    page.server.show()


def test_a_replay_that_cannot_keep_its_rate_tells_what_it_reaches(serve):
    page = serve()
    player = {"bag": "b", "position": 10.0, "duration": 300.0, "rate": 5.0, "speed": 2.3, "waiting": False, "paused": False, "ended": False,
              "loop": False}
    with Chromium() as browser:
        shown(page, browser, player=player)
        browser.wait("document.querySelector('#position').textContent.includes('of 5:00')", 30.0)
        assert browser.text("#player-note") == "", "it has only begun"
        time.sleep(3.2)
        page.board.put("player", {**player, "position": 20.0})
        page.server.show()
        browser.wait("document.querySelector('#player-note').textContent === '▲ 2.3 × real time, as fast as this computer can'", 30.0)
        page.board.put("player", {**player, "paused": True})
        page.server.show()
        browser.wait("document.querySelector('#player-note').textContent === ''", 30.0)


def test_a_current_below_the_present_one_is_shown_with_its_reason(serve):
    page = serve()
    row = {"location": "winding_hot_spot", "limit": 145.0, "temperature": 50.0, "standard_deviation": 1.0, "time_to_limit": None,
           "time_to_limit_16": None, "time_to_limit_84": None, "allowed_current": 5.9, "allowed_speed": 85.0}
    limits = {"horizon": 3600.0, "duty_known": True, "rms_current": 7.1, "mean_absolute_speed": 52.0}
    with Chromium() as browser:
        shown(page, browser, limits={**limits, "limits": [row, {**row, "location": "oil", "allowed_speed": 40.0}]})
        browser.wait("document.querySelectorAll('#limits-body .then').length === 2", 30.0)
        first, second = browser.value("[...document.querySelectorAll('#limits-body .then')].map((one) => one.textContent)")
    assert first.endswith("5.9 A rms held or a mean of 812 rpm keep it for ever; so does this duty, whose 7.1 A rms fall as the oil warms")
    assert second.endswith("keep it for ever"), "this duty leads there after the hour that is looked at"


def test_after_a_restart_with_another_token_the_page_asks_for_it(serve):
    first = serve(token="old")
    with Chromium() as browser:
        browser.open(first.url)
        browser.wait("document.documentElement.dataset.ready === 'yes'", 60.0)
        first.server.stop()
        browser.wait(f"{PILL} === 'connection lost, trying again'", 30.0)
        serve(token="new", port=first.server.access.port)
        assert "token" in browser.wait(f"{PILL}.includes('needs its token') && {PILL}", 30.0)
