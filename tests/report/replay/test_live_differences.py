"""What the demo says of the live graph against the replay in one process."""

from ddh_twin_py.report.replay.live_differences import Difference, sentence


def test_the_demos_differences_have_units_and_a_reason():
    apart = [Difference("fused temperatures", 0.0321, 0.01, "K", 0.3), Difference("predicted temperatures", 1e-13, 1e-14, "K", 1e-12),
             Difference("torque, soft sensor", 1.92, 0.1, "N*m", 16.0),
             Difference("pressure rod side, free run", 3.0e5, 1.0e4, "Pa", 15.0)]
    said = sentence(apart)
    assert "0.032 K of a fused temperature" in said and "1.9 N·m of a signal (torque, soft sensor; 16 times the noise of" in said
    assert "It comes from when messages arrive" in said
    assert "20 bar of a signal" in sentence([*apart, Difference("pressure piston side, free run", 2.0e6, 1.0e4, "Pa", 100.0)])
    assert sentence([]) == "cannot be told: in no interval both have fused temperatures and predicted temperatures"
    assert sentence(apart[:2]) == "cannot be told: in no interval both have signals"
