"""Print docs/commands.md: every command, program, node and script, as each tells of itself.

Options are read off the parsers, not off their help, which no two versions of Python print alike.
"""

import argparse
import contextlib
import importlib
import io
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from unittest import mock

from thruster_cli.cli_thruster import PROGRAMS

ROOT = Path(__file__).resolve().parents[2]
HEAD = """\
# Commands

Made by `scripts/workspace/commands_page.py` from what each command says of itself. `thruster COMMAND` takes recordings,
sets, fits and diagnoses. Every other program and node runs by `ros2 run`; the scripts set up what they need themselves.
"""


class _Parser(Exception):
    """Ends a program where it would read its arguments, and brings its parser."""


def page() -> str:
    """Return the whole page."""
    commands: dict[str, str] = {}
    for name, program in PROGRAMS.items():
        commands[program.module] = f"thruster {name}"
        if program.of_vehicle:
            commands[program.of_vehicle] = f"thruster {name} --vehicle"
    parts = [HEAD, "\n## thruster\n"]
    for module, command in commands.items():
        also = [f"`ros2 run {package} {name}`" for package, name, behind in executables() if behind == module]
        parser = _parser(module, command.removesuffix(" --vehicle"))
        parts.append(_section(command, parser, f"Also {', '.join(also)}."))
    others = [each for each in executables() if each[2] not in commands and not each[2].startswith("thruster_cli.")]
    parts.append("\n## Programs\n\n" + _second_names(commands))
    for package, name, module in others:
        if not module.endswith("_node"):
            parts.append(_section(f"ros2 run {package} {name}", _parser(module, name)))
    parts.append("\n## Nodes\n")
    parts += [_node(*each) for each in others if each[2].endswith("_node")]
    parts.append("\n## Scripts\n\n" + "".join(_script(file) for file in sorted((ROOT / "scripts").glob("*.sh"))))
    return "".join(parts)


def _second_names(commands: Mapping[str, str]) -> str:
    """Return the table of programs that are commands of `thruster`, by module."""
    rows = [
        f"| `{package} {name}` | `{commands[module]}` |"
        for package, name, module in executables()
        if module in commands
    ]
    return "\n".join(["| `ros2 run ...` | is the command |", "|---|---|", *rows]) + "\n"


def executables() -> list[tuple[str, str, str]]:
    """Return package, name and module of everything that `ros2 run` knows."""
    found = []
    for file in sorted(ROOT.glob("*/setup.py")):
        declared = re.findall(r'"?(\w+) = ([\w.]+):main"', file.read_text("utf-8"))
        found += [(file.parent.name, name, module) for name, module in sorted(declared)]
    return found


def _parser(module: str, program: str) -> argparse.ArgumentParser:
    """Return the parser of a program, which is started and ended where it asks for its arguments."""

    def asked(self: argparse.ArgumentParser, *_: object) -> None:
        raise _Parser(self)

    main = importlib.import_module(module).main
    named = {"program": program} if program.startswith("thruster ") else {}
    with mock.patch.object(argparse.ArgumentParser, "parse_args", asked):
        try:
            main([], **named)
        except _Parser as found:
            parser: argparse.ArgumentParser = found.args[0]
            return parser
    raise RuntimeError(f"{module}: expected a program that reads its arguments by argparse")


def _section(command: str, parser: argparse.ArgumentParser, also: str = "") -> str:
    """Return the heading, purpose, arguments and examples of a program, and of the commands inside it."""
    purpose, _, more = (parser.description or "").strip().partition("\n\n")
    purpose = " ".join(purpose.split())
    purpose = f"{purpose[:1].upper()}{purpose[1:].rstrip('.')}."
    lines = [f"\n### {command}\n", f"{purpose} {also}".rstrip(), ""]
    if more.strip():
        lines += ["```text", more.strip("\n").rstrip(), "```", ""]
    rows = [_row(action, parser) for action in _actions(parser)]
    if rows:
        lines += ["| argument | what it is |", "|---|---|", *rows, ""]
    examples = (parser.epilog or "").partition("examples:")[2]
    if examples:
        shown = (examples % {"prog": parser.prog}).strip().split("\n")
        lines += ["```bash", *(line.strip() for line in shown), "```", ""]
    text = "\n".join(lines).rstrip("\n") + "\n"
    return text + "".join(_section(f"{command} {name}", inner) for name, inner in _commands_inside(parser))


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the arguments in order, what has to be given first; not `--help`, nor what is hidden."""
    shown = [
        each for each in parser._actions
        if each.help != argparse.SUPPRESS and not isinstance(each, (argparse._HelpAction, argparse._SubParsersAction))
    ]  # fmt: skip
    yield from sorted(shown, key=lambda each: (bool(each.option_strings), not each.required))


def _commands_inside(parser: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            told = {each.dest: each.help for each in action._choices_actions}
            for name, inner in action.choices.items():
                inner.description = inner.description or told.get(name)
                yield name, inner


def _row(action: argparse.Action, parser: argparse.ArgumentParser) -> str:
    value = _value(action)
    names = ", ".join(action.option_strings)
    said = (action.help or "") % {**vars(action), "prog": parser.prog}
    if action.option_strings and action.required:
        said = f"{said}{'; ' if said else ''}has to be given"
    elif action.option_strings and isinstance(action.default, (Path, str, int, float)) and action.nargs != 0:
        default = str(action.default)
        told = not default or "default" in said or f"({default}" in said
        said = said if told else f"{said} (default {default})".lstrip()
    return f"| `{' '.join(filter(None, (names, value)))}` | {_plain(' '.join(said.split()))} |"


def _value(action: argparse.Action) -> str:
    """Return what stands for the values of an argument, as argparse writes it."""
    if action.nargs == 0:
        return ""
    kind = action.metavar or (action.choices and "{" + ",".join(map(str, action.choices)) + "}")
    shown = kind or (action.dest.upper() if action.option_strings else action.dest)
    if isinstance(shown, tuple):
        return " ".join(shown)
    forms = {"*": f"[{shown} ...]", "+": f"{shown} ...", "?": f"[{shown}]"}
    if isinstance(action.nargs, int):
        return " ".join([str(shown)] * action.nargs)
    return forms.get(action.nargs or "", str(shown))


def _node(package: str, name: str, module: str) -> str:
    """Return the section of a node, whose help is of our own making."""
    told = io.StringIO()
    with (
        mock.patch.object(sys, "argv", [name, "--help"]),
        contextlib.redirect_stdout(told),
        contextlib.suppress(SystemExit),
    ):
        importlib.import_module(module).main()
    return f"\n### ros2 run {package} {name}\n\n```text\n{told.getvalue().strip()}\n```\n"


def _script(file: Path) -> str:
    """Return the section of a script: the comment at its head."""
    head = []
    for line in file.read_text("utf-8").split("\n"):
        if not line.startswith("#"):
            break
        if not line.startswith("#!"):
            head.append(line.removeprefix("#").removeprefix(" ").rstrip())
    return f"### scripts/{file.name}\n\n```text\n{chr(10).join(head).strip()}\n```\n\n"


def _plain(text: str) -> str:
    """Return a text that Markdown shows as it is, in a cell."""
    return re.sub(r"([\\`*_|<>\[\]])", r"\\\1", text)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the page."""
    if arguments or sys.argv[1:]:
        sys.exit("usage: commands_page.py > docs/commands.md")
    print(page().rstrip("\n"))


if __name__ == "__main__":
    main()
