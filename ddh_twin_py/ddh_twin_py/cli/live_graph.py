"""A graph of the twin's nodes as processes, as a rule in a ROS 2 domain of their own, for as long as one piece of work takes.

Unlike `ddh-twin up` nothing is restarted: a node that dies ends the work, with its last words.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path

from ddh_twin_py.cli.arguments import InputError
from ddh_twin_py.cli.parameter_yaml import parameter_yaml

_DOMAINS = range(1, 102)
"""Above, the ports of a domain lie in the range that Linux hands out to clients."""
_GRACE = 6.0  # s that a node has to stop
_LAST_WORDS = 6  # lines
_DIE_WITH_PARENT = "import ctypes, sys; ctypes.CDLL(None).prctl(1, 15)"  # also where we are killed outright


class LiveGraph:
    """Processes of nodes; a context manager that stops them all, whatever happens.

    Args:
        log: file for what all nodes say. namespace: of the rig. own_domain: a ROS 2 domain that nobody else uses; else
            the one that the environment names.
    """

    def __init__(self, log: str | Path, namespace: str = "/ddh", own_domain: bool = True) -> None:
        self.log = Path(log)
        self.namespace = namespace
        self.domain = free_domain() if own_domain else None
        self._processes: dict[str, subprocess.Popen] = {}
        self._readers: list[threading.Thread] = []
        self._last: dict[str, deque[str]] = {}
        self._listeners: dict[str, Callable[[str], None]] = {}
        self._lock = threading.Lock()
        self._before: list[tuple[int, object]] = []  # signals and what they did before

    def __enter__(self) -> LiveGraph:
        self.log.parent.mkdir(parents=True, exist_ok=True)
        self._file = self.log.open("w", encoding="utf-8")
        if threading.current_thread() is threading.main_thread():
            self._before = [(signal.SIGTERM, signal.signal(signal.SIGTERM, _leave))]
            if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:  # as of a job of a script: who sends one means it
                self._before.append((signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler)))
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
        self._file.close()
        for number, handler in self._before:
            signal.signal(number, handler)

    def start(
        self, node: str, parameters: Mapping[str, object] | None = None, hear: Callable[[str], None] | None = None
    ) -> None:
        """Start one node; `hear` is told each line that it says."""
        code = f"{_DIE_WITH_PARENT}; from ddh_twin_py.nodes.{node} import main; sys.exit(main())"
        command = [sys.executable, "-c", code, "--ros-args", "-r", f"__ns:={self.namespace}"]
        for name, value in (parameters or {}).items():
            command += ["-p", f"{name}:={parameter_yaml(value)}"]
        environment = {**os.environ, "PYTHONUNBUFFERED": "1", "RCUTILS_COLORIZED_OUTPUT": "0"}
        if self.domain is not None:
            environment |= {"ROS_DOMAIN_ID": str(self.domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
            for name in ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS"):
                environment.pop(name, None)
        process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace", start_new_session=True,  # Ctrl-C reaches us alone; we stop the nodes
        )
        self._processes[node] = process
        self._last[node] = deque(maxlen=_LAST_WORDS)
        if hear is not None:
            self._listeners[node] = hear
        reader = threading.Thread(target=self._read, args=(node, process), daemon=True)
        reader.start()
        self._readers.append(reader)

    def check(self, ended: str = "") -> None:
        """Raise InputError where a node has died; the node `ended` may have done its work."""
        for node, process in self._processes.items():
            code = process.poll()
            if code is None or node == ended and code == 0:
                continue
            time.sleep(0.2)  # its last lines are on the way
            raise InputError(f"node {node} ended with {_code(code)}: {self.last_words(node)}; see {self.log}")

    def alive(self, node: str) -> bool:
        """Whether the process runs."""
        return self._processes[node].poll() is None

    def processor_seconds(self, *nodes: str) -> float:
        """Processor time that nodes, all where none is named, have taken so far, s; of those that run."""
        total = 0.0
        for process in (self._processes[name] for name in nodes or self._processes):
            try:
                fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            total += (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        return total

    def last_words(self, node: str) -> str:
        """What matters most of the last lines of a node: an error if there is one."""
        lines = list(self._last[node])
        errors = [line for line in lines if "FATAL" in line or "ERROR" in line or "rror:" in line]
        return (errors or lines or ["it said nothing"])[-1].strip()

    def stop(self, *nodes: str) -> None:
        """Stop nodes, all where none is named: first asked, then made to."""
        chosen = [(name, self._processes[name]) for name in (nodes or self._processes)]
        for _, process in chosen:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + _GRACE
        for _, process in chosen:
            try:
                process.wait(max(0.05, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if not nodes:
            for reader in self._readers:
                reader.join(1.0)

    def _read(self, node: str, process: subprocess.Popen) -> None:
        for line in process.stdout:
            with self._lock:
                self._last[node].append(line)
                if not self._file.closed:
                    self._file.write(f"{node}: {line}")
                    self._file.flush()
            if node in self._listeners:
                self._listeners[node](line)
        process.stdout.close()


def _leave(number: int, frame: object) -> None:
    """SIGTERM: leave through the context managers, so that the nodes are stopped."""
    raise SystemExit(128 + number)


def free_domain() -> int:
    """A ROS_DOMAIN_ID that nobody on this machine uses, by the port that its first participant takes."""
    domains = list(_DOMAINS)
    random.SystemRandom().shuffle(domains)
    for domain in domains:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10))
            except OSError:
                continue
        return domain
    raise InputError(f"all ROS 2 domains from {_DOMAINS.start} to {_DOMAINS.stop - 1} are in use on this machine")


def _code(code: int) -> str:
    return f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
