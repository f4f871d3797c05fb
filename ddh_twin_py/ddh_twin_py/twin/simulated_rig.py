"""A rig made of the model, for telemetry without a machine.

Its parameters are drawn within the sheet's tolerances and its sensors have the sheet's noise,
offsets and lags, so that a twin that listens to it is never fed its own output. The same seed
and duty give the same rig and the same samples, in whichever process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import holding_pressure, rod_travel
from ddh_twin_py.physics.free_run import SAMPLED, free_run_sampled, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, POSITION
from ddh_twin_py.physics.thermal_network import N, capacities
from ddh_twin_py.rig import Rig, load_rig
from ddh_twin_py.telemetry.recording import Recording, RigInfo, drive_stream, hydraulic_stream, temperature_stream
from ddh_twin_py.twin.duty import Duty, DutyCommand, DutyError, check_duration, check_for_rig, load_duty
from ddh_twin_py.twin.intervals import command_size
from ddh_twin_py.twin.temperature_sensors import INNER_SENSORS, SENSORS, all_sensed

CONTROL_PERIOD = 0.01
"""s between two samples of drive and pressures."""
TEMPERATURE_PERIOD = 0.5
"""s between two samples of a temperature sensor."""
CHUNK = 1.0
"""s of telemetry handed over at a time."""
_SUBINTERVALS = 4
_STEP = 2.5e-4  # s, finer than the twin's own
_PRESSED = 0.8  # share of the load that pressure carries at the start; the seals hold the rest
_INNER = np.array([name in INNER_SENSORS for name in SENSORS])
_PRESSURES = ("pressure_piston_side", "pressure_rod_side")


def simulate(rig_path: str | Path | None, duty_path: str | Path, seed: int, duration: float | None = None) -> Iterator[Recording]:
    """Telemetry of a simulated rig in chunks of `CHUNK` seconds, epoch 0, until duty or duration end.

    Args:
        rig_path: rig file whose tolerances the rig is drawn from; None takes the reference sheet.
        duty_path: see `duty`. seed: of the rig and its noise. duration: s; None: as the duty says.

    Raises:
        RigError, DutyError: for files that cannot be used.
    """
    check_duration(duration, "simulation")
    return SimulatedRig(load_rig(rig_path), load_duty(duty_path), seed).run(duration)


@dataclass(frozen=True)
class Surroundings:
    """What a simulated rig meets that no duty tells.

    Attributes:
        start: K above ambient at the beginning, (N,). heat: W into each node, (N,), at a time in s.
        lags: s, of each temperature sensor in the order of `SENSORS`; None: the drawn rig's for all.
    """

    start: np.ndarray
    heat: Callable[[float], np.ndarray]
    lags: np.ndarray | None = None


class SimulatedRig:
    """One rig drawn from a sheet, doing a duty.

    Args:
        surroundings: what no duty tells. exactly: the rig is that of the sheet, with the sensors' zeros that the sheet knows and no others.
        noise_seed: of the samples' noise alone; None: the seed is that of the noise too.

    Attributes:
        rig: the rig as drawn; a test may look, a twin may not. info: as it is announced, by the name of its file, else by its seed.

    Raises:
        DutyError: for a duty that is not within the rig's stroke, or a negative seed.
    """

    def __init__(self, sheet: Rig, duty: Duty, seed: int, surroundings: Surroundings | None = None, exactly: bool = False,
                 noise_seed: int | None = None) -> None:
        if seed < 0:
            raise DutyError(f"the seed of the simulated rig is {seed}, a whole number from 0 on is needed")
        check_for_rig(duty, sheet)
        rng = np.random.default_rng(seed)
        self.rig = (sheet if exactly else sheet.draw(rng)).declaring(duty.payload)
        self.info = RigInfo(sheet.rig_id if sheet.named else f"simulated_{seed}", sheet.oil_grade, duty.payload)
        self._duty = duty
        self._rng = rng
        self._surroundings = surroundings
        self._sheet = sheet
        pressure, temperature = sheet.sensors["pressure"], sheet.sensors["temperature"]
        self._pressure_offset = rng.normal(0.0, pressure.offset_tolerance, 2)
        self._temperature_offset = rng.normal(0.0, temperature.offset_tolerance, len(SENSORS) + 1)
        for offsets, sensors in ((self._pressure_offset, _PRESSURES), (self._temperature_offset, SENSORS)):
            for i, name in enumerate(sensors):
                known = sheet.quantities[f"measurement.{name}_offset"]
                if exactly or known.value or known.standard_deviation:  # of a fitted sheet; drawn with the rest
                    offsets[i] = self.rig[f"measurement.{name}_offset"]
        if noise_seed is not None:
            self._rng = np.random.default_rng([noise_seed, 1])

    def truth(self) -> np.ndarray:
        """Temperatures of every node now, K, (N,)."""
        return self._temperature.copy()

    def run(self, duration: float | None = None) -> Iterator[Recording]:
        """Telemetry chunk by chunk; see `simulate`."""
        duty, parameters = self._duty, self.rig.parameters
        record = parameters[0]
        rod_speed_per_rad = rod_travel(record)
        self._temperature = np.full(N, np.interp(0.0, duty.ambient_time, duty.ambient))
        met, capacity = self._surroundings, np.empty(N)
        if met is not None:
            self._temperature += met.start
        top_share = self.rig["tank.top_share"]
        reading = all_sensed(self._temperature, top_share)
        state = np.zeros(len(HYDRAULIC_STATES))
        settle(parameters, state, duty.start_position, _PRESSED * holding_pressure(duty.start_position, 0.0, record), 0.0)
        points, temperatures = np.zeros(_SUBINTERVALS, OPERATING_DTYPE), np.empty((_SUBINTERVALS, N))
        nowhere = np.full(_SUBINTERVALS, np.nan)
        end, sample = np.array([CONTROL_PERIOD - 1e-9]), np.zeros((1, len(SAMPLED)))
        program, at, command = DutyCommand(duty), 0, 0.0
        # sheet values the drive knows: it reports torque as the sheet's constant times current
        torque_constant = self._sheet["motor.torque_constant"]
        slower = np.where(_INNER, 1.0, self.rig["measurement.surface_lag_ratio"])
        lag = self.rig["sensors.temperature.time_constant"] * slower if met is None or met.lags is None else met.lags
        contact = np.where(_INNER, 0.0, self.rig["measurement.surface_contact"])
        per_chunk, per_temperature = round(CHUNK / CONTROL_PERIOD), round(TEMPERATURE_PERIOD / CONTROL_PERIOD)
        while not program.finished and (duration is None or at * CONTROL_PERIOD < duration):
            drive, hydraulic, thermal, times = [], [], [], []
            added = met.heat(at * CONTROL_PERIOD) if met is not None else None
            for _ in range(per_chunk):
                now = at * CONTROL_PERIOD
                air = float(np.interp(now, duty.ambient_time, duty.ambient))
                if at % per_temperature == 0:
                    times.append(now)
                    around = air + self.rig["surroundings.enclosure_rise"]
                    thermal.append(np.append(reading + contact * (around - reading), air))
                next_command = program.step(state[POSITION], rod_speed_per_rad, CONTROL_PERIOD)
                edges = np.linspace(command, next_command, command_size(_SUBINTERVALS))
                command = next_command
                free_run_sampled(parameters, state, self._temperature, edges, np.full(_SUBINTERVALS, air),
                                 CONTROL_PERIOD / _SUBINTERVALS, _STEP, nowhere, points, temperatures, end, sample)
                if added is not None:
                    capacities(parameters, state[POSITION], capacity)
                    self._temperature += CONTROL_PERIOD * added / capacity
                last = points[-1]
                speed, current, piston_side, rod_side, position, velocity = sample[0]
                drive.append((next_command, speed, torque_constant * current, current, last["voltage"], last["electrical_power"]))
                hydraulic.append((piston_side, rod_side, position, velocity))
                reading += (all_sensed(self._temperature, top_share) - reading) * (1.0 - np.exp(-CONTROL_PERIOD / lag))
                at += 1
            yield self._measure(np.array(drive), np.array(hydraulic), np.array(thermal), np.array(times), at)

    def _measure(self, drive: np.ndarray, hydraulic: np.ndarray, thermal: np.ndarray, times: np.ndarray, at: int) -> Recording:
        """Samples with noise, offsets and jitter."""
        rng, noise = self._rng, {name: spec.noise for name, spec in self._sheet.sensors.items()}
        n = drive.shape[0]
        when = (at - n + 1 + np.arange(n)) * CONTROL_PERIOD
        current_noise = rng.normal(0.0, noise["current"], n)
        drive[:, [2, 3, 5]] *= self.rig["measurement.current_gain"]
        drive[:, 1] += rng.normal(0.0, noise["speed"], n)
        drive[:, 2] += self._sheet["motor.torque_constant"] * current_noise
        drive[:, 3] += current_noise
        drive[:, 4] += rng.normal(0.0, noise["voltage"], n)
        drive[:, 5] += rng.normal(0.0, noise["electrical_power"], n)
        hydraulic[:, 1] *= self.rig["measurement.pressure_rod_side_gain"]
        hydraulic[:, 2:] *= self.rig["measurement.rod_position_scale"]
        hydraulic[:, :2] += self._pressure_offset + rng.normal(0.0, noise["pressure"], (n, 2))
        hydraulic[:, 2] += rng.normal(0.0, noise["rod_position"], n)
        hydraulic[:, 3] += rng.normal(0.0, noise["rod_velocity"], n)
        jitter = rng.uniform(0.0, 4.0e-4, (2, n))
        late = 5.0e-4 + self.rig["measurement.time_skew"]
        thermal = thermal + self._temperature_offset + rng.normal(0.0, noise["temperature"], thermal.shape)
        temperatures = {name: temperature_stream(times + 1.0e-3 * (i + 1), thermal[:, i]) for i, name in enumerate([*SENSORS, "ambient"])}
        return Recording(
            path="simulated rig", epoch_ns=0, rig=self.info, drive=drive_stream(when + jitter[0], drive),
            hydraulic=hydraulic_stream(when + jitter[1] + late, hydraulic), temperatures=temperatures, findings=[],
        )
