"""Every rig that the command offers can be studied: its module is there and says where a user gets the recordings."""

import inspect

import pytest
from ddh_twin_py.real_rigs.registry import RIGS, study_of
from ddh_twin_py.real_rigs.study import RecordingsError


@pytest.mark.parametrize("rig", RIGS)
def test_a_rig_without_recordings_says_so_in_one_line(rig, tmp_path):
    study = study_of(rig)
    assert list(inspect.signature(study.run).parameters) == ["data", "progress"]
    with pytest.raises(RecordingsError, match="no such file; (get the set from|the set is at)") as error:
        study.run(tmp_path)
    assert str(tmp_path / rig) in str(error.value) and "\n" not in str(error.value)
