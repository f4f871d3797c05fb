"""`ddh-twin completion`: completion of verbs, options, values and files for a shell."""

from __future__ import annotations

import argparse

from ddh_twin_py.cli.arguments import OUTPUTS, add_json, add_verb

_EXAMPLE = """\
  ddh-twin completion bash > ~/.local/share/bash-completion/completions/ddh-twin
  ddh-twin completion zsh > ~/.zfunc/_ddh-twin        with fpath+=(~/.zfunc) before compinit in .zshrc
  ddh-twin completion fish > ~/.config/fish/completions/ddh-twin.fish"""
_SHELLS = ("bash", "zsh", "fish")
_FILES = ("FILE", "BAG", "FIELD", "LOG", "DUTY", "RIG.yaml")
_FOLDERS = ("FOLDER",)


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "completion", "print what makes a shell complete this command",
        "Prints a script for bash, zsh or fish. It is complete in itself: the shell does not start Python at each press of the key.",
        _EXAMPLE,
    )
    parser.add_argument("shell", metavar="SHELL", choices=_SHELLS, help="bash, zsh or fish")
    add_json(parser, "write verbs, options and choices as JSON; - is standard output, in the place of the script")


def run(args: argparse.Namespace) -> int:
    """Print the script."""
    import shtab

    from ddh_twin_py.cli.command_tree import command_tree
    from ddh_twin_py.cli.console import put_json
    from ddh_twin_py.cli.main import build_parser

    parser = build_parser()
    if args.json:
        put_json(args.json, command_tree(parser))
    if args.json == "-":
        return 0
    _mark_values(parser, shtab)
    print(shtab.complete(parser, shell=args.shell))
    return 0


def _mark_values(parser: argparse.ArgumentParser, shtab) -> None:
    """Tell which arguments are files, which are folders and which are effects."""
    from ddh_twin_py.gap.catalogue import EFFECTS

    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for child in action.choices.values():
                _mark_values(child, shtab)
        elif action.choices is None and (action.type in OUTPUTS or action.metavar in _FILES):
            action.complete = shtab.FILE
        elif action.metavar == "EFFECT":
            action.choices = sorted(EFFECTS)
        elif action.metavar in _FOLDERS:
            action.complete = shtab.DIRECTORY
