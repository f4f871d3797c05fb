"""Names in full, and in messages: of many the first few, and how many more; long ones cut."""

import pytest
from ddh_twin_py.names import cited, first_of, in_namespace, no_such, short


@pytest.mark.parametrize(("names", "said"), [([], ""), (["a"], "a"), (["a", "b"], "a, b"), (["a", "b", "c", "d"], "a, b and 2 more")])
def test_the_first_few_are_named_and_the_others_counted(names, said):
    assert first_of(names, 2) == said


@pytest.mark.parametrize(("namespace", "full"), [("/", "/hydraulic_model"), ("", "/hydraulic_model"), ("/rig_1", "/rig_1/hydraulic_model"),
                                                 ("/rig_1/", "/rig_1/hydraulic_model")])
def test_a_name_in_full_has_one_slash_after_its_namespace_and_stays_as_it_is(namespace, full):
    assert in_namespace(namespace, "hydraulic_model") == full
    assert in_namespace("/another", full) == full


@pytest.mark.parametrize(("value", "said"), [
    ("a", "'a'"), (2.5, "2.5"), ([1, "b"], "[1, 'b']"), ("x" * 900_000, "'" + "x" * 56 + "..."), (10**100, "1" + "0" * 56 + "..."),
    (list(range(1000)), "[0, 1, 2, 3, 4, 5, ...]"),
], ids=range(6))
def test_a_value_is_cited_by_its_begin(value, said):
    assert cited(value) == said


def test_a_number_that_python_does_not_write_is_cited_as_that():
    assert cited(16**5000) == cited([16**5000]) == "a number of thousands of digits"


def test_what_names_something_long_stays_short():
    assert len(no_such("key", "k" * 900_000, ["value", "unit"])) < 120
    line = short("begin " + "x" * 900_000 + " end")
    assert line.startswith("begin x") and line.endswith("x end") and len(line) < 4100 and short("as it is") == "as it is"
