"""Data of a described rig that take no part in finding or fitting."""

import pytest
from ddh_twin_py.real_rigs.diagnose import diagnose
from support.heated_block import block


def test_a_rig_of_which_nothing_is_held_out_has_no_answer():
    with pytest.raises(ValueError, match=r"^block.csv: nothing is held out, .* as `held`, or signals a `held_from` before their end$"):
        diagnose(block(held=False))
