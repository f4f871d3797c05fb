"""The action `diagnose`: a diagnosis of recordings in a process of its own, while the node goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle

from ddh_msgs.action import DiagnoseGap
from ddh_twin_py.bags.case import case_of
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.diagnosis.process import COMMAND, DiagnosisProcess, Outcome
from ddh_twin_py.names import short
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.rig.files import printable

DIAGNOSE_PARAMETERS = (
    Parameter("diagnosis_nice", 10, "How far the process of a diagnosis steps back behind others.", "1", 0, 19),
    Parameter(
        "diagnosis_command", ("",),
        "Command that diagnoses in place of the project's own, with the protocol of diagnosis/process.py; empty: the project's own.",
    ),
)  # fmt: skip
_LOOK_PERIOD = 0.2  # s of wall time
SAYS_AGAIN = 5.0
"""s of wall time after which feedback comes again, also where nothing has changed, so that a client hears that the node is there."""
_LAST_TURNS = 10  # of the executor, in which a client hears of the end


class DiagnoseAction:
    """Serves one goal at a time.

    rclpy wakes a waiting coroutine without pause, so that a goal stays accepted while its process runs and is
    executed, which is to say answered, at its end.
    """

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._process: DiagnosisProcess | None = None
        self._goal: ServerGoalHandle | None = None
        self._told: tuple[float, str] | None = None
        self._told_at = 0.0  # s of wall time
        self._last = ""
        self._server = ActionServer(
            node, DiagnoseGap, "diagnose", execute_callback=_unused, handle_accepted_callback=self._begin,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
        )  # fmt: skip
        node.every(_LOOK_PERIOD, self._look)

    def _begin(self, goal: ServerGoalHandle) -> None:
        request = goal.request
        try:
            case = case_of(list(request.field), request.commissioning or None, request.validation or None,
                           request.rig or self._node.values["rig"] or None)
        except BagError as error:
            given = [path for path in (*request.field, request.commissioning, request.validation, request.rig) if path]
            from_where = "" if all(map(os.path.isabs, given)) else f" (paths are relative to {os.getcwd()}, where the node runs)"
            self._refuse(goal, f"{error}{from_where}")
            return
        if self._process is not None:
            asked = ", ".join(map(str, self._process.case.field))
            self._refuse(goal, f"a diagnosis of {asked} is under way ({100.0 * self._process.done:.0f} %); wait for its end or cancel it, "
                         f"whoever asked for it: ros2 service call {self._server_name()}/_action/cancel_goal action_msgs/srv/CancelGoal")
            return
        given = [word for word in self._node.values["diagnosis_command"] if word]
        self._goal, self._told = goal, None
        self._process = DiagnosisProcess(case, self._node.values["diagnosis_nice"], given or COMMAND)
        self._node.get_logger().info(f"diagnosis of {', '.join(map(str, case.field))} begins")

    def _server_name(self) -> str:
        return self._node.resolve_service_name("diagnose")

    def _refuse(self, goal: ServerGoalHandle, why: str) -> None:
        why = short(printable(" ".join(why.split())))  # paths of a goal may hold anything
        self._node.get_logger().warning(f"diagnose: {why}")
        goal.execute(lambda handle: _answer(handle, handle.abort, Outcome(error=why)))

    def _look(self) -> None:
        process, goal = self._process, self._goal
        if process is None:
            return
        if goal.is_cancel_requested and process.outcome is None:
            process.stop()
        if process.outcome is None:
            self._tell(process, goal)
            return
        self._process = self._goal = None
        outcome = process.outcome
        self._last = outcome.error or outcome.sentence or str(outcome.report.get("verdict", ""))
        self._node.get_logger().info(f"diagnosis: {self._last}")
        goal.execute(lambda handle: _answer(handle, _ending(handle, outcome), outcome))

    def _tell(self, process: DiagnosisProcess, goal: ServerGoalHandle) -> None:
        state, wall = (process.done, process.stage), self._node.wall()
        if state != self._told or wall - self._told_at >= SAYS_AGAIN:
            self._told, self._told_at = state, wall
            goal.publish_feedback(DiagnoseGap.Feedback(done=process.done, stage=process.stage))

    def judge(self, report: Report) -> str:
        """What is under way, or how the last one ended, for `/diagnostics`."""
        process = self._process
        report.add("under way", int(process is not None), "1")
        if process is None:
            return f"last: {self._last}" if self._last else "none was asked for"
        report.add("done", process.done, "1")
        return f"{', '.join(map(str, process.case.field))}: {process.stage}"

    def close(self) -> None:
        """End the process of a diagnosis that is under way and tell who asked for it."""
        if self._process is not None:
            self._process.stop()
            goal, self._process, self._goal = self._goal, None, None
            self._refuse(goal, "the node ends before the diagnosis; ask again once it runs")
            for _ in range(_LAST_TURNS):
                self._node.executor.spin_once(timeout_sec=0.05)
        self._server.destroy()


def _ending(handle: ServerGoalHandle, outcome: Outcome) -> Callable[[], None]:
    """How the goal ends: canceled, failed, or well."""
    if handle.is_cancel_requested:
        return handle.canceled
    return handle.abort if outcome.error else handle.succeed


def _answer(handle: ServerGoalHandle, end: Callable[[], None], outcome: Outcome) -> DiagnoseGap.Result:
    end()
    report = outcome.report
    return DiagnoseGap.Result(
        success=not outcome.error, message=outcome.error, verdict=str(report.get("verdict", "")), sentence=outcome.sentence,
        report=json.dumps(report) if report else "",
    )


def _unused(goal: ServerGoalHandle) -> DiagnoseGap.Result:
    """The server wants a callback; each goal is executed with one of its own."""
    raise NotImplementedError
