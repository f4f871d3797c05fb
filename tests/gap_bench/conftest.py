"""An engine that stands in for the diagnosis."""

import os

import pytest


@pytest.fixture
def engine(tmp_path, monkeypatch):
    """An engine for processes that the tests start: answers by the folder's name, counts how often it is asked."""
    (tmp_path / "fake_engine.py").write_text(
        "import json, os, pathlib\n"
        "class D:\n    def __init__(self, report): self.report, self.sentence = report, ''\n"
        "def diagnose(field, commissioning, validation, rig, without=(), progress=None, only=None):\n"
        "    name = field[0].parent.name\n"
        "    log = pathlib.Path(__file__).with_name('asked.txt')\n"
        "    with log.open('a') as file: file.write(f'{name} {sorted(without)} {only}\\n')\n"
        "    if name == 'case_0002': raise ValueError('this one breaks')\n"
        "    why = [{'effect': 'pump_1.leakage', 'probability': 0.6}, {'effect': 'pump_2.leakage', 'probability': 0.3}]\n"
        "    return D({'verdict': 'explained', 'gap': {'closed_fraction': 0.8}, 'where': [], 'why': why,\n"
        "              'classes': [['pump_1.leakage', 'pump_2.leakage']], 'hypotheses': [{'effects': ['pump_1.leakage']}]})\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    return "fake_engine:diagnose", tmp_path / "asked.txt"
