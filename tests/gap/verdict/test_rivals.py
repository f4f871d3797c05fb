"""Held-out data that speak against the leader may leave a rival that the field recording holds for nearly as good."""

import pytest
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.verdict.rivals import next_believed
from ddh_twin_py.gap.verdict.unknown import UNLISTED, Unknown

FAN, MOUNT, SUN = ("tank.cooling",), ("tank.mount_conduction",), ("ambient.solar_load",)


def found(**probability):
    ids = {"fan": FAN, "mount": MOUNT, "sun": SUN, "none": ()}
    known = {ids[name]: p for name, p in probability.items()}
    return Found(None, known, dict.fromkeys(known, "fitted"))


def doubt(probability):
    return Unknown(probability, [], 0.0, "1")


def hearing(asked, **said):
    def hear(ids):
        asked.append(ids)
        return doubt({MOUNT: said.get("mount", 0.9), SUN: said.get("sun", 0.9)}[ids])

    return hear


def test_a_rival_that_held_out_data_leave_alone_leads_instead():
    after, unknown = next_believed(found(fan=0.88, mount=0.11, none=0.01), doubt(0.76), hearing([], mount=UNLISTED))
    assert after.leader == MOUNT and sum(after.probability.values()) == pytest.approx(1.0)
    factor = 0.24 / 0.76 * UNLISTED / (1.0 - UNLISTED)
    assert after.probability[FAN] / after.probability[MOUNT] == pytest.approx(factor * 0.88 / 0.11)
    assert unknown.probability == pytest.approx(UNLISTED / (UNLISTED + 0.11 + factor * 0.89))
    assert "speak against tank.cooling" in unknown.notes[-1] and "not against tank.mount_conduction" in unknown.notes[-1]


@pytest.mark.parametrize(("case", "of_leader", "mount"), [
    ({"fan": 0.88, "mount": 0.11, "none": 0.01}, 0.4, UNLISTED),  # held-out data do not speak against the leader
    ({"fan": 0.88, "mount": 0.11, "none": 0.01}, 0.76, 0.8),  # nor for the rival
    ({"fan": 0.95, "mount": 0.04, "none": 0.01}, 0.99, UNLISTED),  # which is no likelier than something unlisted
    ({"none": 0.6, "fan": 0.3, "mount": 0.1}, 0.99, UNLISTED),  # and no effect has a say of its own
])  # fmt: skip
def test_else_all_stays_as_it_is(case, of_leader, mount):
    was, unknown = found(**case), doubt(of_leader)
    assert next_believed(was, unknown, hearing([], mount=mount)) == (was, unknown)


def test_only_rivals_that_were_fitted_are_heard_and_few_of_them():
    was, asked = found(fan=0.6, mount=0.2, sun=0.2), []
    del was.fitted[SUN]
    next_believed(was, doubt(0.9), hearing(asked))
    assert asked == [MOUNT]
