"""What a hypothesis had to bear before it was believed: every rule that was asked, what it measured, and from where it would doubt."""

from __future__ import annotations

from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.report import document as doc
from ddh_twin_py.report.gap_words import set_name
from ddh_twin_py.report.units import number

CHECKS = {
    "structure": ("Structure that it leaves in the field recording, in the signal that asks loudest for a free form", "log evidence", 0.0),
    "left_behind": ("The farthest signal of the held-out data of those that it brings nearer, whatever is open of the rig", "× floor", 1.0),
    "far_off": ("The middle one of all signals of the held-out data, whatever is open of the rig", "× floor", 1.0),
    "worsened": ("A signal of the held-out data that it moves away from what was measured", "× floor", 0.0),
    "refuted": ("The gap of the held-out data with it, less that without", "× floor", 0.0),
    "strained": ("The farthest fast signal of the commissioning recording, with the rig that it asks for", "× floor", 1.0),
    "off_its_noise": ("Means of speed or rod velocity over steady stretches of the field recording", "× noise", 1.0),
    "drifted": ("It asks for another rig than was commissioned", "standard deviations", 0.0),
    "displaced": ("Held-out data ask for another rig, or another begin, than the field recording", "standard deviations", 0.0),
    "resized": ("Held-out data ask for another size of it", "squared deviations", 0.0),
    "bent": ("Its law would have to do more in some phases, at some speeds or temperatures, and less in others", "log evidence", 0.0),
    "cancelling": ("Share of what its two effects do that they take from each other", "1", 0.0),
}
"""Of each check: what it measures, the unit, and where nothing is measured but noise."""
_NEAR = 0.75  # of the way to the limit, from which a check is near it
_ABOUT = (
    "Each is a rule by which a cause outside the catalogue becomes likelier. At the limit such a cause is as likely as not by that rule "
    "alone; well below it the rule has nothing to say. A rule that does not apply was not asked. Beyond the limit the notes "
    "say what follows, or why it does not."
)


def checks_of(diagnosis: Diagnosis) -> doc.Html:
    """The checks as a table, empty where none was made."""
    rows = diagnosis.report.get("checks", [])
    if not rows:
        return doc.Html("")
    columns = (doc.Column("Checked", number=False), doc.Column("Unit", number=False), doc.Column("Measured"), doc.Column("Limit"),
               doc.Column("Of the way to it", number=False))
    table = []
    for row in rows:
        about, unit, noise = CHECKS[row["check"]]
        share = (row["measured"] - noise) / (row["limit"] - noise)
        level = "good" if share < _NEAR else "fair" if share < 1.0 else "poor"
        table.append((about, "" if unit == "1" else unit, number(row["measured"], 2), number(row["limit"], 2),
                      doc.mark(level, "none of it" if share <= 0.0 else f"{number(100.0 * share, 0)} %")))
    return doc.Html(doc.paragraph(f"Asked about: {set_name(tuple(rows[0]['effects']))}.") + doc.table(columns, table) + doc.note(_ABOUT))
