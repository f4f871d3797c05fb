"""What recordings say of themselves."""

from dataclasses import replace

import pytest
from ddh_twin_py.telemetry.recording import RigInfo, announced_id


@pytest.mark.parametrize(("told", "name"), [((None, "", "crane_1", "crane_2"), "crane_1"), ((None, ""), ""), ((), "")])
def test_a_rig_is_called_as_the_first_recording_says_that_names_it(paper, told, name):
    rigs = [None if one is None else RigInfo(one, "ISO VG 32", 100.0) for one in told]
    assert announced_id(replace(paper, rig=rig) for rig in rigs) == name
