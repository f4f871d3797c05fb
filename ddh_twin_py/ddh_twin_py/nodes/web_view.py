"""Node: the live page, everything that the twin knows in a browser."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray

from ddh_msgs.msg import GapStatus, LimitPrediction, PlayerStatus, RigInfo
from ddh_twin_py.names import in_namespace
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.inputs import Input, Inputs
from ddh_twin_py.nodes.base.node_base import TwinNode, run
from ddh_twin_py.nodes.base.parameters import NodeError, Parameter
from ddh_twin_py.nodes.base.twin_parameters import RIG, rig_path
from ddh_twin_py.nodes.feeds.page_documents import gap_status_document, limits_document, page_document, player_document, rig_document
from ddh_twin_py.nodes.feeds.page_inputs import page_rows, telemetry_rows
from ddh_twin_py.nodes.feeds.telemetry_feed import message_type
from ddh_twin_py.nodes.player.player_client import PlayerClient
from ddh_twin_py.nodes.player.player_watch import GONE, PLAYER
from ddh_twin_py.nodes.tasks import health
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, DRIVE_TYPE, RIG_TOPIC
from ddh_twin_py.web.access import LOCAL, PORT
from ddh_twin_py.web.board import Board
from ddh_twin_py.web.health import Health, Sensors
from ddh_twin_py.web.server import PageServer, ServerError
from ddh_twin_py.web.streams import STREAMS

EXPECTED = ("hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor")
_DEPTH = 400  # messages; what a busy page misses is in nobody's way
_SELDOM = 4  # updates between two looks at what comes now and then
_SECOND = 1.0  # s of wall time between two looks at the health
_SETTLE = 0.5  # s of wall time without a sample after which the last ones are shown as they are


class WebView(TwinNode):
    """Serves the page; takes everything best effort, so that no other node ever waits for it."""

    PARAMETERS = (
        Parameter("host", LOCAL, "Address to serve the page at; 0.0.0.0 is every one of this machine, and needs a token."),
        Parameter("port", PORT, "Port; 0 takes any that is free, the log says which.", "", 0, 65535),
        Parameter(
            "token", "",
            "What a browser must know to see the page. Empty: none at an address that only this machine reaches, else one that is "
            "made up and logged.",
        ),
        Parameter("rate", 20.0, "Updates of the page for each second of wall time.", "Hz", 1.0, 50.0),
        RIG,
    )  # fmt: skip

    def __init__(self) -> None:
        super().__init__("web_view")
        values = self.values
        self._board = Board()
        self._player = PlayerClient(self)
        self._streams = [stream for stream in STREAMS if stream.raw]
        namespace = self.get_namespace().strip("/")
        self._prefix = f"{namespace}/" if namespace else ""  # of what the rig's nodes are called in diagnostics
        self._health = Health(f"{self._prefix}{name}" for name in EXPECTED)
        self._sensors = Sensors(stream.topic for stream in self._streams)
        self._board.put("page", page_document(self.get_namespace(), load_rig(rig_path(values["rig"]))))
        self._inputs = Inputs(self)
        loose = qos.stream(reliable=False, depth=_DEPTH)
        self._raw = [(stream, self._inputs.add(stream.topic, message_type(stream.topic), loose)) for stream in self._streams]
        self._outputs = [(self._inputs.add(topic, rows.message_type, loose), rows) for topic, rows in page_rows().items()]
        self._diagnostics = self._inputs.add(health.TOPIC, DiagnosticArray, qos.stream(reliable=False, depth=_DEPTH))
        self._documents = [
            (self._inputs.add(RIG_TOPIC, RigInfo, qos.LATCHED), "rig", rig_document),
            (self._inputs.add("temperature/limits", LimitPrediction, loose), "limits", self._limits),
            (self._inputs.add("gap/status", GapStatus, qos.STATUS), "gap", gap_status_document),
        ]
        self._status = self._inputs.add(f"{PLAYER}/status", PlayerStatus, qos.LATCHED)
        self._updates = 0
        self._looked_at = 0.0
        self._told: list[str] = []
        self._server = PageServer(self._board, values["host"], values["port"], values["token"], self._player.ask, self._health.values)
        try:
            self._server.start()
        except ServerError as error:
            raise NodeError(f"parameters host and port: {error}") from None
        self.get_logger().info(f"page at {self._server.access.url}")
        self._judge = health.Health(self)
        self._judge.add("page", self._judge_page)
        self.every(1.0 / values["rate"], self._update)

    # --- what comes in -----------------------------------------------------------------------

    def _update(self) -> None:
        wall = self.wall()
        self._player.work()
        for stream, entry in self._raw:
            self._take_samples(stream, entry, wall)
        for entry, rows in self._outputs:
            messages = self._inputs.take(entry, wall)
            if messages:
                for name, stamps, values in rows.parse(messages):
                    self._board.take(name, stamps, values)
                self._inputs.leave_out(entry, rows.unreadable, rows.why)
        for message in self._inputs.read(self._status, self._inputs.take(self._status, wall))[-1:]:
            self._board.put("player", player_document(message))
        self._updates += 1
        if self._updates % _SELDOM == 0:
            self._take_documents(wall)
        if wall - self._looked_at >= _SECOND:
            self._looked_at = wall
            self._look(wall)
        self._server.show()

    def _take_samples(self, stream, entry: Input, wall: float) -> None:
        messages = self._inputs.take(entry, wall)
        if not messages:
            if entry.arrived is not None and wall - entry.arrived > _SETTLE:
                self._board.settle(stream.name)
            return
        stamps, values = telemetry_rows(stream.topic, messages)
        if stamps.size:
            self._board.take(stream.name, stamps, values)
            last = dict(zip(stream.fields, values[-1].tolist(), strict=True))
            self._sensors.arrived(stream.topic, len(messages), last, stamps[-1] * 1e-9, wall)

    def _take_documents(self, wall: float) -> None:
        for entry, key, document in self._documents:
            for message in self._inputs.read(entry, self._inputs.take(entry, wall))[-1:]:
                self._board.put(key, document(message))
        own = (message for message in self._inputs.take(self._diagnostics, wall) if self._prefix.encode() in message)
        for message in self._inputs.read(self._diagnostics, own):
            self._take_diagnostics(message, wall)

    def _limits(self, message: LimitPrediction) -> dict:
        return limits_document(message, self._health.values(f"{self._prefix}temperature_fusion: limits"))

    def _take_diagnostics(self, message: DiagnosticArray, wall: float) -> None:
        for status in message.status:
            if status.name.startswith(self._prefix) and "/" not in status.name.partition(":")[0].removeprefix(self._prefix):
                values = ((entry.key, entry.value) for entry in status.values)
                self._health.take(status.name, status.level[0], status.message, values, wall)

    # --- health ------------------------------------------------------------------------------

    def _look(self, wall: float) -> None:
        player = self._board.document("player")
        if player is not None and (self._status.arrived is None or wall - self._status.arrived > GONE):
            self._board.put("player", None)
            player = None
        still = player is not None and (player["paused"] or player["ended"] or player["waiting"])
        self._board.put("elsewhere", self._elsewhere())
        self._board.put("health", self._health.document(wall))
        self._board.put("sensors", self._sensors.document(self._health, wall, still))

    def _elsewhere(self) -> list[str]:
        """Other namespaces in which a drive speaks, where nothing has come in this one."""
        if any(entry.arrived is not None for _, entry in self._raw):
            return []
        own = in_namespace(self.get_namespace(), DRIVE_TOPIC)
        found = [name.removesuffix(DRIVE_TOPIC) for name, types in self.get_topic_names_and_types() if name.endswith(f"/{DRIVE_TOPIC}")
                 and name != own and DRIVE_TYPE in types and self.count_publishers(name)]
        found = sorted(name.rstrip("/") or "/" for name in found)
        if found and found != self._told:
            self.get_logger().warning(f"nothing comes in {self.get_namespace()}, but a drive speaks in {', '.join(found)}")
            self._told = found
        return found

    def _judge_page(self, report: health.Report) -> str:
        report.add("browsers", self._server.viewers, "1")
        report.add("frames left out for slow browsers", self._server.skipped, "1")
        report.add("messages left out", sum(entry.rejected for entry in self._inputs.all.values()), "1")
        report.add("backward jumps", self._board.jumps, "1")
        return "is served"

    def close(self) -> None:
        self._server.stop()


def main(args: list[str] | None = None) -> int:
    return run(WebView, args)
