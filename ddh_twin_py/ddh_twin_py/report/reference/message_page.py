"""The project's messages, services and actions as a page of Markdown, from their definitions."""

from __future__ import annotations

from pathlib import Path

_FOOT = "*Written by `scripts/reference_pages.py` from `ddh_msgs`; change it there.*"
_KINDS = (("msg", "Messages", ("",)), ("srv", "Services", ("Request", "Response")), ("action", "Actions", ("Goal", "Result", "Feedback")))


def message_page(package: Path) -> str:
    """The page, for `docs/messages.md`.

    Args:
        package: folder `ddh_msgs`.
    """
    lines = [
        "# Messages", "",
        "Package `ddh_msgs`. Which topic has which: [topics](topics.md). Temperatures are also published as `sensor_msgs/Temperature`, "
        "health as `diagnostic_msgs/DiagnosticArray`, so that they show in any tool.", "",
    ]
    for folder, heading, parts in _KINDS:
        lines += [f"## {heading}", ""]
        for path in sorted((package / folder).glob(f"*.{folder}")):
            lines += _one(path, parts)
    return "\n".join([*lines, _FOOT, ""])


def _one(path: Path, parts: tuple[str, ...]) -> list[str]:
    text = path.read_text("utf-8")
    about = []
    while text.startswith("#"):
        first, _, text = text.partition("\n")
        about.append(first.lstrip("# "))
    lines = [f"### {path.stem}", "", " ".join(about), ""]
    for part, section in zip(parts, text.split("\n---\n"), strict=True):
        rows = [_row(line) for line in section.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        if part:
            lines += [f"**{part}**", ""]
        if rows:
            lines += ["| field | type | |", "|---|---|---|", *rows, ""]
    return lines


def _row(line: str) -> str:
    said, _, about = line.partition("#")
    kind, name = said.split(maxsplit=1)
    return f"| `{name.strip()}` | `{kind}` | {about.strip()} |".replace("\\|", "|")
