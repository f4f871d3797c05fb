"""Reports on a screen, by a real Chromium: nothing is cut without a sign of it, and axes can be read."""

import json
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.cli.main import main
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive.design import Design
from ddh_twin_py.gap.explain.detection import SIZES, Detection
from ddh_twin_py.report.gap.design_page import design_document
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.charts import Chart, Trace, charts
from ddh_twin_py.rig import load_rig
from support.chromium import Chromium, executable

pytestmark = pytest.mark.skipif(executable() is None, reason="there is no Chromium on this machine; scripts/browser.sh installs one")
LAPTOP, PHONE = 1100, 400  # px
_CUT = "[...document.querySelectorAll('.scroll')].filter((e) => e.scrollWidth > e.clientWidth + 1)"


@pytest.fixture(scope="module")
def browser():
    with Chromium() as found:
        yield found


def show(browser, page, path, width):
    page.write(path)
    browser.screen(width, 900)
    browser.call("Page.navigate", url=path.as_uri())
    browser.wait(f"location.href === {json.dumps(path.as_uri())} && document.documentElement.dataset.drawn !== undefined")


@pytest.fixture
def design():
    """Every effect of the catalogue, with the longest that can be said of it."""
    found = [Detection(e, "Pa*s2/m6", 6.5e12, 1.0, "temperature/motor_winding", dict.fromkeys(SIZES)) for e in EFFECTS]
    names = list(EFFECTS)
    return Design(120.0, 600.0, (), True, found, names, np.full((len(names), len(names)), 1234.5), [])


def test_a_design_fits_a_laptop_and_a_phone_shows_that_there_is_more(browser, design, tmp_path):
    unseen = [replace(d, worst="", smallest=None, rise=None) for d in design.detections]
    show(browser, design_document(replace(design, detections=unseen), load_rig(), "mixed", 1.0), tmp_path / "unseen.html", LAPTOP)
    assert browser.value("document.querySelectorAll('.scroll').length") == 2 and browser.value(f"{_CUT}.length") == 0
    page = design_document(design, load_rig(), "mixed", 1.0)
    show(browser, page, tmp_path / "design.html", LAPTOP)
    assert browser.value(f"{_CUT}.length") == 0 and browser.value("document.querySelectorAll('.more').length") == 0
    show(browser, page, tmp_path / "phone.html", PHONE)
    browser.wait(f"{_CUT}.length === 2 && {_CUT}.every((e) => e.classList.contains('more'))")
    assert browser.value("getComputedStyle(document.querySelector('.more')).maskImage").startswith("linear-gradient")
    assert browser.value("document.querySelector('caption span').getBoundingClientRect().right") < PHONE
    browser.value(f"{_CUT}.forEach((e) => {{ e.scrollLeft = e.scrollWidth }})")
    browser.wait("document.querySelectorAll('.more').length === 0")


def test_sentences_in_a_table_have_room_on_a_phone_and_no_word_is_broken(browser, tmp_path, capsys):
    assert main(["motor", "--layers", "1", "--html", str(tmp_path / "motor.html")]) == 0
    for width in (LAPTOP, PHONE):
        browser.screen(width, 900)
        browser.call("Page.navigate", url=(tmp_path / "motor.html").as_uri())
        browser.wait(f"document.documentElement.dataset.drawn !== undefined && innerWidth === {width}")
        cells = browser.value("[...document.querySelectorAll('td')].filter((e) => e.textContent.length > 60).map((e) => e.clientWidth)")
        assert len(cells) > 5 and min(cells) > 150
        assert browser.value("[...document.querySelectorAll('td')].filter((e) => e.textContent.includes('_per_phase'))"
                             ".every((e) => getComputedStyle(e).overflowWrap === 'normal')")
    names = browser.value("[...document.querySelectorAll('tbody th')].map((e) => e.getBoundingClientRect().width)")
    assert max(names) < 0.55 * PHONE  # they stay where they are while the rest is scrolled below them


@pytest.mark.parametrize("size", [0.87, 1.7, 3.4, 4.4, 9.7])
def test_an_axis_has_two_ticks_at_least(browser, size, tmp_path):
    time = np.arange(0.0, 60.0)
    chart = Chart("t", "V", time, [Trace("a", "measured", size * np.sin(time))], height=150)
    page = doc.Document("Kind", "Title", "All is well.", doc.EndMatter("none", "none", ("none",)))
    page.add("Charts", charts([chart]))
    script = browser.call("Page.addScriptToEvaluateOnNewDocument", source="""
        window.written = [];
        const fill = CanvasRenderingContext2D.prototype.fillText;
        CanvasRenderingContext2D.prototype.fillText = function (said, ...at) { written.push(said); fill.call(this, said, ...at); };
    """)
    show(browser, page, tmp_path / f"chart_{size}.html", LAPTOP)
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script["identifier"])
    written = browser.wait("written.length > 0 && written")
    assert len({word for word in written if "s" not in word}) >= 2  # times end in s
