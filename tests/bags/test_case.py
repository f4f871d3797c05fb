"""Bags of a case, given one by one or as a folder."""

from pathlib import Path

import pytest
from ddh_twin_py.bags.case import case_of
from ddh_twin_py.bags.errors import BagError


def bag(path: Path) -> Path:
    path.mkdir(parents=True)
    (path / "metadata.yaml").write_text("")
    return path


@pytest.fixture
def folder(tmp_path):
    for role in ("commissioning", "field", "validation"):
        bag(tmp_path / "case" / role)
    return tmp_path / "case"


def test_a_folder_gives_all_three(folder):
    case = case_of([folder])
    assert case.field == (folder / "field",)
    assert (case.commissioning, case.validation) == (folder / "commissioning", folder / "validation")


def test_what_is_named_stands_before_what_is_found(folder, tmp_path):
    other = bag(tmp_path / "other")
    assert case_of([folder], commissioning=other).commissioning == other
    assert case_of([folder], commissioning=other).validation == folder / "validation"


def test_bags_one_by_one(tmp_path):
    a, b = bag(tmp_path / "a"), bag(tmp_path / "b")
    case = case_of([str(a), b])
    assert case.field == (a, b) and case.commissioning is None and case.validation is None


def test_a_folder_that_is_a_bag_is_one_whatever_it_holds(tmp_path):
    odd = bag(tmp_path / "odd")
    (odd / "field").mkdir()
    assert case_of([odd]).field == (odd,)


def test_loose_files_beside_field_are_no_part_of_a_case_and_without_it_they_are_the_bag(folder, tmp_path):
    (folder / "notes.mcap").write_bytes(b"")
    assert case_of([folder]).field == (folder / "field",)
    (tmp_path / "loose" / "validation").mkdir(parents=True)
    (tmp_path / "loose" / "x.mcap").write_bytes(b"")
    assert case_of([tmp_path / "loose"]).field == (tmp_path / "loose",)


def test_a_case_without_field_says_what_it_holds(tmp_path):
    bag(tmp_path / "c" / "validation")
    with pytest.raises(BagError, match="holds validation; a case needs field/"):
        case_of([tmp_path / "c"])


def test_two_cases_with_a_commissioning_bag_are_asked_about(folder, tmp_path):
    bag(tmp_path / "second" / "field")
    bag(tmp_path / "second" / "commissioning")
    with pytest.raises(BagError, match="name the one to use with --commissioning"):
        case_of([folder, tmp_path / "second"])
    assert len(case_of([folder, tmp_path / "second"], commissioning=folder / "commissioning").field) == 2


@pytest.mark.parametrize(("name", "shown"), [("b\n", "'{}/b\\n'"), ("b ", "'{}/b '"), ("a  b", "'{}/a  b'"), ("a b", "{}/a b")])
def test_a_name_that_reads_like_another_one_is_shown_in_quotes(name, shown, folder, tmp_path):
    bag(tmp_path / "b")
    for given in ({"given": [tmp_path / name]}, {"given": [folder], "rig": tmp_path / name}):
        with pytest.raises(BagError) as refused:
            case_of(**given)
        assert f"{shown.format(tmp_path)} does not exist" in str(refused.value)


def test_what_is_not_there_or_given_twice(folder, tmp_path):
    with pytest.raises(BagError, match="nowhere does not exist"):
        case_of([tmp_path / "nowhere"])
    with pytest.raises(BagError, match="does not exist"):
        case_of([folder], validation=tmp_path / "nowhere")
    with pytest.raises(BagError, match="are the same bag"):
        case_of([folder / "field", folder / "field" / ".." / "field"])
    with pytest.raises(BagError, match="are the same bag"):
        case_of([folder / "field"], validation=folder / "field")


@pytest.mark.parametrize(("given", "words"), [
    (([],), "field is []"),
    (([""],), "none empty"),
    ((["."], None, None, "/dev/zero"), "rig file /dev/zero is a character device, a regular file is needed"),
    ((["."], None, None, "/"), "rig file / is a folder"),
    ((["."], None, None, "/nowhere.yaml"), "rig file /nowhere.yaml does not exist"),
])
def test_nothing_given_and_no_rig(given, words):
    with pytest.raises(BagError) as caught:
        case_of(*given)
    assert words in str(caught.value)


@pytest.mark.parametrize("given", ["x" * 300, "y" * 100_000])
def test_a_path_that_the_system_does_not_take_is_one_short_line(given, tmp_path):
    (tmp_path / "field").mkdir()
    for asked in (lambda: case_of([given]), lambda: case_of([tmp_path / "field"], rig=given)):
        with pytest.raises(BagError, match="File name too long") as refused:
            asked()
        assert len(str(refused.value)) < 200


def test_a_folder_of_cases_is_named_with_what_asks_about_all(folder, tmp_path):
    with pytest.raises(BagError, match=r"holds no bag itself but cases, 1 of them, the first is .*ddh-twin fleet"):
        case_of([folder.parent])
