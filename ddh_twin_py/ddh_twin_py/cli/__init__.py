"""The `ddh-twin` command: one file per verb, each with `add_parser(subparsers)` and `run(args) -> int`.

Verbs import what they need when they run, so that `--help` and a mistyped option answer at once.
"""
