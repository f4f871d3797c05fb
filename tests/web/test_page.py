"""The page in a real Chromium: chosen early, and not let in any more."""

import json
import time

import numpy as np
import pytest
from ddh_twin_py.nodes.feeds.page_documents import page_document
from ddh_twin_py.rig import load_rig
from ddh_twin_py.web.history import GRID_NS
from ddh_twin_py.web.streams import BY_NAME
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


def test_a_band_that_was_wide_before_the_first_reading_does_not_stretch_the_axis(serve):
    page = serve()
    rows = np.arange(100_000, 100_400)  # 20 s
    values = np.full((rows.size, len(BY_NAME["estimate"].fields)), np.nan)
    place = BY_NAME["estimate"].fields.index("tank_oil.temperature")
    values[:, place] = 23.0 + 0.5 * np.sin(0.1 * rows)
    values[:, place + 1] = np.where(rows < 100_020, 27.0, 0.3)  # K
    with Chromium() as browser:
        browser.screen(1280, 1300)
        browser.call("Page.addScriptToEvaluateOnNewDocument", source="""
            window.written = [];
            const fill = CanvasRenderingContext2D.prototype.fillText;
            CanvasRenderingContext2D.prototype.fillText = function (said, ...at) { written.push(said); fill.call(this, said, ...at); };
            localStorage.setItem("ddh-twin-charts", JSON.stringify({ charts: ["temperature/tank_oil"], window: 0 }));
        """)
        page.board.take("estimate", rows[:10] * GRID_NS, values[:10])
        shown(page, browser)
        # an empty axis goes from 0 to 1
        degrees = "[...new Set(written)].filter((word) => /^−?[\\d.]+$/.test(word)).map((word) => Number(word.replace('−', '-')))"
        ticks = f"{degrees}.filter((at) => at < 0 || at > 1)"
        browser.wait(f"Math.max(...{ticks}) > 40", 30.0)  # nothing else is known yet
        page.board.take("estimate", rows[10:] * GRID_NS, values[10:])
        page.server.show()
        browser.wait(f"{ticks}.some((at) => at > 21 && at < 25)")
        browser.value("written.length = 0")  # also what was drawn just before
        ticks = browser.wait(f"{ticks}.length > 1 && {ticks}", 30.0)
        assert "twin, fused ± 2 σ" in browser.value("document.querySelector('#chart-list').textContent")
    assert min(ticks) >= 21.0 and max(ticks) <= 25.0, ticks


@pytest.mark.parametrize(("columns", "told"), [
    ([[1, 2, 3, 4], [10, 20, None, None]], [2, 20]),  # the free run is two rows behind
    ([[1, None, None, 4], [10, 20, 30, None]], [1, 30]),  # a reading comes now and then
    ([[1, 2, 3, 4, 5, 6, 7], [10, None, None, None, None, None, None]], [7, 10]),  # one stopped
    ([[None, None, 3], [10, 20, None]], [3, 20]),  # nothing older is known
    ([[None, None], [10, 20]], [None, 20]),
])
def test_numbers_beside_each_other_are_of_one_instant(serve, columns, told):
    page = serve()
    with Chromium() as browser:
        shown(page, browser)
        script = f"import('/chart.js').then((chart) => chart.ofOneInstant({json.dumps(columns)}, 4))"
        assert browser.value(script) == told


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
    assert first == ("Not within 60 min, 95 K left. It stays below 145 °C for good at up to 5.9 A rms held, or a mean of 812 rpm; this "
                     "duty does too: its 7.1 A rms fall as the oil warms.")
    assert second.endswith("or a mean of 382 rpm."), "this duty leads there after the hour that is looked at"


@pytest.mark.parametrize(("change", "told"), [
    ({"time_to_limit": 0.0}, "✕ Exceeded. It comes back below 72.5 °C for good at up to 5.9 A rms held, or a mean of 812 rpm."),
    ({"time_to_limit": 1200.0, "time_to_limit_16": 900.0, "allowed_current": 0.0},
     "Limit in 20 min (15 min to more than 60 min). No current keeps it below 72.5 °C."),
    ({"time_to_limit_16": 3000.0, "allowed_speed": None},
     "Not within 60 min (one in six: 50 min), 12 K left. It stays below 72.5 °C for good at up to 5.9 A rms held."),
])
def test_what_keeps_a_limit_is_a_sentence(serve, change, told):
    page = serve()
    row = {"location": "oil", "limit": 72.5, "temperature": 60.1, "standard_deviation": 1.0, "time_to_limit": None,
           "time_to_limit_16": None, "time_to_limit_84": None, "allowed_current": 5.9, "allowed_speed": 85.0, **change}
    limits = {"horizon": 3600.0, "duty_known": True, "rms_current": 5.0, "mean_absolute_speed": 52.0, "warn_within": None}
    with Chromium() as browser:
        shown(page, browser, limits={**limits, "limits": [row]})
        browser.wait("document.querySelectorAll('#limits-body .then').length === 1", 30.0)
        assert browser.text("#limits-body .then") == told
        assert browser.text("#limits-body .now").endswith("of 72.5 °C")


def test_a_small_pressure_keeps_its_tenths_on_a_phone(serve):
    page = serve()
    rows = np.arange(100_000, 100_020)
    stream = BY_NAME["hydraulics"]
    values = np.full((rows.size, len(stream.fields)), np.nan)
    for port, pressure in (("pressure_rod_side", -0.76e5), ("pressure_piston_side", 123.46e5)):
        values[:, stream.fields.index(port)] = pressure
    with Chromium() as browser:
        browser.screen(380, 900, phone=True)
        shown(page, browser)
        page.board.take("hydraulics", rows * GRID_NS, values)
        page.server.show()
        texts = "[...document.querySelectorAll('[data-show^=pressure_][data-short]')].map((one) => one.textContent)"
        told = browser.wait(f"{texts}.every((text) => text !== '') && {texts}", 30.0)
    assert told == ["123 bar", "−0.8 bar"]


@pytest.mark.parametrize(("within", "told"), [(1800.0, "fair"), (600.0, "good"), (None, "good")])
def test_a_limit_is_near_from_where_the_fusion_warns_on(serve, within, told):
    page = serve()
    row = {"location": "oil", "limit": 80.0, "temperature": 70.0, "standard_deviation": 1.0, "time_to_limit": 1200.0,
           "time_to_limit_16": 900.0, "time_to_limit_84": None, "allowed_current": 5.9, "allowed_speed": 85.0}
    limits = {"horizon": 3600.0, "duty_known": True, "rms_current": 7.1, "mean_absolute_speed": 52.0, "warn_within": within}
    with Chromium() as browser:
        shown(page, browser, limits={**limits, "limits": [row]})
        browser.wait("document.querySelectorAll('#limits-body .margin').length === 1", 30.0)
        assert browser.value("document.querySelector('#limits-body .margin').className") == f"margin {told}"


def test_after_a_restart_with_another_token_the_page_asks_for_it(serve):
    first = serve(token="old")
    with Chromium() as browser:
        browser.open(first.url)
        browser.wait("document.documentElement.dataset.ready === 'yes'", 60.0)
        first.server.stop()
        browser.wait(f"{PILL} === 'connection lost, trying again'", 30.0)
        serve(token="new", port=first.server.access.port)
        assert "token" in browser.wait(f"{PILL}.includes('needs its token') && {PILL}", 30.0)
