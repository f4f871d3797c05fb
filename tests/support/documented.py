"""Whether a page shows the figures that a study gives, as far as their printed digits go."""

import re
from pathlib import Path

from ddh_twin_py.real_rigs.study import Row

_NUMBER = re.compile(r"\d+(?:\.\d+)?")


def shown(page: Path, row: Row) -> bool:
    """Whether a table of the page has a row of as many samples with the figure before and after, rounded as it is printed."""
    for line in page.read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if str(row.samples) not in cells:
            continue
        figures = cells[cells.index(str(row.samples)) + 1 :]
        numbers = [found.group() for cell in figures[:2] if (found := _NUMBER.match(cell))]
        if len(numbers) == 2 and all(f"{value:.{len(printed.partition('.')[2])}f}" == printed
                                     for value, printed in zip((row.before, row.after), numbers, strict=True)):
            return True
    return False
