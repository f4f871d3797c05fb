"""Writes docs/effects from the catalogue of effects: a page each and an index. Run it with the project's Python."""

from pathlib import Path

from ddh_twin_py.report.reference.effect_pages import effect_pages

folder = Path(__file__).resolve().parent.parent / "docs" / "effects"
folder.mkdir(exist_ok=True)
pages = effect_pages()
for old in folder.glob("*.md"):
    if old.name not in pages:
        old.unlink()
for name, text in pages.items():
    (folder / name).write_text(text, encoding="utf-8")
print(f"{folder}: {len(pages)} pages")
