"""Reports on paper, by a real Chromium: nothing is cut off at the edge, and no page stays empty before something long."""

import base64
import re
from dataclasses import replace

import pytest
from ddh_twin_py.report.gap.page import gap_document
from ddh_twin_py.report.page import document as doc
from support.chromium import Chromium, executable
from support.made_diagnosis import made_diagnosis

pytestmark = pytest.mark.skipif(executable() is None, reason="there is no Chromium on this machine; scripts/browser.sh installs one")
A4_WIDTH = 703  # px between the margins of the page


@pytest.fixture(scope="module")
def browser():
    with Chromium() as found:
        yield found


def show(browser, page, path):
    page.write(path)
    browser.call("Page.navigate", url=path.as_uri())
    browser.wait("document.readyState === 'complete' && document.querySelector('h1') !== null")


def pages(browser) -> int:
    pdf = base64.b64decode(browser.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)["data"])
    return len(re.findall(rb"/Type\s*/Page\b", pdf))


def test_no_word_is_cut_off_at_the_edge(browser, tmp_path):
    browser.call("Emulation.setDeviceMetricsOverride", width=A4_WIDTH, height=1000, deviceScaleFactor=1, mobile=False)
    diagnosis = made_diagnosis()
    diagnosis = replace(diagnosis, weighed=[replace(w, probability=0.9 * w.probability) for w in diagnosis.weighed])
    first = diagnosis.report["why"][0]
    first["probability"] = 0.999  # the longest bar with the longest words behind it
    first["parameters"] = {"a_ratio": {"value": 1.139, "std": 0.006, "unit": "1"}, "b_ratio": {"value": 1.456, "std": 0.012, "unit": "1"}}
    show(browser, gap_document(diagnosis), tmp_path / "gap.html")
    browser.call("Emulation.setEmulatedMedia", media="print")
    browser.value("document.querySelectorAll('details').forEach((d) => { d.open = true })")
    beyond = (
        "[...document.querySelectorAll('p, .bar span, .signed span, h1, h2, h3, dd, td.n')].filter((e) => e.getClientRects().length"
        " && e.getBoundingClientRect().right > document.body.getBoundingClientRect().right + 1).map((e) => e.textContent)"
    )
    assert browser.value("[...document.querySelectorAll('.bar span')].some((e) => e.textContent.includes('1.139 ± 0.006; 1.456 ± 0.012'))")
    assert browser.value(beyond) == []
    browser.call("Emulation.setEmulatedMedia", media="")


def test_long_bars_begin_where_their_heading_is(browser, tmp_path):
    page = doc.Document("Kind", "Title", "All is well.", doc.EndMatter("none", "none", ("none",)))
    page.add("Before", *(doc.paragraph("One line.") for _ in range(12)))
    rows = [(f"parameter {i}", (("fused", float(i + 1)),)) for i in range(75)]
    page.add("Bars", doc.bars(rows, "%"))
    show(browser, page, tmp_path / "bars.html")
    assert pages(browser) == 3  # four where the bars begin on a page of their own
