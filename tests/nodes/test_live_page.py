"""The live page in a real Chromium: it draws, it changes, it tells what is wrong, it comes back, everybody can read it."""

import re

import pytest
from ddh_twin_py.bags.damage import with_value, without_samples
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.nodes.base import qos
from nodes.processes import NodeProcess
from support.chromium import Chromium, executable

from ddh_msgs.msg import GapStatus, SignalGap

pytestmark = [
    pytest.mark.live,
    pytest.mark.skipif(executable() is None, reason="there is no Chromium on this machine; scripts/browser.sh installs one"),
]
NS = "/looked_at"
MODELS = ("hydraulic_model", "machine_thermal", "temperature_fusion")
LOST = 30.0  # s of the recording at which sensors fail
BADGE = "document.querySelector('[data-sensor=\"temperature/{}\"]').classList.contains('{}')"
COMES = "['ok', 'warn'].some((state) => document.querySelector('[data-sensor=\"temperature/{}\"]').classList.contains(state))"
"""A node on a loaded machine may warn of messages that came late to it."""
LINE = "document.querySelector('[data-topic=\"temperature/{}\"]')?.dataset.state"


@pytest.fixture(scope="module")
def bag(paper_cycle_bag, tmp_path_factory):
    """A minute of the paper's cycle; in its second half one sensor says nothing and another no number."""
    recording = read_recording(paper_cycle_bag).between(0.0, 60.0)
    recording = without_samples(recording, "temperature/line_a", LOST, 1e9)
    recording = with_value(recording, "temperature/pump_1_case", "temperature", float("nan"), LOST)
    return write_recording(tmp_path_factory.mktemp("page") / "bag", recording)


class Page:
    """Browser, node and player of one graph."""

    def __init__(self, bag):
        self.nodes = [NodeProcess(name, NS, flush_after=0.5) for name in MODELS]
        self.port = 0
        self.serve()
        self.player = NodeProcess(
            "bag_player", NS, bag=str(bag), exit_at_end=False, wait_for_nodes=list(MODELS), clock_rate=0.0, wait=60.0, loop=True,
        )  # fmt: skip
        self.browser = Chromium()

    def serve(self):
        """Start web_view, where it does not run; always at the same port."""
        self.view = NodeProcess("web_view", NS, port=self.port)
        self.url = re.search(r"http://\S+", self.view.says("page at"))[0]
        self.port = int(self.url.rstrip("/").rpartition(":")[2])

    def close(self):
        self.browser.__exit__()
        for node in (self.player, self.view, *self.nodes):
            with node:
                node.stop()


@pytest.fixture(scope="module")
def page(bag):
    made = Page(bag)
    yield made
    made.close()


@pytest.fixture
def browser(page):
    """The browser at the page, replay under way, 1280 px wide."""
    browser = page.browser
    if page.view.process.poll() is not None:  # a test before this one has failed half-way
        page.serve()
    browser.screen(1280, 900)
    if browser.value("location.href") != page.url:
        browser.open(page.url)
    browser.wait("document.querySelector('#play').textContent !== ''", 90.0)
    if browser.text("#play") == "Play":
        browser.value("document.querySelector('#play').click()")
    browser.wait("document.querySelector('#link').textContent === 'replay'", 90.0)
    browser.wait("document.querySelector('[data-show=end_winding]').textContent.endsWith('°C')", 60.0)
    browser.errors.clear()
    return browser


def seek(browser, seconds):
    """Move the slider as a hand does."""
    browser.value(
        f"(() => {{ const s = document.querySelector('#seek'); s.value = {seconds}; s.dispatchEvent(new Event('input')); "
        "s.dispatchEvent(new Event('change')); })()"
    )


def test_it_draws_the_circuit_and_the_charts(browser):
    assert "rig_000" in browser.text("#title") and "rig_000" in browser.value("document.title")
    parts = "[...document.querySelectorAll('[data-node]')]"
    browser.wait(f"{parts}.length >= 20 && {parts}.every((part) => (part.style.fill || part.style.stroke).startsWith('rgb'))", 60.0)
    assert re.search(r"-?\d+ °C", browser.text("#coolest")) and browser.text("[data-show=payload]") == "149.5 kg"
    assert browser.value("document.querySelectorAll('.chart').length") == 6
    browser.value("document.querySelector('#charts').scrollIntoView()")
    inked = (
        "[...document.querySelectorAll('.chart')].filter((chart) => chart.querySelector('b').textContent !== '–')"
        ".map((chart) => chart.querySelector('canvas')).filter((c) => { let n = 0;"
        " const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        " for (let i = 3; i < d.length; i += 4) n += d[i] > 120; return n > 800 }).length >= 2"
    )
    browser.wait(inked, 20.0)
    browser.wait("document.querySelector('#limits-body .margin .now').textContent.endsWith('of 145 °C')", 30.0)


def test_values_the_piston_the_arrows_and_the_time_move(browser):
    watched = {
        "pressure": "document.querySelector('.labels.wide [data-show=pressure_piston_side]').textContent",
        "piston": "document.querySelector('[data-moving=piston]').getAttribute('transform')",
        "arrow": "document.querySelector('.arrows.flow polygon[visibility=visible]').getAttribute('transform')",
        "time": "document.querySelector('#clock').textContent",
        "place": "document.querySelector('#position').textContent",
        "legend": "document.querySelector('.legend b').textContent",
    }
    for name, script in watched.items():
        before = browser.value(script)
        assert browser.wait(f"({script}) !== {before!r} && ({script})", 20.0), name


def test_everything_comes_from_this_server_and_nothing_fails(browser, page):
    assert browser.requests and all(re.match(rf"(http|ws)://127\.0\.0\.1:{page.port}/|data:", url) for url in browser.requests)
    assert browser.errors == []


def test_sensors_that_fail_are_shown_where_they_are(browser):
    seek(browser, 5.0)
    browser.wait(COMES.format("line_a") + " && " + COMES.format("pump_1_case"), 30.0)
    seek(browser, LOST - 3.0)
    browser.wait(LINE.format("line_a") + " === 'stopped'", 30.0)
    browser.wait(BADGE.format("line_a", "stopped") + " && " + BADGE.format("pump_1_case", "error"), 10.0)
    assert re.match(r"no message for \d+ s", browser.text('[data-topic="temperature/line_a"] .why'))
    assert "not a number" in browser.text('[data-topic="temperature/pump_1_case"] .why')
    assert browser.value("getComputedStyle(document.querySelector('[data-sensor=\"temperature/line_a\"] .cross')).display") == "block"
    assert browser.value(COMES.format("tank_oil"))
    seek(browser, 5.0)  # and they come back
    browser.wait(COMES.format("line_a"), 30.0)


def test_the_gap_is_told_where_it_opens(browser, listener):
    publisher = listener.node.create_publisher(GapStatus, f"{NS}/gap/status", qos.STATUS)
    floor = {"unit": "Pa", "tested": True, "learned": 1.0, "floor": 4e4, "threshold": 10.0}
    quiet = SignalGap(signal="pressure_rod_side", statistic=4.0, opened=False, **floor)
    open_ = SignalGap(
        signal="pressure_rod_side", statistic=12.0, opened=True, size=-9.6e5, size_standard_deviation=5e4, size_in_floors=-24.0, **floor,
    )  # fmt: skip
    open_.since.sec = 1_772_000_000
    status = GapStatus(watching=True, time_between_false_alarms=3.6e6, signals=[quiet])
    publisher.publish(status)
    browser.wait("document.querySelector('#verdict').classList.contains('good')", 20.0)
    assert not browser.value("document.querySelector('.sensors .gap')")
    status.opened, status.component, status.because, status.signals = True, "sensor", "no other signal follows", [open_]
    publisher.publish(status)
    browser.wait("document.querySelector('[data-place=line_b]').classList.contains('gap')", 20.0)
    verdict = browser.text("#verdict")
    assert "pressure rod side" in verdict and "24.0 times the noise floor" in verdict and "points to: sensor" in verdict
    assert browser.text("[data-place=line_b] .gap-size") == "24.0 ×" and "gap" in browser.value("document.title")
    assert "−9.60 ± 0.5 bar" in browser.text("#gap-body .open") and "no other signal follows" in browser.text("#gap-body")
    status.opened, status.component, status.signals = False, "", [quiet]
    publisher.publish(status)
    browser.wait("!document.querySelector('.sensors .gap')", 20.0)
    listener.withdraw(publisher)


def test_keys_and_focus_are_enough(browser):
    browser.value("document.activeElement.blur()")
    browser.press(" ")
    browser.wait("document.querySelector('#link').textContent === 'paused' && document.querySelector('#play').textContent === 'Play'", 20.0)
    before = browser.value("Number(document.querySelector('#seek').value)")
    browser.press("ArrowRight")
    browser.wait(f"Math.abs(Number(document.querySelector('#seek').value) - {min(before + 10.0, 60.0)}) < 1", 20.0)
    browser.press(" ")
    browser.wait("document.querySelector('#link').textContent === 'replay'", 20.0)
    theme = browser.value("document.documentElement.dataset.theme")
    browser.press("t")
    assert browser.value("document.documentElement.dataset.theme") != theme
    browser.press("t")
    browser.press("2")
    assert browser.value("document.querySelector('#windows [aria-pressed=true]').textContent") == "2 min"
    browser.press("1")
    reached = set()
    for _ in range(60):
        browser.press("Tab")
        here = "document.activeElement"
        reached.add(browser.value(f"({here}.id || {here}.textContent || {here}.tagName).slice(0, 24)"))
        outline = browser.value(f"{here} === document.body || getComputedStyle({here}).outlineStyle !== 'none'")
        assert outline, reached
    assert {"theme", "play", "seek", "rate", "add", "30 s", "✕", "All temperatures as a ta"} <= reached
    assert any("hydraulic_model" in name for name in reached)


PLACE = "Number(document.querySelector('#seek').value)"


def test_keys_go_on_after_a_button_was_clicked_and_steps_add_up(browser):
    seek(browser, 50.0)
    browser.value("document.querySelector('#play').click(); document.querySelector('#play').focus()")
    browser.wait("document.querySelector('#link').textContent === 'paused'", 20.0)
    browser.wait(f"{PLACE} > 49", 20.0)
    before = browser.value(PLACE)
    for _ in range(3):
        browser.press("ArrowLeft")
    browser.wait(f"Math.abs({PLACE} - {before - 30.0}) < 1", 20.0)
    browser.wait("document.querySelector('#player').textContent.includes('is of where it was paused')", 20.0)
    browser.value("document.querySelector('#seek').focus()")
    browser.press("ArrowRight")
    browser.wait(f"Math.abs({PLACE} - {before - 20.0}) < 1", 20.0)
    browser.value("document.querySelector('#play').focus()")
    browser.press("Enter")
    browser.wait("document.querySelector('#link').textContent === 'replay'", 20.0)
    browser.wait("!document.querySelector('#player').textContent.includes('is of where it was paused')", 20.0)


def test_the_slider_goes_on_when_it_was_let_go_where_it_was_taken(browser):
    seek(browser, 10.0)
    browser.wait(f"Math.abs({PLACE} - 10) < 5", 20.0)
    slider = "document.querySelector('#seek')"
    browser.value(f"{slider}.value = 40; {slider}.dispatchEvent(new Event('input'))")
    browser.value(f"{slider}.value = 10; {slider}.dispatchEvent(new Event('input')); {slider}.dispatchEvent(new Event('pointerup'))")
    browser.wait(f"{PLACE} > 12 && {PLACE} < 40", 20.0)


def test_any_quantity_can_be_charted_and_is_remembered(browser):
    choose = "const s = document.querySelector('.chart select'); s.value = 'loss/motor'; s.dispatchEvent(new Event('change'))"
    browser.value(f"(() => {{ {choose} }})()")
    browser.value("document.querySelector('#charts').scrollIntoView()")
    browser.wait("document.querySelector('.chart .legend').textContent.match(/soft sensor [\\d.−]+ W/)", 20.0)
    browser.value("document.querySelector('#add').click()")
    assert browser.value("document.querySelectorAll('.chart').length") == 7
    browser.value("document.querySelectorAll('.chart .remove')[6].click()")
    browser.call("Page.reload")
    browser.wait("document.querySelector('.chart select')?.value === 'loss/motor'", 30.0)
    assert browser.value("document.querySelectorAll('.chart').length") == 6
    browser.value("localStorage.clear()")
    browser.call("Page.reload")
    browser.wait("document.querySelector('.chart select')?.value === 'pressure_piston_side'", 30.0)


OBSERVED = """window.observers = [];
window.IntersectionObserver = class extends IntersectionObserver {
  constructor(told) { super(told); this.told = told; window.observers.push(this); }
  observe() {}
};"""
SEEN = "observers.forEach((made) => made.told([{ isIntersecting: false }, { isIntersecting: true }]))"


def test_a_chart_that_left_and_came_back_at_once_goes_on(browser):
    script = browser.call("Page.addScriptToEvaluateOnNewDocument", source=OBSERVED)["identifier"]
    legend = "document.querySelector('.chart .legend b').textContent"
    try:
        browser.call("Page.reload")
        browser.wait(f"{legend} !== '–'", 30.0)
        browser.value(SEEN)
        browser.wait(f"!['–', {browser.value(legend)!r}].includes({legend})", 30.0)  # a dash: the recording began anew
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
        browser.call("Page.reload")
        browser.wait("document.documentElement.dataset.ready === 'yes'", 30.0)


SMALLEST = (
    "Math.min(...[...document.querySelectorAll('.circuit text')].filter((t) => t.textContent.trim() && t.getClientRects().length)"
    ".map((t) => parseFloat(getComputedStyle(t).fontSize) * t.getScreenCTM().a))"
)
OVERLAPS = """(() => {
  const longest = (what) => /pressure/.test(what.show) ? (what.short ? '158 bar' : '158.8 bar') : /velocity/.test(what.show) ? '−200 mm/s'
    : /_flow/.test(what.show) ? '−38.8 L/min' : what.heat ? 'heat 888 W'
    : /^state/.test(what.show) ? (what.short ? '−2.8 kW' : '−2.88 kW') : what.short ? '−18°'
    : what.spread ? '128.8 ± 12.8 °C' : '128.8 °C';
  // until it is painted next
  for (const t of document.querySelectorAll('.circuit .labels [data-show]')) t.textContent = longest(t.dataset);
  const seen = [...document.querySelectorAll('.circuit .labels text, .circuit .rail text, .circuit .inside')]
    .filter((t) => t.textContent.trim() && t.getClientRects().length).map((t) => [t.textContent.trim(), t.getBoundingClientRect()]);
  const found = [];
  seen.forEach(([a, p], i) => seen.slice(i + 1).forEach(([b, q]) => {
    const wide = Math.min(p.right, q.right) - Math.max(p.left, q.left);
    const high = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
    if (wide > 1 && high > 0.3 * Math.min(p.height, q.height)) found.push(a + ' | ' + b);
  }));
  return found;
})()"""
CROSSED = """(() => {
  for (const t of document.querySelectorAll('.circuit .gap-size')) t.textContent = '88.8 ×';  // until the gap is told next
  const parts = [...document.querySelectorAll(
    '.circuit .thin path, .circuit .pipe-wall, .circuit .solid, .circuit .metal, .circuit .box, .circuit .cable')];
  const shown = (t) => t.textContent.trim() && t.getClientRects().length;
  const texts = [...document.querySelectorAll('.circuit .labels text:not(.on)')].filter(shown);
  const sizes = [...document.querySelectorAll('.circuit .gap-size')].filter(shown);
  const found = [];
  for (const t of texts) {
    const box = t.getBoundingClientRect();
    for (const part of parts) {
      const back = part.getScreenCTM().inverse();
      for (let k = 0; k <= 20; k++) {
        const at = new DOMPoint(box.left + (box.width * k) / 20, box.top + 0.55 * box.height).matrixTransform(back);
        const style = getComputedStyle(part);
        if ((style.stroke !== 'none' && part.isPointInStroke(at)) || (style.fill !== 'none' && part.isPointInFill(at))) {
          found.push(t.textContent.trim() + ' | ' + (part.dataset.node || part.getAttribute('class') || part.getAttribute('d')));
          break;
        }
      }
    }
    for (const size of sizes) {
      const b = size.getBoundingClientRect();
      const wide = Math.min(box.right, b.right) - Math.max(box.left, b.left);
      const high = Math.min(box.bottom, b.bottom) - Math.max(box.top, b.top);
      if (wide > 1 && high > 0.3 * box.height) found.push(t.textContent.trim() + ' | size of a gap at ' + size.parentNode.dataset.sensor);
    }
  }
  for (const t of sizes) t.textContent = '';
  return found;
})()"""


@pytest.mark.parametrize(("width", "height", "phone"), [(1280, 800, False), (390, 844, True)], ids=["1280 px", "phone"])
def test_it_can_be_read_and_nothing_is_cut_off(browser, width, height, phone):
    browser.screen(width, height, phone=phone)
    try:
        browser.wait(f"innerWidth === {width}")
        assert browser.value("document.documentElement.scrollWidth") <= width
        assert browser.value(SMALLEST) >= 9.0
        assert browser.value(OVERLAPS) == []
        assert browser.value(CROSSED) == []
        held = "[...document.querySelectorAll('button, select, .pill, .now')].filter((e) => e.getClientRects().length)"
        assert browser.value(f"{held}.filter((e) => e.getBoundingClientRect().right > innerWidth + 1).length") == 0
    finally:
        browser.screen(1280, 900)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_light_and_dark_follow_the_person(browser, dark):
    browser.value("localStorage.clear()")
    browser.screen(1280, 900, dark=not dark)
    browser.screen(1280, 900, dark=dark)
    browser.wait(f"document.documentElement.dataset.theme === '{'dark' if dark else 'light'}'")
    paper = [int(part) for part in re.findall(r"\d+", browser.value("getComputedStyle(document.body).backgroundColor"))[:3]]
    assert (sum(paper) < 150) is dark


def test_what_somebody_chose_stays_when_the_system_changes(browser):
    browser.value("localStorage.clear()")
    browser.screen(1280, 900)
    browser.wait("document.documentElement.dataset.theme === 'light'")
    browser.value("document.querySelector('#theme').click(); document.querySelector('#theme').click()")
    browser.screen(1280, 900, dark=True)
    browser.wait("matchMedia('(prefers-color-scheme: dark)').matches")
    assert browser.value("document.documentElement.dataset.theme") == "light"
    browser.value("localStorage.clear()")
    browser.screen(1280, 900)


def test_who_wants_no_motion_gets_none(browser):
    browser.screen(1280, 900, still=True)
    browser.wait("document.querySelector('.arrows.flow polygon[visibility=visible]') !== null", 20.0)
    arrows = "[...document.querySelectorAll('.arrows.flow polygon')].slice(0, 4)"
    assert len({browser.value(f"{arrows}.map((p) => p.getAttribute('transform').split(' rotate')[0]).join()") for _ in range(5)}) == 1


def test_it_comes_back_when_the_node_was_started_again(browser, page):
    browser.value("window.marker = 'the same page'")
    before = browser.value("document.querySelector('#clock').textContent")
    page.view.stop()
    page.view.__exit__()
    lost = "document.querySelector('#link').textContent === 'connection lost, trying again'"
    browser.wait(f"{lost} && document.body.classList.contains('stale')", 20.0)
    page.serve()
    browser.wait("document.querySelector('#link').textContent === 'replay' && !document.body.classList.contains('stale')", 60.0)
    browser.wait(f"document.querySelector('#clock').textContent !== {before!r}", 20.0)
    assert browser.value("window.marker") == "the same page"
    browser.wait("document.querySelector('[data-show=end_winding]').textContent.endsWith('°C')", 30.0)
