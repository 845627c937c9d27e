"""A node's command line: its help, what it does not understand, and parameters that it does not have.

--help           purpose, topics and parameters, from the node's module and its table of parameters
stray arguments  and parameters that no node of the process declares are refused, each with the nearest known name
given twice      a parameter whose last value ROS passes over for one of another kind before it is refused too
"""

import sys
import textwrap
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any

from rclpy.node import Node

from safe_files.yaml_io import parse_yaml, read_yaml
from thruster_runtime.parameters import Parameter

__all__ = ["asks_for_help", "help_text", "passed_over", "stray_arguments", "unknown_parameters"]

_HELP = ("-h", "--help")
_WILD = "/**"
_COMMON = """\
  executor             one of events, single; default events
      how callbacks are run
  use_sim_time         true or false; default false
      whether time is that of /clock"""


def asks_for_help(args: Sequence[str]) -> bool:
    """Tell whether the user's own arguments (without the program's name) ask for help."""
    return any(word in _HELP for word in _not_for_ros(args))


def _not_for_ros(args: Sequence[str]) -> list[str]:
    """Return what stands outside `--ros-args ... --`, also what ROS 1 would have taken for a new name, such as a:=b."""
    found, ours = [], True
    for word in args:
        if word in ("--ros-args", "--") and ours is (word == "--ros-args"):
            ours = not ours
        elif ours:
            found.append(word)
    return found


def help_text(program: str, doc: str, parameters: Iterable[Parameter]) -> str:
    """Return purpose, topics (`doc`, a module's docstring) and parameters of a node."""
    told = "\n".join(_told(each) for each in parameters)
    return (
        f"usage: {program} [--ros-args [-p PARAMETER:=VALUE ...] [--params-file FILE] [-r OLD:=NEW ...]]\n\n"
        f"{textwrap.dedent(doc).strip()}\n\nparameters (* may be changed while it runs):\n{told}\n{_COMMON}\n"
    )


def _told(each: Parameter) -> str:
    name = f"{each.name}{' *' if each.live else ''}"
    unit = f" [{each.unit}]" if each.unit else ""
    words = textwrap.fill(each.description, 110, initial_indent="      ", subsequent_indent="      ")
    return f"  {name:<20} {each.expected}{unit}; default {_default(each.default)}\n{words}"


def _default(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return "(empty)" if value in ("", ("",)) else f"{value:g}" if isinstance(value, float) else f"{value}"


def stray_arguments(program: str, args: Sequence[str], known: Iterable[str]) -> list[str]:
    """Return a sentence for each argument (without the program's name) that is not meant for ROS."""
    return [_stray(program, word, known) for word in _not_for_ros(args)]


def _stray(program: str, word: str, known: Iterable[str]) -> str:
    found = f"{program}: argument {word!r}: expected --ros-args before what a node is told"
    name, _, value = word.lstrip("-").replace(":=", "=").partition("=")
    nearest = get_close_matches(name, known, n=1, cutoff=0.5)
    return (
        f"{found}; perhaps --ros-args -p {nearest[0]}:={value or 'VALUE'}"
        if nearest
        else f"{found}; --help tells its parameters"
    )


def unknown_parameters(nodes: Sequence[Node], args: Sequence[str] | None = None) -> list[str]:
    """Return a sentence for each parameter that nodes were given and none of them declares.

    What a file says of all nodes ("/**") may be meant for others: it is passed over.

    Raises:
        YamlError: a file of parameters is none that the strict reader takes.
    """
    meant_for_all = _meant_for_all(_all_words(args))
    declared = {name for node in nodes for name in node._parameters}
    found = []
    for node in nodes:
        known = sorted(node._parameters)
        for name in node._parameter_overrides:
            if name in declared or name in meant_for_all:
                continue
            nearest = get_close_matches(name, known, n=1, cutoff=0.0)
            perhaps = f"; the nearest is {nearest[0]}" if nearest else ""
            where = node.get_fully_qualified_name()
            found.append(
                f"{where}: parameter {name}: expected one that this node has; found none of that name{perhaps}"
            )
    return found


def passed_over(nodes: Sequence[Node], args: Sequence[str] | None = None) -> list[str]:
    """Return a sentence for each parameter that was given again, as a value of another kind, and kept its first one.

    ROS keeps one value of each kind, and of those the first that is there of: truth, integer, number, text.

    Raises:
        YamlError: a file of parameters, or a value, is none that the strict reader takes.
    """
    words, found = _all_words(args), []
    for node in nodes:
        where = node.get_fully_qualified_name()
        for name, kept in node._parameter_overrides.items():
            given = list(_given(words, {"", _WILD, node.get_name(), where}, name))
            if len(given) > 1 and _kind(given[-1]) is not _kind(kept.value):
                found.append(
                    f"{where}: parameter {name}: expected one value, or values of one kind; found {given[-1]!r} after "
                    f"{kept.value!r}, which ROS would keep"
                )
    return found


def _all_words(args: Sequence[str] | None) -> list[str]:
    return list(sys.argv[1:] if args is None else args)


def _given(words: Sequence[str], of_node: Container[str], name: str) -> Iterator[Any]:
    """Yield the values that a command line and the files that it names give to a node's parameter, in order."""
    for flag, word in pairwise(words):
        if flag == "--params-file":
            for node, told in _mapping(read_yaml(Path(word))).items():
                parameters = _mapping(_mapping(told).get("ros__parameters"))
                if node in of_node and name in parameters:
                    yield parameters[name]
        elif flag in ("-p", "--param"):
            key, _, value = word.partition(":=")
            node, _, own = key.rpartition(":")
            if node in of_node and own == name:
                yield parse_yaml(value, f"parameter {name}")


def _kind(value: Any) -> type:
    """Return what ROS takes a value for; lists are one kind."""
    kinds = (bool, int, float, str)
    return next((kind for kind in kinds if isinstance(value, kind)), list)


def _meant_for_all(args: Sequence[str]) -> set[str]:
    """Return the names that the files on a command line give to all nodes, less those given in it by themselves."""
    names: set[str] = set()
    for flag, word in pairwise(args):
        if flag == "--params-file":
            of_all = _mapping(_mapping(read_yaml(Path(word))).get(_WILD))
            names |= set(_mapping(of_all.get("ros__parameters")))
    given = {word.partition(":=")[0] for flag, word in pairwise(args) if flag in ("-p", "--param")}
    return names - given


def _mapping(found: Any) -> Mapping[str, Any]:
    """Return a mapping as it is; ROS itself has refused what should be one and is not."""
    return found if isinstance(found, Mapping) else {}
