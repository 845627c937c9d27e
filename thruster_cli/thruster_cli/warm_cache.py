"""Import each program of `thruster` once, which leaves its modules compiled:   python -m thruster_cli.warm_cache"""

import importlib

from thruster_cli.cli_thruster import PROGRAMS


def main() -> None:
    """Import the programs, and those for vehicles."""
    for program in PROGRAMS.values():
        for module in filter(None, (program.module, program.of_vehicle)):
            importlib.import_module(module)


if __name__ == "__main__":
    main()
