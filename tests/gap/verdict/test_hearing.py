"""What held-out data are asked about one hypothesis."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.verdict.hearing import Hearing
from ddh_twin_py.gap.verdict.unknown import Unknown


def elsewhere(x, there):
    """What is unknown beside a leak whose departure is ``x``, where held-out data are 30 squared deviations better at ``there``."""
    leader = SimpleNamespace(columns=[SimpleNamespace(effect=EFFECTS["pump_1.leakage"])], x=np.array([x]), covariance=np.eye(1) * 1e-4,
                             theta=np.zeros(1), acting=())

    def beside(theta, acting, closely, spread, least):
        moved = any(spread)
        return SimpleNamespace(displaced=0.0, departures=np.array([there if moved else x]), cost=lambda least: 10.0 if moved else 40.0)

    hearing = Hearing(SimpleNamespace(witnesses=SimpleNamespace(summing=())), SimpleNamespace(linearised=None),
                      SimpleNamespace(floor={"flow": 1.0}), SimpleNamespace(beside=beside), np.zeros(1), {"flow": 1.0}, None, {})
    return hearing._elsewhere(Unknown(0.0, [], 0.0, "1"), leader, False)


def test_a_size_that_is_another_in_held_out_data_is_doubted():
    seen = elsewhere(0.1, 0.3)
    assert seen.probability > 0.99 and "3.00 times as large" in seen.notes[-1]


@pytest.mark.filterwarnings("error")
def test_a_departure_of_nothing_has_no_size_that_could_be_another():
    seen = elsewhere(0.0, 0.3)
    assert seen.probability < 0.01 and not seen.notes
