"""A case on disk: a folder with the bags field/, and perhaps commissioning/ and validation/."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

PARTS = ("field", "commissioning", "validation")


class CaseError(ValueError):
    """What was given is no case; one line for people."""


@dataclass(frozen=True)
class Case:
    """Recordings of one rig: `field` at least one; `commissioning` and `validation` may be absent. `rig`: file or None."""

    field: tuple[Path, ...]
    commissioning: Path | None = None
    validation: Path | None = None
    rig: Path | None = None


def case_of(field: list[str] | list[Path], commissioning: str | Path | None = None, validation: str | Path | None = None,
            rig: str | Path | None = None) -> Case:
    """The case that was asked for; a single folder that holds field/ gives its other bags too, unless they are named.

    Raises:
        CaseError: no field recording, an empty name, or a path that is not there.
    """
    paths = [Path(p) for p in field if str(p)]
    if not paths or len(paths) != len(field):
        raise CaseError(f"field: value is {[str(p) for p in field]}, at least one path of a bag or a case folder is needed, none empty")
    named = {"commissioning": commissioning, "validation": validation, "rig": rig}
    found = {name: Path(given) if given else None for name, given in named.items()}
    for name, path in [*(("field", p) for p in paths), *found.items()]:
        if path is not None and not path.exists():
            raise CaseError(f"{name}: there is no {path}")
    if len(paths) == 1 and (paths[0] / "field").is_dir():
        folder = paths[0]
        paths = [folder / "field"]
        for name in PARTS[1:]:
            if found[name] is None and (folder / name).is_dir():
                found[name] = folder / name
    return Case(tuple(paths), **found)
