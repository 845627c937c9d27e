"""Write the parameters of a bench experiment's nodes into a folder, and say which nodes to start.

Prints one line for each node, in the order in which they start: NAME PACKAGE EXECUTABLE. In the folder: NAME.yaml for
each of them as `--params-file` takes it.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rov_sim.bench_graph import BenchExperiment, bench_graph
from rov_sim.graph_files_io import line_of, write_parameters
from run_bag.command_line import user_arguments

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the files; return the exit status."""
    parser = argparse.ArgumentParser(prog="bench_graph", description=__doc__.splitlines()[0])
    parser.add_argument(
        "--out", type=Path, required=True, help="folder of run and port, which exists; files in its nodes/"
    )
    for name in ("reference", "strategy"):
        parser.add_argument(f"--{name}", required=True)
    for name in ("port", "firmware", "protocol", "truth", "effects", "set", "form"):
        parser.add_argument(f"--{name}", default=getattr(BenchExperiment, name))
    parser.add_argument("--seed", type=int, default=BenchExperiment.seed)
    parser.add_argument("--no-noise", dest="noise", action="store_false")
    parser.add_argument("--real-time", action="store_true", help="by the wall's clock")
    given = vars(parser.parse_args(user_arguments(arguments)))
    out: Path = given.pop("out").absolute()
    try:
        nodes = bench_graph(BenchExperiment(**given), out)
        (out / "nodes").mkdir(exist_ok=True)
        write_parameters(out / "nodes", nodes)
    except (ValueError, OSError) as error:
        sys.stderr.write(f"bench_graph: {error}\n")
        return 2
    sys.stdout.write("".join(f"{line_of(node)}\n" for node in nodes))
    return 0


if __name__ == "__main__":
    sys.exit(main())
