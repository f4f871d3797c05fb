"""Files and folders that are written whole or not at all leave alone what others made."""

import argparse
import os
import secrets
import stat

import pytest
from ddh_twin_py.cli.arguments import output_file
from ddh_twin_py.rig.files import whole_folder, write_whole


@pytest.fixture
def others(tmp_path):
    """What another process of the same id, in a container that shares the volume, may just be writing."""
    folder = tmp_path / f"field.{os.getpid()}"
    folder.mkdir()
    (folder / "half").write_text("its own")
    (tmp_path / f"x.json.{os.getpid()}").write_text("its own")
    return folder


def test_a_folder_of_another_process_with_the_same_id_is_left_alone(tmp_path, others):
    with whole_folder(tmp_path / "field") as folder:
        folder.mkdir()
        (folder / "own").write_text("x")
    assert (others / "half").read_text() == "its own" and (tmp_path / "field" / "own").exists()
    with pytest.raises(KeyError), whole_folder(tmp_path / "field") as folder:
        raise KeyError
    assert {p.name for p in tmp_path.iterdir()} == {"field", others.name, f"x.json.{os.getpid()}"}


def test_a_file_of_another_process_with_the_same_id_is_left_alone(tmp_path, others, monkeypatch):
    write_whole(tmp_path / "x.json", "{}")
    assert (tmp_path / f"x.json.{os.getpid()}").read_text() == "its own"
    monkeypatch.setattr(secrets, "token_hex", lambda _: str(os.getpid()))
    with pytest.raises(FileExistsError):
        write_whole(tmp_path / "x.json", "[]")
    assert (tmp_path / f"x.json.{os.getpid()}").read_text() == "its own" and (tmp_path / "x.json").read_text() == "{}"


def test_what_is_written_has_the_permissions_of_any_new_file(tmp_path):
    before = os.umask(0o022)
    try:
        write_whole(tmp_path / "x.json", "{}")
        with whole_folder(tmp_path / "field") as folder:
            folder.mkdir()
    finally:
        os.umask(before)
    assert [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("x.json", "field")] == [0o644, 0o755]


def test_the_longest_name_that_is_taken_can_be_written(tmp_path):
    longest = max(n for n in range(1, 255) if _taken(str(tmp_path / ("x" * n))))
    write_whole(tmp_path / ("x" * longest), "{}")
    with whole_folder(tmp_path / ("y" * longest)) as folder:
        folder.mkdir()


def _taken(name):
    try:
        return bool(output_file(name))
    except argparse.ArgumentTypeError:
        return False
