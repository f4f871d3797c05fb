"""The documents as a site (Sphinx): make docs, then open out/site/index.html. Nothing is fetched when it is built or read."""

project = "DDH twin"
html_title = "DDH twin"
copyright = "DDH twin maintainers, Apache-2.0"

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["pictures"]
myst_heading_anchors = 4  # links lead to headings
myst_enable_extensions = ["html_image"]  # pictures that are written as <img>, for their width
highlight_language = "none"

html_theme = "furo"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"source_repository": "", "top_of_page_buttons": []}
pygments_style, pygments_dark_style = "friendly", "native"

CONTENTS = (
    ("", ("tutorial",)),
    ("How to", ("howto_machine", "howto_rig_sheet", "howto_sensor", "howto_effect", "other_tools", "ros2_machine")),
    ("What it does", ("live_page", "gap_report", "gap_design", "fleet", "calibration", "real_rigs", "cold_start", "paper")),
    ("How it works", ("architecture", "physics", "motor_network", "estimation", "gap_method", "gap_bench", "gap_bench_history",
                      "another_rig", "performance")),
    ("Reference", ("command_line", "topics", "clocks", "messages", "rig_sheet", "effects/README")),
)
"""Headings of the navigation and their pages; what is in none of them comes last, so that no page is lost."""


def _add_contents(app, page, content):
    """The navigation: appended to the index, so that the page itself stays plain Markdown; effects to theirs."""
    if page == "index":
        listed = {name for _, names in CONTENTS for name in names}
        others = sorted(app.env.found_docs - listed - {"index"} - {name for name in app.env.found_docs if name.startswith("effects/")})
        for heading, names in (*CONTENTS, ("Nodes and more", others)):
            present = [name for name in names if name in app.env.found_docs]
            caption = f":caption: {heading}\n" if heading else ""
            content[0] += "\n\n```{toctree}\n:hidden:\n" + caption + "\n" + "\n".join(present) + "\n```\n"
    elif page == "effects/README":
        names = sorted(name.removeprefix("effects/") for name in app.env.found_docs if name.startswith("effects/") and name != page)
        content[0] += "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


def setup(app):
    """Hook the navigation in."""
    app.connect("source-read", _add_contents)
