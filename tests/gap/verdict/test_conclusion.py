"""What is concluded names the hypothesis that it heard."""

import math
from types import SimpleNamespace

import pytest
from ddh_twin_py.gap import answer
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.shrink.held_runs import INDEPENDENT, HeldRuns
from ddh_twin_py.gap.verdict import conclusion
from ddh_twin_py.gap.verdict.verdict import NO_HELP
from ddh_twin_py.real_rigs.diagnose import diagnose
from ddh_twin_py.real_rigs.rig_model import RigModel
from support.heated_block import DESCRIPTION, block

OFFSET = DESCRIPTION.effects[0]


@pytest.fixture
def concluded(monkeypatch):
    """The conclusion on a block whose sensor is off by a hair, where something acts with a probability."""
    def on(acts: float) -> conclusion.Conclusion:
        kept = []
        conclude = conclusion.conclude
        monkeypatch.setattr(conclusion, "_something_acts", lambda *_: (acts, "commissioned, it would hardly show this"))
        monkeypatch.setattr(answer, "conclude", lambda *given, **named: kept.append(conclude(*given, **named)) or kept[-1])
        diagnose(RigModel(DESCRIPTION, block([(OFFSET, 0, 0.032)], seed=1).field, commissioning=block(seed=3).field))
        return kept[-1]

    return on


def test_who_leads_once_no_effect_is_less_believed_was_heard(concluded):
    before = concluded(0.0)
    assert before.found.leader == () and before.verdict.word == "no_gap"
    after = concluded(0.6)
    assert after.found.leader == after.verdict.leader == after.best.effects == (OFFSET.id,)
    assert set(after.at_best) == {(), (OFFSET.id,)}
    assert 0.2 < after.unknown.probability < 0.5


@pytest.mark.parametrize("built, without, beside, lost", [
    (True, 1.1, 1.1, 0.0),  # small effects take nothing of what is no gap
    (True, 1.1, 1.12, 0.5 * INDEPENDENT * 4 * (1.12**2 - 1.1**2)), (True, 1.1, 1.5, NO_HELP), (True, 1.1, 0.9, 0.0),
    (True, 1.1, math.inf, NO_HELP),
    (True, 2.0, 2.0, NO_HELP), (False, 1.1, 1.3, 0.0), (False, 2.1, 2.14, NO_HELP), (False, 2.1, 1.5, 0.0),
])  # fmt: skip
def test_a_leader_that_brings_held_out_data_no_nearer_is_less_believed(built, without, beside, lost):
    """Without commissioning only where these have a gap: parameters take an effect up, and leave none within the floor."""
    leader, none = SimpleNamespace(columns=(1,), effects=("fan",)), SimpleNamespace(columns=(), effects=())
    found = Found(None, {("fan",): 0.6, (): 0.4}, {("fan",): leader, (): none})
    runs = HeldRuns(None, dict.fromkeys("abcd", 1.0))
    runs.ratios = lambda fitted: dict.fromkeys("abcd", beside if fitted is leader else without)
    after, notes = conclusion._without_help(found, runs, built)
    odds = after.probability[("fan",)] / after.probability[()]
    assert odds == pytest.approx(1.5 * math.exp(-lost)) and bool(notes) == (lost > 0.0)
    assert all(("nothing beyond the floor" in note) == (without <= 1.25) for note in notes)


@pytest.mark.parametrize(("without", "gaps", "left"), [
    (2.0, {"fan": 2.0, "leak": 1.1}, {"fan": NO_HELP, "leak": 0.0, "slight": NO_HELP}),
    (1.1, {"fan": 1.5, "leak": 1.1}, {"fan": NO_HELP, "leak": 0.0, "slight": NO_HELP}),
])  # fmt: skip
def test_a_rival_that_helps_with_held_out_data_loses_nothing(without, gaps, left):
    """One that is less probable is not asked and loses as much as the leader."""
    fitted = {(name,): SimpleNamespace(columns=(1,), effects=(name,)) for name in ("fan", "leak", "slight")}
    fitted[()] = SimpleNamespace(columns=(), effects=())
    before = {("fan",): 0.5, ("leak",): 0.3, (): 0.19, ("slight",): 0.01}
    runs = HeldRuns(None, dict.fromkeys("abcd", 1.0))
    runs.ratios = lambda one: dict.fromkeys("abcd", gaps[one.effects[0]] if one.effects else without)
    after = conclusion._without_help(Found(None, before, fitted), runs, True)[0].probability
    for name, lost in left.items():
        assert after[(name,)] / after[()] == pytest.approx(before[(name,)] / before[()] * math.exp(-lost))
