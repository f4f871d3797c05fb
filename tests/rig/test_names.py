"""Names in messages: of many the first few, and how many more."""

import pytest
from ddh_twin_py.names import first_of


@pytest.mark.parametrize(("names", "said"), [([], ""), (["a"], "a"), (["a", "b"], "a, b"), (["a", "b", "c", "d"], "a, b and 2 more")])
def test_the_first_few_are_named_and_the_others_counted(names, said):
    assert first_of(names, 2) == said
