"""What the live page is told of the limits."""

from types import SimpleNamespace

from ddh_twin_py.nodes.feeds.page_documents import limits_document
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.nodes.tasks.limit_watch import LimitWatch

from ddh_msgs.msg import LimitPrediction


def test_the_page_knows_from_where_on_the_fusion_warns():
    watch, report = object.__new__(LimitWatch), Report("ddh/temperature_fusion: limits", "")
    watch.newest, watch.present = SimpleNamespace(limits=[]), SimpleNamespace(seen=60.0, known=False)
    watch._horizon, watch._warn_within = 3600.0, 600.0
    watch.judge(report)
    said = [(value.key, value.value) for value in report.status.values]
    assert limits_document(LimitPrediction(), said)["warn_within"] == 600.0
    assert limits_document(LimitPrediction(), [])["warn_within"] is None, "the fusion has not spoken yet"
