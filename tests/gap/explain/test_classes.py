"""Which effects a recording cannot tell apart."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.evidence.basis import Sums
from ddh_twin_py.gap.evidence.box import Normal
from ddh_twin_py.gap.evidence.hypotheses import WIDTH, Evidence
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.classes import TELLS_APART, classes_of, found_apart, separation

A, B, C = list(EFFECTS)[:3]


def linearised(likeness, size=30.0, laws=1):
    """A does 2 of its column; B is like it by a cosine of `likeness`; C is like neither."""
    rng = np.random.default_rng(0)
    q, _ = np.linalg.qr(rng.normal(size=(50, 3)))
    own = [q[:, 0], likeness * q[:, 0] + math.sqrt(1.0 - likeness**2) * q[:, 1], q[:, 2]]
    names = [A, B, C]
    if laws == 2:  # A's first law looks like nothing that is there
        own, names = [q[:, 2], *own], [A, *names]
    x = math.sqrt(size) * np.column_stack(own)
    y = 2.0 * math.sqrt(size) * q[:, 0]
    columns = [Column(replace(EFFECTS[n], lowest=-math.inf, highest=math.inf), i, 1.0, 5.0, "speed", []) for i, n in enumerate(names)]
    k = x.shape[1]
    normal = Normal(np.eye(1), np.zeros(1), np.zeros((1, k)), x.T @ x, x.T @ y, float(y @ y), -np.ones(1), np.ones(1))
    return SimpleNamespace(columns=columns, evidence=Evidence(Sums(x.T @ x, x.T @ y, float(y @ y)), normal, columns)), x


def test_look_alikes_are_a_class_and_the_other_is_not():
    made, _ = linearised(0.98, 20.0)
    classes, why = classes_of(made, {A: 0.6, B: 0.3, C: 0.1}, {})
    assert classes == [[A, B]] and set(why) == {A, B}
    assert f"to 98 % what {B} does" in why[A] and f"to 98 % what {A} does" in why[B]


def test_what_is_told_apart_is_no_class():
    made, _ = linearised(0.5)
    assert classes_of(made, {A: 0.6, B: 0.3, C: 0.1}, {}) == ([], {})


def test_what_is_improbable_is_in_no_class():
    made, _ = linearised(0.995)
    assert classes_of(made, {A: 0.97, B: 0.03}, {}) == ([], {})


def test_the_law_that_fits_stands_for_an_effect():
    made, _ = linearised(0.995, laws=2)
    assert classes_of(made, {A: 0.6, B: 0.3, C: 0.1}, {})[0] == [[A, B]]


def test_separation_is_what_the_other_leaves_of_chi_square():
    """Against a ridge fit of the second column to data that the first made."""
    made, x = linearised(0.9)
    y = 1.7 * x[:, 0]
    b = x[:, 1] @ y / (x[:, 1] @ x[:, 1] + WIDTH**-2)
    left = float(np.sum((y - b * x[:, 1]) ** 2)) + b**2 / WIDTH**2
    assert separation(made, 0, 1, 1.7) == pytest.approx(0.5 * left)
    assert separation(made, 0, 2, 1.7) > TELLS_APART > separation(linearised(0.999)[0], 0, 1, 1.7)


def test_what_would_have_to_act_the_other_way_explains_nothing():
    made, x = linearised(-0.999)
    assert separation(made, 0, 1, 1.7) == pytest.approx(0.5 * 1.7**2 * float(x[:, 0] @ x[:, 0]))
    assert classes_of(made, {A: 0.6, B: 0.3, C: 0.1}, {}) == ([], {})


def test_what_fits_in_full_hardly_tell_apart_is_a_class_whatever_sensitivities_expect():
    made, _ = linearised(0.5)
    fitted = {ids: SimpleNamespace(log_evidence=log) for ids, log in {(): 0.0, (A,): 40.0, (B,): 38.0, (C,): 30.0}.items()}
    classes, why = classes_of(made, {A: 0.6, B: 0.3, C: 0.1}, fitted)
    assert classes == [[A, B]] and "this recording tells them apart by 1.6 of the 3" in why[B]


def test_effects_are_held_against_each_other_beside_the_same_third():
    fitted = {(A,): 40.0, (B,): 39.0, tuple(sorted((A, C))): 90.0, tuple(sorted((B, C))): 80.0}
    fitted = {ids: SimpleNamespace(log_evidence=log) for ids, log in fitted.items()}
    assert found_apart(fitted, A, B) == found_apart(fitted, B, A) == 10.0
    assert found_apart(fitted, A, C) == math.inf and found_apart({}, A, B) == math.inf


def test_what_a_law_that_is_off_costs_its_effect_is_no_evidence_for_another():
    fitted = {ids: SimpleNamespace(log_evidence=log) for ids, log in {(): 100.0, (A,): 900.0, (B,): 890.0, (C,): 500.0}.items()}
    assert found_apart(fitted, A, B, 0.1) == pytest.approx(2.0) and found_apart(fitted, A, C, 0.1) == pytest.approx(392.0)
    assert found_apart(fitted, B, A, 0.1) == pytest.approx(10.0 - 7.9)
    made, _ = linearised(0.5)
    exact = replace(made.columns[0].effect, law_error=0.0)
    probability = {A: 0.9, B: 0.1}
    assert classes_of(made, probability, fitted)[0] == [[A, B]]
    made.columns[0] = replace(made.columns[0], effect=exact)
    assert classes_of(made, probability, fitted)[0] == []


def test_two_that_explain_more_together_are_no_class():
    fitted = {ids: SimpleNamespace(log_evidence=log) for ids, log in {(A,): 40.0, (B,): 39.0, tuple(sorted((A, B))): 90.0}.items()}
    assert found_apart(fitted, A, B) == math.inf
