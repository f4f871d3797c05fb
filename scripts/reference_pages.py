"""Writes the pages of docs that are made from code: command line, messages, rig sheet. Run it with the project's Python."""

from pathlib import Path

from ddh_twin_py.cli.command_line_page import command_line_page
from ddh_twin_py.cli.main import build_parser
from ddh_twin_py.report.reference.message_page import message_page
from ddh_twin_py.report.reference.rig_sheet_page import rig_sheet_page

root = Path(__file__).resolve().parent.parent
pages = {
    "command_line.md": command_line_page(build_parser()),
    "messages.md": message_page(root / "ddh_msgs"),
    "rig_sheet.md": rig_sheet_page(),
}
for name, text in pages.items():
    (root / "docs" / name).write_text(text, encoding="utf-8")
print(f"{root / 'docs'}: {', '.join(pages)}")
