"""Feedback of the action `diagnose`: with each change, and again and again without one."""

from types import SimpleNamespace

import numpy as np
from ddh_twin_py.nodes.tasks.diagnose_action import SAYS_AGAIN, DiagnoseAction


def test_feedback_comes_with_each_change_and_while_nothing_changes():
    now, heard = 0.0, []
    action = DiagnoseAction.__new__(DiagnoseAction)
    action._node, action._told, action._told_at = SimpleNamespace(wall=lambda: now), None, 0.0
    goal = SimpleNamespace(publish_feedback=lambda feedback: heard.append((now, feedback.done)))
    for now in np.arange(0.0, 40.0, 0.2):
        action._tell(SimpleNamespace(done=float(now >= 12.0), stage="fitting"), goal)
    at = np.array([when for when, _ in heard])
    assert at[0] == 0.0 and heard[3][1] == 1.0 and abs(at[3] - 12.0) < 0.1
    assert np.diff([*at, 40.0]).max() < SAYS_AGAIN + 0.3 and len(heard) == 9
