"""The listener that the README shows hears what the fusion publishes."""

import os
import re
import runpy
import signal
import subprocess
import sys

import pytest
import rclpy
from ddh_twin_py.nodes.base.qos import OUTPUT
from nodes.processes import wait_for
from rclpy.context import Context

from ddh_msgs.msg import TemperatureEstimate, TemperatureEstimateArray


@pytest.mark.live
@pytest.mark.timeout(60)
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_the_readmes_listener_prints_estimates_with_their_band_and_ends_quietly(end, repo_root, tmp_path):
    documents = runpy.run_path(str(repo_root / "scripts/run_documents.py"))
    (shown,) = (b.text for b in documents["blocks_of"]((repo_root / "README.md").read_text("utf-8")) if b.mark == "file: listen.py")
    script = tmp_path / "listen.py"
    script.write_text(shown, "utf-8")
    (topic,) = re.findall(r'"(/\S+)"', shown)
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node("fusion", context=context)
    publisher = node.create_publisher(TemperatureEstimateArray, topic, OUTPUT)
    message = TemperatureEstimateArray(estimates=[
        TemperatureEstimate(location="tank_oil", temperature=41.26, standard_deviation=0.2),
        TemperatureEstimate(location="line_a_oil", temperature=50.0, standard_deviation=1.0),
    ])
    with (tmp_path / "heard").open("wb") as heard:
        listener = subprocess.Popen([sys.executable, "-u", script], stdout=heard, stderr=subprocess.STDOUT, env=dict(os.environ))
    try:
        def told():
            publisher.publish(message)
            return (tmp_path / "heard").read_text("utf-8").splitlines()[1:]

        lines = wait_for(told, 30, "a line of the listener")
        listener.send_signal(end)
        assert listener.wait(10) == 0
    finally:
        listener.kill()
        listener.wait()
        node.destroy_node()
        rclpy.shutdown(context=context)
    first, *others = (tmp_path / "heard").read_text("utf-8").splitlines()
    assert first == "waiting for the first estimate; Ctrl-C ends"
    assert set(lines) == set(others) == {"tank_oil: 41.3 ± 0.4 °C"}
