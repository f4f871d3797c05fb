"""The page's own files, read once."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib import resources

_TYPES = {
    ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml; charset=utf-8",
}  # fmt: skip
_OF_REPORTS = ("language.js", "uplot/uPlot.iife.min.js", "uplot/uPlot.min.css")  # the same files as in reports


@dataclass(frozen=True)
class Asset:
    """One file: its bytes, media type, and a tag that changes with its content."""

    content: bytes
    media_type: str
    tag: str


def assets() -> dict[str, Asset]:
    """All files by the name under which the page asks for them."""
    found = {}
    for file in resources.files("ddh_twin_py.web").joinpath("assets").iterdir():
        found[file.name] = _asset(file)
    for path in _OF_REPORTS:
        file = resources.files("ddh_twin_py.report").joinpath("assets", *path.split("/"))
        found[file.name] = _asset(file)
    return found


def version(files: dict[str, Asset]) -> str:
    """A mark of all files together: a page that is open reloads itself where it has changed."""
    return hashlib.sha256("".join(files[name].tag for name in sorted(files)).encode()).hexdigest()[:16]


def _asset(file) -> Asset:
    content = file.read_bytes()
    suffix = file.name[file.name.rindex(".") :]
    return Asset(content, _TYPES[suffix], hashlib.sha256(content).hexdigest()[:16])
