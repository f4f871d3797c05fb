"""The state on disk: what is written comes back, what cannot be used is said in one line."""

import os
from dataclasses import asdict

import numpy as np
import pytest
from ddh_twin_py.estimation.fusion.state_file import StateFileError, load_state, save_state
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.nodes.base.parameters import NodeError
from ddh_twin_py.nodes.tasks.state_keeper import StateKeeper
from ddh_twin_py.rig import files, load_rig
from hypothesis import given, settings
from hypothesis import strategies as st

STAMP = 1_772_000_000_123_456_789


@pytest.fixture(scope="module")
def state():
    return TemperatureFusion(load_rig()).state


def refused(path, state):
    """The one line with which a file is refused."""
    with pytest.raises(StateFileError) as caught:
        load_state(path, state)
    text = str(caught.value)
    assert text.startswith(f"{path}: ") and "\n" not in text and len(text) < len(str(path)) + 120
    said = text.removeprefix(f"{path}: ")
    assert not any(word in said for word in ("pickle", "zip", "np.", "numpy", "object"))
    return said


def test_what_is_written_comes_back(tmp_path, state):
    save_state(tmp_path / "deep" / "state", state, "rig_7", STAMP)
    saved = load_state(tmp_path / "deep" / "state", state)
    assert (saved.rig_id, saved.stamp_ns) == ("rig_7", STAMP)
    for name, value in asdict(state).items():
        loaded = getattr(saved.state, name)
        assert np.array_equal(loaded, value) and np.asarray(loaded).dtype == np.asarray(value).dtype, name
    assert os.listdir(tmp_path / "deep") == ["state"]
    assert load_state(tmp_path / "none", state) is None


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("version", np.array([1, 2]), "version is of type int64 and shape (2,)"),
        ("version", "x", "version is of type <U1"),
        ("version", 2, "is of version 2, this twin reads version 1"),
        ("stamp_ns", "noon", "stamp_ns is of type <U4"),
        ("stamp_ns", 1.5, "stamp_ns is of type float64"),
        ("rig_id", 7, "rig_id is of type int64"),
        ("ambient", np.nan, "ambient has a value that is not finite"),
        ("ambient", "warm", "ambient is of type <U4"),
        ("dynamic", np.zeros(3), "dynamic is of type float64 and shape (3,), this filter has"),
        ("offset", None, "is no state file: offset is missing"),
        ("refused", 0.5, "refused is of type float64"),
    ],
)
def test_an_entry_that_is_none_is_named(name, value, words, tmp_path, state):
    entries = {"version": 1, "rig_id": "rig_7", "stamp_ns": np.int64(STAMP), **asdict(state)} | {name: value}
    np.savez(tmp_path / "state.npz", **{key: entry for key, entry in entries.items() if entry is not None})
    assert words in refused(tmp_path / "state.npz", state)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.__setitem__((3, 3), -1.0), "covariance has a negative variance, -1"),
        (lambda c: c.__setitem__((3, 3), np.inf), "covariance has a value that is not finite"),
        (lambda c: c.__setitem__((0, 1), 1e6), "covariance is not one"),
    ],
)
def test_a_covariance_that_is_none_is_refused(change, words, tmp_path, state):
    entries = asdict(state)
    change(entries["covariance"])
    np.savez(tmp_path / "state.npz", version=1, rig_id="", stamp_ns=np.int64(STAMP), **entries)
    assert words in refused(tmp_path / "state.npz", state)


def test_files_of_other_kinds_are_refused(tmp_path, state):
    np.save(tmp_path / "array.npy", np.zeros(3))
    np.save(tmp_path / "pickle.npy", np.array([{}], dtype=object), allow_pickle=True)
    np.savez(tmp_path / "pickled.npz", version=np.array({}, dtype=object))
    np.savez(tmp_path / "foreign.npz", x=1)
    (tmp_path / "text").write_text("rubbish")
    (tmp_path / "empty").write_bytes(b"")
    (tmp_path / "folder").mkdir()
    for name in os.listdir(tmp_path):
        words = refused(tmp_path / name, state)
        assert words.startswith("cannot be read: Is a directory" if name == "folder" else "is no state file")


@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 0.999), st.integers(0, 255), st.booleans())
def test_a_damaged_file_is_refused_or_read_whole(tmp_path_factory, place, byte, cut):
    state = TemperatureFusion(load_rig()).state
    path = tmp_path_factory.mktemp("state") / "state"
    save_state(path, state, "rig_7", STAMP)
    data = bytearray(path.read_bytes())
    at = int(place * len(data))
    if cut:
        del data[at:]
    else:
        data[at] = byte
    path.write_bytes(data)
    try:
        saved = load_state(path, state)
    except StateFileError as error:
        assert "\n" not in str(error)
    else:
        assert not cut and np.array_equal(saved.state.covariance, state.covariance)


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path, state, monkeypatch):
    save_state(tmp_path / "state", state, "rig_7", STAMP)

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        save_state(tmp_path / "state", state, "rig_7", STAMP + 1)
    assert os.listdir(tmp_path) == ["state"]
    assert load_state(tmp_path / "state", state).stamp_ns == STAMP


def test_a_node_starts_without_a_state_that_cannot_be_used(tmp_path, state):
    (tmp_path / "state").write_bytes(b"PK\x03\x04 and so on")
    keeper = StateKeeper(str(tmp_path / "state"), state)
    keeper.close()
    assert keeper.saved is None
    assert keeper.note == (f"{tmp_path}/state: is no state file, or was cut short; starting without, and kept as state.old once a state is "
                           "written")


def test_a_file_that_is_no_state_is_not_lost(tmp_path, state):
    (tmp_path / "crane_1.yaml").write_text("rig_id: crane_1\n")
    keeper = StateKeeper(str(tmp_path / "crane_1.yaml"), state)
    assert (tmp_path / "crane_1.yaml").read_text() == "rig_id: crane_1\n", "until there is a state to write"
    keeper.keep(state, "rig_7", STAMP)
    keeper.close()
    assert (tmp_path / "crane_1.yaml.old").read_text() == "rig_id: crane_1\n"
    assert load_state(tmp_path / "crane_1.yaml", state).stamp_ns == STAMP
    again = StateKeeper(str(tmp_path / "crane_1.yaml"), state)
    again.keep(state, "rig_7", STAMP + 1)
    again.close()
    assert again.saved is not None and (tmp_path / "crane_1.yaml.old").read_text() == "rig_id: crane_1\n"


def test_a_second_file_that_is_no_state_leaves_the_first_that_was_set_aside(tmp_path, state):
    for number in range(3):
        (tmp_path / "state").write_text(f"no state {number}")
        keeper = StateKeeper(str(tmp_path / "state"), state)
        name = "state.old" if number == 0 else f"state.old_{number + 1}"
        assert f"kept as {name} once" in keeper.note
        keeper.keep(state, "rig_7", STAMP)
        keeper.close()
    assert [(tmp_path / name).read_text() for name in ("state.old", "state.old_2", "state.old_3")] == [f"no state {n}" for n in range(3)]


def test_a_state_newer_than_the_data_is_not_lost(tmp_path, state):
    """As of a machine, where yesterday's recording is played with its state file."""
    save_state(tmp_path / "state", state, "rig_7", STAMP)
    keeper = StateKeeper(str(tmp_path / "state"), state)
    said = keeper.refusal(-86400.0, "rig_7")
    assert said.endswith("is 86400 s newer than the data; not used, and kept as state.old once a state is written")
    for stamp in range(3):
        keeper.keep(state, "rig_7", stamp)
    keeper.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["state", "state.old"]
    assert [load_state(tmp_path / name, state).stamp_ns for name in ("state", "state.old")] == [2, STAMP]


def test_the_state_of_another_rig_is_not_lost(tmp_path, state):
    save_state(tmp_path / "state", state, "rig_7", STAMP)
    keeper = StateKeeper(str(tmp_path / "state"), state)
    said = keeper.refusal(1.0, "rig_8")
    assert said.endswith("is of rig 'rig_7', this is 'rig_8'; not used, and kept as state.old once a state is written")
    for stamp in range(3):
        keeper.keep(state, "rig_8", stamp)
    keeper.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["state", "state.old"]
    assert [load_state(tmp_path / name, state).rig_id for name in ("state", "state.old")] == ["rig_8", "rig_7"]


def test_a_state_is_written_where_what_was_in_its_place_is_removed_meanwhile(tmp_path, state):
    (tmp_path / "state").write_text("no state")
    keeper = StateKeeper(str(tmp_path / "state"), state)
    (tmp_path / "state").unlink()
    keeper.keep(state, "rig_7", STAMP)
    keeper.close()
    assert keeper.failure == "" and load_state(tmp_path / "state", state).stamp_ns == STAMP


@pytest.mark.parametrize("path", ["/dev/full", "/dev/zero", "/tmp"])
def test_a_state_file_that_is_no_regular_file_is_refused(path, state):
    with pytest.raises(NodeError, match=f"parameter state_file is {path}: that is no regular file"):
        StateKeeper(path, state)


@pytest.mark.parametrize("path", ["/proc/x.npz", "/sys/x.npz"])
def test_a_state_file_where_no_file_can_be_made_is_refused(path, state):
    with pytest.raises(NodeError, match=f"parameter state_file is {path}: it cannot be written"):
        StateKeeper(path, state)
