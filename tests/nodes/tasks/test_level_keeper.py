"""Normal levels are on disk once they were learned, also where the disk was full for a while."""

from dataclasses import replace

import pytest
from ddh_twin_py.gap.watch.normal_level import NormalLevel, NormalLevelError, save_levels
from ddh_twin_py.nodes.tasks import level_keeper
from ddh_twin_py.nodes.tasks.level_keeper import LevelKeeper


@pytest.fixture
def written(monkeypatch):
    """What was written, and whether the disk is full."""
    kept = {"full": False, "attempts": 0}

    def save(path, rig_id, bin_length, levels):
        kept["attempts"] += 1
        if kept["full"]:
            raise OSError(28, "No space left on device")
        kept["levels"] = set(levels)

    monkeypatch.setattr(level_keeper, "save_levels", save)
    return kept


def kept_now(keeper, rig_id, levels):
    keeper.keep(rig_id, dict.fromkeys(levels))
    keeper._writer.submit(lambda: None).result()


def test_what_could_not_be_written_is_tried_again_until_it_is(written, tmp_path):
    keeper = LevelKeeper(str(tmp_path / "levels.json"), 1.0)
    written["full"] = True
    for _ in range(3):
        kept_now(keeper, "crane_1", ["speed"])
    assert written["attempts"] == 3 and "No space left" in keeper.failure and keeper.rig_id == ""
    written["full"] = False
    for _ in range(3):
        kept_now(keeper, "crane_1", ["speed"])
    assert written["attempts"] == 4 and written["levels"] == {"speed"} and keeper.failure == ""
    keeper.close()


def test_a_file_of_other_phases_is_refused(tmp_path):
    path = tmp_path / "levels.json"
    save_levels(path, "crane_1", 1.0, {"speed": NormalLevel((0.0,), 1.0, 1.0, 0.0, 100, 400.0)})
    with pytest.raises(NormalLevelError, match=r"levels.json: signals.speed.level: found 1 of the 3 needed"):
        LevelKeeper(str(path), 1.0)


def test_what_was_learned_of_a_machine_is_there_when_it_comes_back(written, tmp_path):
    keeper = LevelKeeper(str(tmp_path / "levels.json"), 1.0)
    kept_now(keeper, "crane_1", ["speed"])
    assert keeper.of("crane_2") == {} and set(keeper.of("crane_1")) == {"speed"}
    kept_now(keeper, "crane_2", ["speed", "current"])
    assert written["levels"] == {"speed"}, "never over those of another machine"
    keeper.close()


def test_levels_that_were_learned_before_the_machine_was_named_are_written_again_with_its_name(written, tmp_path):
    keeper = LevelKeeper(str(tmp_path / "levels.json"), 1.0)
    for rig_id in ("", "", "crane_1", "crane_1"):
        kept_now(keeper, rig_id, ["speed"])
    assert written["attempts"] == 2 and keeper.rig_id == "crane_1" and keeper.of("crane_2") == {}
    keeper.close()


def test_a_file_keeps_the_name_of_its_machine_and_a_level_that_is_no_number_is_said(tmp_path):
    path = tmp_path / "levels.json"
    level = NormalLevel((1.0, 2.0, 3.0), 1.0, 1.0, 0.1, 60, 100.0)
    save_levels(path, "crane_1", 1.0, {"speed": level})
    keeper = LevelKeeper(str(path), 1.0)
    keeper.keep("", {"speed": level, "current": level})
    keeper.close()
    assert LevelKeeper(str(path), 1.0).rig_id == "crane_1"
    keeper = LevelKeeper(str(path), 1.0)
    keeper.keep("crane_1", {"speed": replace(level, spread=float("nan")), "torque": level})
    keeper.close()
    assert f"{path}: cannot be written: " in keeper.failure and set(LevelKeeper(str(path), 1.0).of("crane_1")) == {"speed", "current"}
