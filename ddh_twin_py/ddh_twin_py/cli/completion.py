"""`ddh-twin completion`: completion of verbs, options, values and files for a shell."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from ddh_twin_py.cli.arguments import OUTPUTS, add_json, add_verb
from ddh_twin_py.twin.duty_file import duty_file

_EXAMPLE = """\
  ddh-twin completion bash > ~/.local/share/bash-completion/completions/ddh-twin
  ddh-twin completion zsh > ~/.zfunc/_ddh-twin        with fpath+=(~/.zfunc) before compinit in .zshrc
  ddh-twin completion fish > ~/.config/fish/completions/ddh-twin.fish"""
_SHELLS = ("bash", "zsh", "fish")
_FILES = ("FILE", "BAG", "FIELD", "LOG", "RIG.yaml")
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


def _named(action: argparse.Action) -> dict | None:
    """Completion of an argument whose values have names, None of any other."""
    from ddh_twin_py.gap.catalogue import EFFECTS
    from ddh_twin_py.twin.temperature_sensors import SENSORS

    if action.metavar == "EFFECT":
        return _one_of("effect", sorted(EFFECTS))
    if action.dest == "sensors" and action.metavar == "LIST":
        return _several_of("sensors", [*SENSORS, "none"])
    if action.dest == "duty" or action.metavar == "DUTY":
        duties = sorted(file.stem for file in duty_file("mixed").parent.glob("*.yaml"))
        return _several_of("duties", duties) if action.metavar == "LIST" else _one_of("duty", duties, or_file=True)
    return None


def _one_of(kind: str, names: Sequence[str], or_file: bool = False) -> dict:
    """Completion by one of some names, or by a file as well."""
    listed, function = " ".join(names), f"_ddh_twin_{kind}{'_or_file' * or_file}"  # shtab quotes file names where `_file` is in it
    bash = f'compgen -W "{listed}" -- "$1"' + '; compgen -f -- "$1"' * or_file
    return {
        "bash": function, "zsh": f"{{compadd -- {listed}{'; _files' * or_file}}}",
        "fish": listed + " (__fish_complete_path (commandline -ct))" * or_file, "preamble": {"bash": f"{function}() {{ {bash}; }}"},
    }


def _several_of(kind: str, names: Sequence[str]) -> dict:
    """Completion of the last part of a list with commas."""
    listed, function = " ".join(names), f"_ddh_twin_{kind}"
    bash = f'local last="${{1##*,}}"; compgen -P "${{1%"$last"}}" -W "{listed}" -- "$last"'
    return {
        "bash": function, "zsh": f" _values -s , {kind} {listed}", "fish": f"(__fish_append , {listed})",
        "preamble": {"bash": f"{function}() {{ {bash}; }}"},
    }


def _mark_values(parser: argparse.ArgumentParser, shtab) -> None:
    """Tell which arguments are files, which are folders and which have names."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for child in action.choices.values():
                _mark_values(child, shtab)
        elif (named := _named(action)) is not None:
            action.complete = named
        elif action.choices is None and (action.type in OUTPUTS or action.metavar in _FILES):
            action.complete = shtab.FILE
        elif action.metavar in _FOLDERS:
            action.complete = shtab.DIRECTORY
