"""The typed report is that of the contract, and who reads a report asks for nothing else."""

import json
import re
from pathlib import Path
from typing import get_args, get_type_hints

from ddh_twin_py.gap import contract

PACKAGE = Path(contract.__file__).parents[1]
READERS = ("gap", "report/gap", "report/studies", "fleet", "gap_bench", "real_rigs", "nodes", "cli")
ASKED = re.compile(r"\breport(?:\[|\.get\()\"(\w+)\"")
BESIDE = {"checks", "before_interval", "after_interval"}
"""What a report says beside its contract."""


def test_every_key_of_the_contract_is_typed_and_no_other(shared_dir):
    schema = json.loads((shared_dir / "gap_report.schema.json").read_text())["properties"]
    assert set(contract.Report.__annotations__) - BESIDE == set(schema)
    of_rows = {contract.Gap: schema["gap"], contract.Place: schema["where"]["items"], contract.Why: schema["why"]["items"],
               contract.Parameter: schema["why"]["items"]["properties"]["parameters"]["additionalProperties"],
               contract.Hypothesis: schema["hypotheses"]["items"], contract.Shrunk: schema["shrink"]["additionalProperties"],
               contract.Beyond: schema["unknown"], contract.NextTest: schema["next_test"]}
    for typed, said in of_rows.items():
        keys = set(typed.__annotations__) - BESIDE
        assert set(said["required"]) <= keys <= set(said["properties"]), typed.__name__
    assert set(get_args(get_type_hints(contract.Report)["verdict"])) == set(schema["verdict"]["enum"])


def test_readers_ask_for_what_a_report_has():
    asked = {}
    for room in READERS:
        for path in sorted((PACKAGE / room).rglob("*.py")):
            asked.update(dict.fromkeys(ASKED.findall(path.read_text(encoding="utf-8")), path.name))
    assert len(asked) >= 10 and set(asked) <= set(contract.Report.__annotations__), asked
