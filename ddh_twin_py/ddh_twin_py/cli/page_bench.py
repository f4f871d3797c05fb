"""What `ddh-twin bench` measures of the live page."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.cli.arguments import InputError
from ddh_twin_py.cli.console import stage
from ddh_twin_py.cli.live_graph import LiveGraph
from ddh_twin_py.cli.twin_nodes import FLUSH_AFTER, MODELS, TWIN

LIMITS = {1: 25.0, 20: 40.0}
"""Browsers, and % of one core that web_view may take with them."""
_START = 120.0  # s that the graph has to start
_UNDER_WAY = 5.0  # s of playing before anything is measured
_SETTLE = 2.0  # s of looking before and after what is measured


def page_figures(bag: Path, scratch: Path, quick: bool, quiet: bool) -> Iterator[Figure]:
    """Processor time of web_view while the full graph runs on 100 Hz in real time, and what reaches the browsers.

    Args:
        bag: telemetry at 100 Hz, longer than what is measured.

    Raises:
        InputError: where a node dies or is not ready in time.
    """
    seconds = 10.0 if quick else 30.0
    address: list[str] = []
    playing = threading.Event()

    def hear_page(line: str) -> None:
        address.extend(re.findall(r"page at (\S+)", line))

    def hear_player(line: str) -> None:
        if "playing at" in line:
            playing.set()

    with LiveGraph(scratch / "page_nodes.log") as graph:
        with stage("starting the graph with the live page", quiet):
            for node in TWIN:
                graph.start(node, {"flush_after": FLUSH_AFTER} if node in MODELS else {})
            graph.start("web_view", {"port": 0}, hear=hear_page)
            graph.start("bag_player", {"bag": str(bag), "loop": True, "wait_for_nodes": list(TWIN), "wait": _START}, hear=hear_player)
            started = time.monotonic()
            while not (address and playing.wait(0.1)):
                graph.check()
                if time.monotonic() - started > _START:
                    raise InputError(f"the nodes were not ready after {_START:g} s; see {graph.log}")
            time.sleep(_UNDER_WAY)
        for viewers, limit in LIMITS.items():
            with stage(f"live page with {viewers} browsers", quiet):
                used, seen = _watched(graph, address[0], viewers, seconds)
            graph.check()
            name = f"live page, {viewers} browser{'s' if viewers > 1 else ''}"
            yield Figure(f"{name}, processor", 100.0 * used / seconds, "% of a core", limit, "limit")
            yield Figure(f"{name}, updates of the slowest", seen["fewest"], "Hz", 20.0, "aim", smaller=False)


def _watched(graph: LiveGraph, page: str, viewers: int, seconds: float) -> tuple[float, dict]:
    """Processor seconds of web_view with so many viewers, and what those have seen; they are a process of their own."""
    command = [sys.executable, "-m", "ddh_twin_py.benchmarks.page_viewers", page, str(viewers), str(seconds + 2.0 * _SETTLE)]
    looking = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        time.sleep(_SETTLE)
        before = graph.processor_seconds("web_view")
        time.sleep(seconds)
        used = graph.processor_seconds("web_view") - before
        said, _ = looking.communicate(timeout=60.0)
    finally:
        if looking.poll() is None:
            looking.kill()
            looking.wait()
    if looking.returncode:
        raise InputError(f"the viewers of {page} ended with exit code {looking.returncode}")
    return used, json.loads(said)
