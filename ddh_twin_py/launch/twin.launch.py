"""The twin's nodes, as `ddh-twin up` starts them, with the same arguments.

    ros2 launch ddh_twin_py twin.launch.py source:=bag bag:=bags/paper_cycle rate:=0
    ros2 launch ddh_twin_py twin.launch.py --show-args
"""

import argparse
from datetime import datetime
from pathlib import Path

from ddh_twin_py.cli import up
from ddh_twin_py.cli.supervisor import UNUSABLE
from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
    Shutdown,
    TimerAction,
)
from launch.event_handlers import OnProcessExit, OnProcessIO
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

RESPAWN_DELAY = 2.0  # s
NOT_HERE = ("help", "json")  # arguments of `ddh-twin up` that launch has no use for
LINGER = 4.0  # s that the models have to work off what they hold, once the source has ended


def parser():
    """The parser of `ddh-twin up`, from which the arguments are taken."""
    verbs = argparse.ArgumentParser().add_subparsers(parser_class=up.Parser)
    up.add_parser(verbs)
    return verbs.choices["up"]


def options():
    """Name, default as text and help of every argument."""
    for action in parser()._actions:
        if action.dest in NOT_HERE:
            continue
        default = "" if action.default is None else str(action.default)
        choices = [str(choice) for choice in action.choices] if action.choices else None
        yield action.dest, default.lower() if isinstance(action.default, bool) else default, action.help, choices


def command_line(values):
    """The arguments as `ddh-twin up` would have got them."""
    line = []
    for action in parser()._actions:
        value = values.get(action.dest, "")
        if action.nargs == 0:
            line += [action.option_strings[-1]] if value.lower() in ("true", "1") else []
        elif value:
            line += [f"{action.option_strings[-1]}={value}"]
    return line


def nodes(context):
    """What to start, once the arguments are known."""
    values = {name: LaunchConfiguration(name).perform(context) for name, *_ in options()}
    arguments = parser().parse_args(command_line(values))
    up.check(arguments)
    actions = [SetEnvironmentVariable(name, value) for name, value in up.environment_additions().items()]
    for name, parameters in up.node_parameters(arguments).items():
        node = Node(
            package="ddh_twin_py",
            executable=name,
            namespace=arguments.namespace,
            parameters=([arguments.params] if arguments.params else []) + [parameters],
            output="log" if arguments.quiet else "screen",
            respawn=name not in up.ENDING,
            respawn_delay=RESPAWN_DELAY,
        )
        actions.append(node)
        actions.append(RegisterEventHandler(OnProcessExit(target_action=node, on_exit=end if name in up.ENDING else refused)))
    if arguments.log:
        actions.append(RegisterEventHandler(writer(arguments.log)))
    return actions


def refused(event, context):
    """A node that is started again has ended: stop all, where it cannot use what it was given."""
    if event.returncode == UNUSABLE:
        return [Shutdown(reason=f"{event.process_name} cannot use what it was given")]
    return []


def end(event, context):
    """The source has ended: stop all, when the models have worked off what they hold."""
    if event.returncode:
        return [Shutdown(reason=f"{event.process_name} ended with exit code {event.returncode}")]
    return [TimerAction(period=LINGER, actions=[Shutdown(reason="the source has come to its end")])]


def writer(path):
    """Writes what all nodes say into one file, as `ddh-twin up --log` does."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    file = open(path, "a", encoding="utf-8")

    def write(event):
        for line in event.text.decode("utf-8", "replace").splitlines():
            file.write(f"{datetime.now():%H:%M:%S.%f} {event.process_name:<18} | {line}\n")
        file.flush()

    return OnProcessIO(on_stdout=write, on_stderr=write)


def generate_launch_description():
    """All arguments of `ddh-twin up`, then its nodes."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text, **({"choices": choices} if choices else {}))
        for name, default, text, choices in options()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
