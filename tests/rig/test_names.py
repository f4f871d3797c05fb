"""Names in full, and in messages: of many the first few, and how many more."""

import pytest
from ddh_twin_py.names import first_of, in_namespace


@pytest.mark.parametrize(("names", "said"), [([], ""), (["a"], "a"), (["a", "b"], "a, b"), (["a", "b", "c", "d"], "a, b and 2 more")])
def test_the_first_few_are_named_and_the_others_counted(names, said):
    assert first_of(names, 2) == said


@pytest.mark.parametrize(("namespace", "full"), [("/", "/hydraulic_model"), ("", "/hydraulic_model"), ("/rig_1", "/rig_1/hydraulic_model"),
                                                 ("/rig_1/", "/rig_1/hydraulic_model")])
def test_a_name_in_full_has_one_slash_after_its_namespace_and_stays_as_it_is(namespace, full):
    assert in_namespace(namespace, "hydraulic_model") == full
    assert in_namespace("/another", full) == full
