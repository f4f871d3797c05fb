"""The version that an answer carries names a commit of this project alone."""

import subprocess

import pytest
from ddh_twin_py.report.page import document


@pytest.mark.parametrize("place, ours", [
    ("ddh_twin_py/ddh_twin_py", True), ("foreign/.venv/lib/python3.12/site-packages/ddh_twin_py", False), ("ddh_twin_py", False)])
def test_a_foreign_repository_around_an_installation_is_not_asked(tmp_path, monkeypatch, place, ours):
    module = tmp_path / place / "report" / "page" / "document.py"
    module.parent.mkdir(parents=True)
    module.write_text("")
    git = ["git", "-C", str(tmp_path), "-c", "user.name=x", "-c", "user.email=x@x"]
    for command in (["init", "-q"], ["add", "-f", "."], ["commit", "-q", "-m", "first"]):
        subprocess.run([*git, *command], check=True, capture_output=True)
    monkeypatch.setattr(document, "__file__", str(module))
    assert ("+" in document.version.__wrapped__()) == ours
