"""Compiles what most tests need into the cache, in two processes side by side; `scripts/test.sh` runs it before the workers begin.

Each worker, and each node that it starts, would else compile the same kernels for itself.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def of_the_models() -> None:
    """Screening, soft sensor, free run, motor; what the fusion needs is there by then."""
    from ddh_twin_py.bags.reader import read_recording
    from ddh_twin_py.estimation.replay import replay
    from ddh_twin_py.rig import load_rig

    replay(read_recording(ROOT / "bags" / "paper_cycle").between(0.0, 5.0), load_rig(), smooth=True)


def of_fusion_and_plant() -> None:
    """The filter without models, then the independent plant."""
    from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
    from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
    from ddh_twin_py.estimation.sensors import SENSORS
    from ddh_twin_py.rig import load_rig

    from support.drifted import recorded

    TemperatureFusion(load_rig()).advance(FusionInputs.unknown(20), [Reading(0, SENSORS[0], 296.0)])
    recorded(10.0)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests"))
    with ProcessPoolExecutor(2) as pool:
        for made in [pool.submit(of_the_models), pool.submit(of_fusion_and_plant)]:
            made.result()
