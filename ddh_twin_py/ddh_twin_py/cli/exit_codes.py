"""What `ddh-twin` leaves with."""

from __future__ import annotations

EXIT_CODES = {
    0: "done",
    1: "done, and the answer is no",
    2: "what was given cannot be used, said in one line on standard error",
    130: "interrupted (Ctrl-C)",
    143: "terminated (SIGTERM)",
}
"""Code to meaning, for every verb."""

NO = {
    "calibrate": "nothing, or nothing that --only asked for, can be identified, and no rig file is written; or the fit does not describe "
                 "the machine",
    "doctor": "something does not work",
    "fleet": "a result could not be kept; it is in the table",
    "up": "the player of a bag crashed, a bag was played and --normal-file was not written, not all was recorded, or a node did not stop "
          "and was killed",
}
"""Verbs that can answer no, and what it means."""
