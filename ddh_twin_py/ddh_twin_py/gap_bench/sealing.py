"""The seal: the hash of every truth file, written before any diagnosis and checked before any score.

A truth holds the hash of its recordings, so that they are sealed with it.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import yaml

from ddh_twin_py.rig.files import write_whole

SEAL = "plan.sha256"
RECORDINGS = "recordings"
"""Key of a truth: hash of the case's recordings."""


class SealError(ValueError):
    """A bench whose truth is not what was sealed; one line that names the file."""


def seal(out: Path) -> Path:
    """Write OUT/plan.sha256 over all truth files.

    Raises:
        SealError: there is a seal already that says something else, or there is no truth.
    """
    files = sorted((out / "truth").glob("*.yaml"))
    if not files:
        raise SealError(f"{out}/truth: no case was made; run ddh-twin gap-bench make {out}")
    said = "".join(f"{_digest(file)}  truth/{file.name}\n" for file in files)
    target = out / SEAL
    if target.exists():
        verify(out)
        if target.read_bytes() != said.encode():
            raise SealError(f"{target}: the bench was sealed with other cases; use another folder")
        return target
    write_whole(target, said)
    return target


def verify(out: Path) -> list[str]:
    """Names of the sealed cases, their truth being what was sealed.

    Raises:
        SealError: no seal, a truth that is missing, was changed or came later, or recordings of a case that was not sealed.
    """
    target = out / SEAL
    if not target.is_file():
        raise SealError(f"{target}: no seal; run ddh-twin gap-bench make {out}")
    names = []
    for number, line in enumerate(target.read_text("utf-8", "replace").splitlines(), 1):
        digest, _, relative = line.partition("  ")
        file = out / relative
        if len(digest) != 64 or not relative.startswith("truth/"):
            raise SealError(f"{target}: line {number}: found {line[:60]!r}, a hash and a file of truth/ are needed")
        if not file.is_file():
            raise SealError(f"{file}: is sealed and missing")
        if _digest(file) != digest:
            raise SealError(f"{file}: was changed after it was sealed")
        if file.stem in names:
            raise SealError(f"{target}: line {number}: {relative} is sealed twice, and would count twice")
        names.append(file.stem)
    extra = sorted({file.stem for file in (out / "truth").glob("*.yaml")} - set(names))
    if extra:
        raise SealError(f"{out}/truth/{extra[0]}.yaml: was added after the bench was sealed")
    strangers = sorted({folder.name for folder in (out / "cases").glob("case_*") if folder.is_dir()} - set(names))
    if strangers:
        raise SealError(f"{out}/cases/{strangers[0]}: was added after the bench was sealed")
    return names


def truth_of(out: Path, name: str) -> dict:
    """The truth of one case, whose recordings are those that were sealed.

    Raises:
        SealError: a recording is missing, was changed or came later.
    """
    truth = _read(out, name)
    if RECORDINGS in truth and truth[RECORDINGS] != digest_of(out / "cases" / name):
        raise SealError(f"{out / 'cases' / name}: its recordings are not those that were sealed")
    return truth


def suite_of(out: Path, name: str) -> str:
    """The suite of one case; its recordings are not looked at."""
    return _read(out, name)["suite"]


def _read(out: Path, name: str) -> dict:
    return yaml.safe_load((out / "truth" / f"{name}.yaml").read_text())


def digest_of(folder: Path) -> str:
    """Hash of the names and contents of all files below a folder."""
    digest = hashlib.sha256()
    for file in sorted(path for path in folder.rglob("*") if path.is_file()):
        digest.update(f"{file.relative_to(folder).as_posix()} {_digest(file)}\n".encode())
    return digest.hexdigest()


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
