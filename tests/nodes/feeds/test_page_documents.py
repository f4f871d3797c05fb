"""What the live page is told of the limits and of the rig."""

from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.feeds.page_documents import limits_document, rig_document
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.nodes.tasks.limit_watch import LimitWatch

from ddh_msgs.msg import LimitPrediction, RigInfo


def test_the_page_knows_from_where_on_the_fusion_warns():
    watch, report = object.__new__(LimitWatch), Report("ddh/temperature_fusion: limits", "")
    watch.newest, watch.present = SimpleNamespace(limits=[]), SimpleNamespace(seen=60.0, known=False)
    watch._horizon, watch._warn_within = 3600.0, 600.0
    watch.judge(report)
    said = [(value.key, value.value) for value in report.status.values]
    assert limits_document(LimitPrediction(), said)["warn_within"] == 600.0
    assert limits_document(LimitPrediction(), [])["warn_within"] is None, "the fusion has not spoken yet"


@pytest.mark.parametrize("told, shown", [(120.0, 120.0), (-5.0, None), (0.0, None), (float("nan"), None), (1.0e9, None)])
def test_a_payload_that_no_node_takes_is_not_shown(told, shown):
    assert rig_document(RigInfo(rig_id="crane", payload_mass=told))["payload_mass"] == shown
