"""The command line as plain data: what a shell, an editor or another program has to know to offer it."""

from __future__ import annotations

import argparse


def command_tree(parser: argparse.ArgumentParser) -> dict:
    """Verbs by name, each with `help` and `arguments`; an argument has `names` (none where it stands by its place), `value`, `help`,
    `required`, and `choices` where there are some.
    """
    tree: dict[str, dict] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            about = {choice.dest: choice.help for choice in action._choices_actions}
            for verb, child in action.choices.items():
                arguments = [_argument(one) for one in child._actions if not isinstance(one, argparse._HelpAction)]
                tree[verb] = {"help": about[verb], "arguments": arguments}
    return tree


def _argument(action: argparse.Action) -> dict:
    value = None if action.nargs == 0 else action.metavar or action.dest
    told = {"names": list(action.option_strings), "value": value, "help": action.help, "required": action.required}
    return told | ({"choices": [str(choice) for choice in action.choices]} if action.choices is not None else {})
