"""`ddh-twin view`: the live page, beside a machine or of a recording that is played."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import threading
import time

from ddh_twin_py.cli.arguments import (
    RATE,
    InputError,
    add_json,
    add_quiet,
    add_rig,
    add_verb,
    kept_file,
    namespace,
    output_file,
    refuse_missing,
    whole,
)

_EXAMPLE = """\
  ddh-twin view                                   what runs in the namespace /ddh
  ddh-twin view bags/paper_cycle --rate 5         a recording, played through the twin's nodes
  ddh-twin view --host 0.0.0.0 --namespace /rig_7  for other machines too, with a token"""
_PAGE = re.compile(r"page at (\S+)")
_START = 90.0  # s; kernels that are compiled for the first time take long
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "view", "a live page of everything that the twin knows, in the browser",
        "Serves the page and says where it is. Beside a machine or a simulated rig it shows what runs there. With BAG it plays\n"
        "the recording through nodes of its own, in a ROS 2 domain of their own, with pause, seek and rate on the page. The page\n"
        "is served to this machine alone, unless --host says otherwise; then it needs a token. Ctrl-C ends it.",
        _EXAMPLE,
    )  # fmt: skip
    parser.add_argument("bag", metavar="BAG", nargs="?", help="recording to play")
    parser.add_argument("--rate", type=RATE, default=None, help="speed against real time, with BAG (default 1); 0 is as fast as it goes")
    parser.add_argument("--paused", action="store_true", help="wait for somebody to press play, with BAG")
    parser.add_argument("--namespace", metavar="NS", default="/ddh", help="of the rig (default /ddh)")
    parser.add_argument(
        "--host", metavar="ADDRESS", default="127.0.0.1", help="address to serve at (default 127.0.0.1); 0.0.0.0: all of this machine",
    )
    parser.add_argument("--port", type=whole(0, 65535), default=8420, help="port (default 8420); 0 takes any that is free")
    parser.add_argument("--token", default="", help="what a browser must know; made up where it is needed and not given")
    add_rig(parser)
    parser.add_argument("--normal-file", metavar="FILE", type=kept_file,
                        help="normal levels of the running test of a gap, with BAG; see ddh-twin up")
    parser.add_argument("--no-browser", action="store_true", help="only say where the page is")
    add_json(parser, "write where the page is and what it shows; - is standard output")
    add_quiet(parser, "the page's address alone")
    parser.add_argument("--log", metavar="FILE", type=output_file, default="out/view.log", help="what the nodes say (default out/view.log)")


def run(args: argparse.Namespace) -> int:
    """Start the nodes, say where the page is, stay until Ctrl-C."""
    from ddh_twin_py.bags.folder import open_folder
    from ddh_twin_py.cli.console import put_json
    from ddh_twin_py.cli.live_graph import LiveGraph
    from ddh_twin_py.cli.page_port import refuse_taken

    if args.rig:
        from ddh_twin_py.rig import load_rig

        refuse_missing("--rig", args.rig)
        load_rig(args.rig)  # or each node would refuse it by itself
    if args.bag:
        open_folder(args.bag)
    given = {"rate": args.rate is not None, "normal_file": args.normal_file is not None, "paused": args.paused}
    for option, was in given.items():
        if was and not args.bag:
            raise InputError(f"--{option.replace('_', '-')} is for a recording, and none is named")
    refuse_taken(args.host, args.port, f"--port {args.port}", "choose another, or 0 for any free one")
    page: list[str] = []
    there = threading.Event()

    def hear(line: str) -> None:
        if found := _PAGE.search(line):
            page.append(found[1])
            there.set()

    with LiveGraph(args.log, namespace(args.namespace), own_domain=bool(args.bag)) as graph, contextlib.suppress(KeyboardInterrupt):
        graph.start("web_view", {"host": args.host, "port": args.port, "token": args.token, "rig": str(args.rig or "")}, hear)
        for node, parameters in _played(args).items():
            graph.start(node, parameters)
        started = time.monotonic()
        while not there.wait(0.1):
            graph.check()
            if time.monotonic() - started > _START:
                raise InputError(f"no page after {_START:g} s; see {args.log}")
        if args.json:
            put_json(args.json, {
                "page": page[0], "namespace": graph.namespace, "recording": args.bag, "ros_domain": _domain(graph.domain), "log": args.log,
            })  # fmt: skip
        if args.json != "-":
            print(f"page: {page[0]}", flush=True)
            if not args.quiet:
                print(f"{_what(args, graph.domain)}; Ctrl-C ends it", flush=True)
        if not args.no_browser:
            _open(page[0])
        while True:
            graph.check()
            time.sleep(0.2)
    return 0


def _played(args: argparse.Namespace) -> dict[str, dict[str, object]]:
    """Nodes that play a recording through the twin; none where there is no recording."""
    from ddh_twin_py.cli.twin_nodes import FLUSH_AFTER, MODELS, TWIN, played_topics

    if not args.bag:
        return {}
    shared = {"use_sim_time": True} | ({"rig": str(args.rig)} if args.rig else {})
    nodes: dict[str, dict[str, object]] = {node: dict(shared) for node in TWIN}
    for node in MODELS:
        nodes[node]["flush_after"] = FLUSH_AFTER
    if args.normal_file:
        nodes["gap_monitor"]["normal_file"] = str(args.normal_file)
    rate = 1.0 if args.rate is None else args.rate
    nodes["bag_player"] = {
        "bag": str(args.bag), "rate": rate, "paused": args.paused, "exit_at_end": False, "wait_for_nodes": list(TWIN), "wait": _START,
        "topics": played_topics(args.bag),
    }  # fmt: skip
    return nodes


def _what(args: argparse.Namespace, domain: int | None) -> str:
    if args.bag:
        return f"{args.bag} plays in ROS 2 domain {domain}, log {args.log}"
    return f"it shows what runs in {namespace(args.namespace)}, ROS 2 domain {_domain(domain)}"


def _domain(own: int | None) -> int:
    return int(os.environ.get("ROS_DOMAIN_ID") or 0) if own is None else own


def _open(url: str) -> None:
    """In the person's browser, where there is a screen."""
    import sys
    import webbrowser

    if sys.platform != "linux" or any(os.environ.get(name) for name in _DISPLAYS):
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(url)
