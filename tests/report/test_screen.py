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


def test_a_legend_names_its_lines_alone_until_the_pointer_is_on_a_chart(browser, tmp_path):
    time = np.arange(0.0, 60.0)
    chart = Chart("t", "V", time, [Trace("measured", "measured", np.sin(time)), Trace("before", "predicted", np.cos(time))])
    page = doc.Document("Kind", "Title", "All is well.", doc.EndMatter("none", "none", ("none",)))
    page.add("Charts", charts([chart]))
    show(browser, page, tmp_path / "legend.html", LAPTOP)
    seen = ("[...document.querySelectorAll('.u-legend .u-label, .u-legend td')].filter((e) => getComputedStyle(e).visibility === 'visible')"
            ".map((e) => e.textContent)")
    colon = "getComputedStyle(document.querySelectorAll('.u-legend th')[1], '::after').visibility"
    assert browser.value(seen) == ["measured", "before"] and browser.value(colon) == "hidden"
    left, top = browser.value("(() => { const r = document.querySelector('.u-over').getBoundingClientRect(); return [r.left, r.top] })()")
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=left + 100, y=top + 50)
    browser.wait(f"{seen}.length === 6")
    assert "–" not in browser.value(seen) and browser.value(colon) == "visible"
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=2, y=2)
    browser.wait(f"{seen}.length === 2")


def test_a_long_path_in_a_note_does_not_widen_a_phone(browser, tmp_path):
    page = doc.Document("Kind", "Title", "All is well.", doc.EndMatter("none", "none", ("none",)))
    page.add("Parameters", doc.note("Source, where no other is named: /tmp/shared/data/open_cases/case_003/commissioning_of_the_rig."))
    show(browser, page, tmp_path / "path.html", 390)
    assert browser.value("document.documentElement.scrollWidth") == 390


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
