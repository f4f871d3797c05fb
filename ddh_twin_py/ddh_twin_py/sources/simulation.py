"""Source: a simulated rig that follows a duty file, with the sheet's noise and its own parameters."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from ddh_twin_py.sources.protocol import Option, Samples, SourceError
from ddh_twin_py.telemetry.recording import Recording

NAME = "simulation"
OPTIONS = (
    Option("duty", "", "Duty file (YAML), or the name of one of the project's own such as mixed: what the rig is asked to do."),
    Option("seed", 1, "Which rig: its parameters within tolerance and its noise. The same seed is the same rig.", lowest=0),
    Option("rig", "", "Rig sheet that the rig is drawn from; empty: the reference sheet."),
    Option("duration", 0.0, "Where to end; 0: as the duty says.", "s", 0.0),
)


class SimulationSource:
    """Telemetry computed while it is asked for; two processes with the same options compute the same."""

    start_ns = 0
    seekable = True

    def __init__(self, rig: str | None, duty: Path, seed: int, duration: float | None) -> None:
        self._arguments = rig, duty, seed, duration
        self.duration = None  # known once the duty has been run to its end
        self.rig = self._first().rig

    def _first(self) -> Recording:
        return next(iter(self._run()))

    def _run(self) -> Iterator[Recording]:
        from ddh_twin_py.twin.simulated_rig import simulate  # the models are loaded only where they are run

        return simulate(*self._arguments)

    def batches(self, topics: Collection[str]) -> Iterator[Mapping[str, Samples]]:
        end = 0.0
        for chunk in self._run():
            end = chunk.span[1]
            yield {
                topic: Samples(stream.time, stream.stamps(0), stream.values)
                for topic, stream in chunk.streams()
                if topic in topics
            }
        self.duration = end


def open_source(options: Mapping[str, object]) -> SimulationSource:
    """Read the files and start the rig. Raises SourceError."""
    from ddh_twin_py.rig import RigError
    from ddh_twin_py.twin.duty import DutyError
    from ddh_twin_py.twin.duty_file import duty_file

    if not options.get("duty"):
        raise SourceError("simulation.duty is empty; it names the duty file to follow")
    try:
        return SimulationSource(
            str(options.get("rig") or "") or None, duty_file(str(options["duty"])), int(options.get("seed", 1)),
            float(options.get("duration") or 0.0) or None,
        )  # fmt: skip
    except (RigError, DutyError) as error:
        raise SourceError(str(error)) from None
