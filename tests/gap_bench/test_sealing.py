"""The seal: what was written before is what is scored."""

import pytest
import yaml
from ddh_twin_py.gap_bench.scoring import answers_of_all
from ddh_twin_py.gap_bench.sealing import SEAL, SealError, digest_of, seal, truth_of, verify
from support.gap_reports import truth


@pytest.fixture
def sealed(tmp_path):
    (tmp_path / "truth").mkdir()
    for name in ("case_0001", "case_0002"):
        (tmp_path / "truth" / f"{name}.yaml").write_text(yaml.safe_dump(truth(name)))
    seal(tmp_path)
    return tmp_path


def test_sealed_cases_are_found(sealed):
    assert verify(sealed) == ["case_0001", "case_0002"]
    assert len((sealed / SEAL).read_text().splitlines()) == 2
    assert seal(sealed) == sealed / SEAL


def test_changed_truth_is_refused(sealed):
    file = sealed / "truth" / "case_0002.yaml"
    file.write_text(file.read_text().replace("clear", "faint"))
    for attempt in (verify, seal, lambda out: answers_of_all([out])):
        with pytest.raises(SealError, match=r"case_0002\.yaml: was changed after it was sealed"):
            attempt(sealed)


def test_missing_truth_is_refused(sealed):
    (sealed / "truth" / "case_0001.yaml").unlink()
    with pytest.raises(SealError, match=r"case_0001\.yaml: is sealed and missing"):
        verify(sealed)


def test_recordings_of_a_case_that_was_not_sealed_are_refused(sealed):
    (sealed / "cases" / "case_0003" / "field").mkdir(parents=True)
    with pytest.raises(SealError, match=r"cases/case_0003: was added after the bench was sealed"):
        verify(sealed)


def test_added_truth_is_refused(sealed):
    (sealed / "truth" / "case_0003.yaml").write_text("name: case_0003\n")
    with pytest.raises(SealError, match=r"case_0003\.yaml: was added after"):
        verify(sealed)


def test_no_seal_and_a_broken_one(sealed):
    (sealed / SEAL).write_text("not a hash\n")
    with pytest.raises(SealError, match="line 1: found 'not a hash'"):
        verify(sealed)
    (sealed / SEAL).unlink()
    with pytest.raises(SealError, match="no seal"):
        verify(sealed)


def test_nothing_to_seal(tmp_path):
    with pytest.raises(SealError, match="no case was made"):
        seal(tmp_path)


def test_a_case_that_is_sealed_twice_is_refused(sealed):
    file = sealed / "plan.sha256"
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join(lines + lines[:1]))
    with pytest.raises(SealError, match="is sealed twice"):
        verify(sealed)


def test_a_seal_that_is_no_text_is_refused(sealed):
    (sealed / "plan.sha256").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SealError, match="line 1"):
        verify(sealed)


def test_recordings_are_sealed_with_their_truth(tmp_path):
    bag = tmp_path / "cases" / "case_0001" / "field" / "field.mcap"
    bag.parent.mkdir(parents=True)
    bag.write_bytes(b"messages")
    (tmp_path / "truth").mkdir()
    said = truth("case_0001") | {"recordings": digest_of(tmp_path / "cases" / "case_0001")}
    (tmp_path / "truth" / "case_0001.yaml").write_text(yaml.safe_dump(said))
    seal(tmp_path)
    assert truth_of(tmp_path, "case_0001") == said
    for spoil in (lambda: bag.write_bytes(b"message"), lambda: bag.rename(bag.with_name("other.mcap"))):
        spoil()
        with pytest.raises(SealError, match="case_0001: its recordings are not those that were sealed"):
            truth_of(tmp_path, "case_0001")
