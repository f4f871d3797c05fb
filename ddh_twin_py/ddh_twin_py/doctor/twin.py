"""Do the twin's own nodes run beside a machine, and what do they say of themselves."""

from __future__ import annotations

from collections.abc import Sequence

from ddh_twin_py.doctor.check import Check
from ddh_twin_py.doctor.survey import Health, HeardTopic, Survey

GROUP = "twin"
NODES = ("hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor")
OUTPUTS = {"hydraulics/state": "hydraulic_model", "motor/thermal_state": "machine_thermal", "temperature/estimates": "temperature_fusion"}
"""Topics that come with each interval, and the node that publishes them."""
_LEAST_RATE = 10.0  # 1/s of 20, beside a machine in real time
STALE = "stale: "
"""How a node's status of an input begins of which nothing comes."""
_LEVELS = {0: "ok", 1: "warning", 2: "error", 3: "error"}


def check_twin(survey: Survey, namespace: str) -> list[Check]:
    """Nodes, their outputs and their own `/diagnostics`, of the twin in one namespace."""
    running = [name for name in NODES if f"{namespace}/{name}" in survey.nodes]
    if not running:
        return [Check(GROUP, f"{namespace}/", "note", "no node of the twin runs", ", ".join(NODES),
                      f"ddh-twin up --namespace {namespace or '/'} starts them")]
    checks = []
    for name in NODES:
        here = sum(node == f"{namespace}/{name}" for node in survey.nodes)
        if here == 0:
            checks.append(Check(GROUP, f"{namespace}/{name}", "warning", "does not run", "runs", "ddh-twin up restarts nodes that crash"))
        elif here > 1:
            checks.append(Check(GROUP, f"{namespace}/{name}", "error", f"runs {here} times", "once", "stop all but one"))
    for topic, node in OUTPUTS.items():
        heard = survey.topics.get(f"{namespace}/{topic}")
        if node in running:
            checks.append(_output(f"{namespace}/{topic}", heard, survey.seconds))
    own = [status for status in survey.health if status.name.split(":")[0] in {f"{namespace}/{name}".lstrip("/") for name in running}]
    bad = [status for status in own if status.level]
    stale = [status for status in bad if status.message.startswith(STALE)]
    stale = stale if len(stale) > 1 else []
    checks += [Check(GROUP, status.name, _LEVELS.get(status.level, "error"), status.message, "",
                     "see its page in docs/nodes, and its values in /diagnostics") for status in bad if status not in stale]
    checks += _stale(stale)
    if own and not bad:
        checks.append(Check(GROUP, "/diagnostics", "ok", f"{len(own)} statuses, all well", ""))
    elif not own:
        checks.append(Check(GROUP, "/diagnostics", "note", f"nothing in {survey.seconds:.0f} s", "once a second",
                            "listen longer: --seconds 10"))
    return checks


def _stale(statuses: Sequence[Health]) -> list[Check]:
    """One line of all inputs that nodes call stale."""
    if not statuses:
        return []
    nodes, inputs = (list(dict.fromkeys(part)) for part in zip(*(status.name.split(": ", 1) for status in statuses), strict=True))
    return [Check(GROUP, "stale inputs", _LEVELS.get(max(status.level for status in statuses), "error"),
                  f"{', '.join(inputs)}: of {', '.join(nodes)}", "", "nothing comes of these, or too late: see what is said of the "
                  "machine's topics and of messages between processes, and how long in /diagnostics")]


def _output(topic: str, heard: HeardTopic | None, seconds: float) -> Check:
    right, count = "20 per second", heard.arrived.size if heard else 0
    if heard is None or count < 2:
        return Check(GROUP, topic, "warning", f"{count} messages in {seconds:.0f} s", right,
                     "the node waits for telemetry or for other nodes: see its status in /diagnostics")
    rate = heard.rate()
    if rate < _LEAST_RATE:
        return Check(GROUP, topic, "warning", f"{rate:.3g} per second", right,
                     "the computer is too slow or busy, or a recording is played slowly")
    return Check(GROUP, topic, "ok", f"{rate:.3g} per second", right)
