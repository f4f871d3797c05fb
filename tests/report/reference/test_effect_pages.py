"""The pages of docs/effects: as the catalogue is now, complete, every link leads somewhere."""

import re

from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.report.reference.effect_pages import INDEX, effect_pages


def test_the_pages_are_up_to_date(repo_root):
    written = {path.name: path.read_text(encoding="utf-8") for path in (repo_root / "docs" / "effects").iterdir()}
    assert written == effect_pages(), "run scripts/effect_pages.py"


def test_every_effect_has_a_page_that_says_all(repo_root):
    pages = effect_pages()
    assert set(pages) == {INDEX, *(f"{name}.md" for name in EFFECTS)}
    for name, effect in EFFECTS.items():
        page = pages[f"{name}.md"].replace("\\|", "|")
        for said in (effect.happens(1.0), effect.law, effect.signature, effect.check, effect.domain):
            assert said and said in page, (name, said)
        assert effect.happens(-1.0)[1:] in page and "{" not in f"{effect.happens(1.0)}{effect.happens(-1.0)}"
        assert all(f"({other}.md)" in page for other in effect.confused_with)


def test_links_lead_somewhere():
    pages = effect_pages()
    for name, page in pages.items():
        found = re.findall(r"\]\(([^)]+)\)", page)
        assert found and all(target in pages for target in found), name
