"""Takes the pictures of the documents: the live page of real graphs, a replay's report and a diagnosis, in a Chromium without a window.

    . .venv/bin/activate
    python scripts/pictures.py            # into docs/pictures, takes some minutes
    python scripts/pictures.py gap        # those of the live page with a gap alone; or of the cycle, of the report, of the diagnosis
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from ddh_twin_py.bags.damage import with_value, without_samples  # noqa: E402
from ddh_twin_py.bags.reader import read_recording  # noqa: E402
from ddh_twin_py.bags.writer import write_recording  # noqa: E402
from ddh_twin_py.cli.live_graph import LiveGraph  # noqa: E402
from ddh_twin_py.cli.main import main as ddh_twin  # noqa: E402
from ddh_twin_py.cli.twin_nodes import FLUSH_AFTER, MODELS, TWIN  # noqa: E402
from run_documents import blocks_of  # noqa: E402
from support.chromium import Chromium, executable  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"
PAPER_CYCLE = ROOT / "bags" / "paper_cycle"
WORN = "pump_1:\n  leakage: {value: 5.0e-12, unit: m3/(s*Pa), tolerance: 0.15, source: four times the sheet's}\n"
DURATION = 600.0  # s of simulated duty
WAIT = 600.0  # s, the longest that a bag player waits for its nodes
_FIRST_FOUR = """(() => {
  const charts = [...document.querySelectorAll(".charts .chart")].slice(0, 4).map((chart) => chart.getBoundingClientRect());
  const [left, top] = [Math.min(...charts.map((c) => c.left)), Math.min(...charts.map((c) => c.top))];
  const [right, bottom] = [Math.max(...charts.map((c) => c.right)), Math.max(...charts.map((c) => c.bottom))];
  return [left + scrollX - 8, top + scrollY - 8, right - left + 16, bottom - top + 16];
})()"""
"""Left, top, width and height around the first four charts of a report, in its pixels."""

_FIRST_CIRCUIT = "document.querySelector('.circuit').getBoundingClientRect().bottom + scrollY"
"""Where the first drawing of a diagnosis ends, in the page's pixels."""


class Shown:
    """A recording that plays through the twin, its page, and a browser that looks at it."""

    def __init__(self, bag: Path, log: Path, player: Mapping[str, object], gap: Mapping[str, object] | None = None) -> None:
        self._graph = LiveGraph(log)
        self._page: list[str] = []
        self._start = dict(player) | {"bag": str(bag), "exit_at_end": False, "wait_for_nodes": list(TWIN), "wait": WAIT}
        self._gap = dict(gap or {})

    def __enter__(self) -> Chromium:
        graph = self._graph.__enter__()
        graph.start("web_view", {"port": 0}, hear=lambda line: self._page.extend(re.findall(r"page at (\S+)", line)))
        for node in TWIN:
            graph.start(node, {"flush_after": FLUSH_AFTER} if node in MODELS else self._gap)
        graph.start("bag_player", self._start)
        while not self._page:
            graph.check()
            time.sleep(0.1)
        self._browser = Chromium()
        self._browser.screen(1280, 1300)
        self._browser.open(self._page[0])
        return self._browser

    def __exit__(self, *given: object) -> None:
        self._browser.__exit__()
        self._graph.__exit__(*given)


def at(seconds: float) -> str:
    """Script that is true once the replay is there."""
    return f"Number(document.querySelector('#seek').value) >= {seconds}"


def learn(bag: Path, levels: Path, log: Path) -> None:
    """The levels that are normal of a rig, from a recording of it, as fast as it goes."""
    ended: list[str] = []
    with LiveGraph(log) as graph:
        for node in TWIN:
            graph.start(node, {"flush_after": FLUSH_AFTER} if node in MODELS else {"normal_file": str(levels), "learn_until_end": True})
        graph.start("bag_player", {"bag": str(bag), "rate": 0.0, "wait_for_nodes": list(TWIN), "wait": WAIT}, hear=ended.append)
        while graph.alive("bag_player"):
            graph.check(ended="bag_player")
            time.sleep(0.2)
        time.sleep(3.0 * FLUSH_AFTER)


def cycle(scratch: Path) -> None:
    """The paper's cycle, light; then two sensors that fail."""
    recording = read_recording(PAPER_CYCLE).between(0.0, 180.0)
    recording = without_samples(recording, "temperature/line_a", 120.0, 1e9)
    recording = with_value(recording, "temperature/pump_1_case", "temperature", float("nan"), 120.0)
    bag = write_recording(scratch / "paper_cycle", recording)
    with Shown(bag, scratch / "cycle.log", {"rate": 2.0}) as browser:
        browser.press("2")
        browser.wait(at(111.0), WAIT)
        browser.picture(PICTURES / "live_page.png")
        browser.wait("document.querySelectorAll('.sensors .stopped').length === 1", WAIT)
        browser.wait("document.querySelectorAll('.sensors .error').length === 1", WAIT)
        browser.screen(1280, 860)
        browser.wait(at(128.0), WAIT)
        browser.picture(PICTURES / "live_page_sensors.png")


def gap(scratch: Path) -> None:
    """A rig whose pump leaks four times as much as when it was new, dark and on a phone."""
    (scratch / "worn.yaml").write_text(WORN)
    for name, more in (("new", []), ("worn", ["--rig", str(scratch / "worn.yaml")])):
        assert ddh_twin(["simulate", "mixed", "-o", str(scratch / name), "--seed", "3", "--duration", str(DURATION), *more]) == 0
    learn(scratch / "new", scratch / "levels.json", scratch / "learn.log")
    with Shown(scratch / "worn", scratch / "gap.log", {"rate": 1.0}, {"normal_file": str(scratch / "levels.json")}) as browser:
        browser.screen(1280, 1300, dark=True)
        browser.press("2")
        browser.wait("document.querySelectorAll('.signals .open').length >= 3", WAIT)
        browser.wait(at(150.0), WAIT)
        browser.picture(PICTURES / "live_page_gap.png")
        browser.screen(390, 1000, phone=True)
        browser.value("scrollTo(0, 0)")
        time.sleep(2.0)
        browser.picture(PICTURES / "live_page_phone.png")


def report(scratch: Path) -> None:
    """The first four temperatures of the report of the paper's cycle."""
    assert ddh_twin(["replay", str(PAPER_CYCLE), "--html", str(scratch / "report.html"), "--quiet"]) == 0
    with Chromium() as browser:
        browser.screen(1280, 4000)  # charts are drawn once they are in sight
        browser.call("Page.navigate", url=(scratch / "report.html").resolve().as_uri())
        browser.wait("[...document.querySelectorAll('.charts .chart')].filter((chart) => chart.querySelector('canvas')).length >= 4", 30.0)
        box = browser.value(_FIRST_FOUR)
        browser.picture(PICTURES / "paper_cycle.png", clip=dict(zip(("x", "y", "width", "height"), box, strict=True)))


def diagnosis(scratch: Path) -> None:
    """What a diagnosis says first, and its first drawing: the tutorial's worn pump."""
    for block in blocks_of((ROOT / "docs" / "tutorial.md").read_text()):
        if block.mark.startswith("file: "):
            (scratch / block.mark.removeprefix("file: ")).write_text(block.text)
    for name, rig in (("new", "press_7.yaml"), ("today", "worn.yaml")):
        assert ddh_twin(["simulate", "mixed", "-o", name, "--seed", "7", "--duration", "240", "--rig", rig, "--quiet"]) == 0
    assert ddh_twin(["gap", "today", "--commissioning", "new", "--html", "diagnosis.html", "--quiet"]) == 0
    with Chromium() as browser:
        browser.screen(1100, 4000)
        browser.call("Page.navigate", url=(scratch / "diagnosis.html").resolve().as_uri())
        browser.wait("document.querySelectorAll('.circuit').length >= 1", 30.0)
        browser.picture(PICTURES / "diagnosis.png", clip={"x": 0, "y": 0, "width": 1100, "height": browser.value(_FIRST_CIRCUIT) + 8})


def main() -> int:
    """Take all pictures."""
    if executable() is None:
        print("error: there is no Chromium; scripts/browser.sh installs one", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="ddh_pictures_") as scratch:
        os.chdir(scratch)  # the page shows the path of a bag as it is given
        for name, take in (("report", report), ("cycle", cycle), ("gap", gap), ("diagnosis", diagnosis)):
            if name in sys.argv[1:] or not sys.argv[1:]:
                take(Path())
    return 0


if __name__ == "__main__":
    sys.exit(main())
