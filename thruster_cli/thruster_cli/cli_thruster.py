"""One command for recordings of thrusters, parameter sets, fits and diagnoses: `thruster COMMAND ...`.

Each sub-command is the program of another package, loaded when it is called, which alone tells of its options.
"""

import contextlib
import importlib
import io
import re
import sys
from typing import Any, NamedTuple

import typer
from typer.core import TyperCommand

from run_bag.command_line import of_a_vehicle


class Program(NamedTuple):
    """Where a sub-command's `main(arguments, program)` is, what it is for; where it is for a `--vehicle`."""

    module: str
    purpose: str
    of_vehicle: str = ""


PROGRAMS = {
    "import": Program("run_bag.importers.cli_recording", "Make a run of a recording: csv, bags, ArduPilot's logs."),
    "show": Program("run_bag.cli_show", "Draw the channels of a run in one HTML file."),
    "check": Program(
        "gap_diagnosis.cli_check",
        "Say what runs are good for, a vehicle's with --vehicle.",
        "gap_diagnosis.vehicle.cli_check_vehicle",
    ),
    "fit": Program(
        "thruster_model.cli_fit",
        "Fit models to runs, a vehicle with --vehicle; write sets.",
        "gap_diagnosis.vehicle.cli_fit_vehicle",
    ),
    "diagnose": Program(
        "gap_diagnosis.cli_diagnose",
        "Say why runs and a set disagree, a vehicle's with --vehicle.",
        "gap_diagnosis.vehicle.cli_diagnose_vehicle",
    ),
    "compare": Program("gap_diagnosis.cli_compare", "Hold a simulator's own predictions against a recording."),
    "simulate": Program("rov_sim.cli_bench_campaign", "Record what the thruster of a set would do, as runs."),
    "report": Program("run_bag.cli_overview", "Make one page that links the reports and runs of a folder."),
    "new-set": Program(
        "thruster_model.cli_new_set",
        "Write a commented set to be edited, a vehicle's with --vehicle.",
        "thruster_model.cli_new_vehicle",
    ),
}


WRONG_USAGE = 2
"""Status with which a parser ends."""


class _Completion(NamedTuple):
    """What a shell is offered, with the fields that typer's completion asks for."""

    value: str
    type: str = "plain"
    help: str | None = None


def _options_of(name: str) -> list[str]:
    """Return the options that a program's own help tells of."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.suppress(SystemExit):
        _call(name, ["--help"])
    return list(dict.fromkeys(re.findall(r"(?<![\w-])--[a-z][\w-]*", told.getvalue())))


def _call(name: str, arguments: list[str]) -> int:
    program = PROGRAMS[name]
    vehicle = program.of_vehicle and of_a_vehicle(arguments)
    module = importlib.import_module(program.of_vehicle if vehicle else program.module)
    try:
        return int(module.main(arguments, program=f"thruster {name}"))
    except SystemExit as ended:
        if ended.code == WRONG_USAGE and program.of_vehicle and not vehicle:
            print(f"of a vehicle, its set is named: thruster {name} --vehicle SET ...", file=sys.stderr)
        raise
    finally:
        if program.of_vehicle and not vehicle and {"--help", "-h"} & set(arguments):
            print("\nof a vehicle:")
            importlib.import_module(program.of_vehicle).main(["--help"], program=f"thruster {name}")


class _PassedOn(TyperCommand):
    """A command whose arguments, `--help` too, are another program's."""

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """Return the program's options; file names are completed by the shell."""
        if not incomplete.startswith("-"):
            return []
        return [_Completion(each) for each in _options_of(self.name or "") if each.startswith(incomplete)]


app = typer.Typer(name="thruster", no_args_is_help=True, help=(__doc__ or "").split("\n")[0], rich_markup_mode=None)


def _add(name: str) -> None:
    passed_on = {"ignore_unknown_options": True, "allow_extra_args": True, "allow_interspersed_args": False}

    @app.command(
        name,
        cls=_PassedOn,
        help=PROGRAMS[name].purpose,
        add_help_option=False,
        context_settings=passed_on,
    )
    def command(context: typer.Context) -> None:
        raise typer.Exit(_call(name, list(context.args)))


for _name in PROGRAMS:
    _add(_name)


def main() -> None:
    """Run the command; end with the status of the program that was called."""
    app(prog_name="thruster")


if __name__ == "__main__":
    main()
