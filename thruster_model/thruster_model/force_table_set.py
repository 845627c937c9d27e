"""A parameter set of the model `force_table` from a maker's table."""

from thruster_model.command_scale import CommandScale
from thruster_model.force_curves import ForceCurves, scale_of
from thruster_model.force_table import ForceTable
from thruster_model.force_table_quality import falls, monotone
from thruster_model.parameter_set import Parameter, ParameterSet

__all__ = ["ASSUMED_LAG", "parameter_set_of"]

ASSUMED_LAG = 0.1
"""[s]: no bollard-pull sheet tells how fast a thruster follows."""
_SHARE, _ASSUMED_SHARE = 0.05, 0.5


def parameter_set_of(
    table: ForceTable,
    *,
    nominal_supply: float | None = None,
    lag: float | None = None,
    scale: CommandScale | None = None,
) -> ParameterSet:
    """Return the set of a table, made monotone where its force or speed falls.

    Args:
        table: over command and supply.
        nominal_supply: what counts as relative supply 1 [V]; None: the middle one of those measured.
        lag: time constant of the rotor [s]; None: `ASSUMED_LAG`.
        scale: how commands are written; None: the table's furthest command is the full throttle.

    Raises:
        ForceTableError, ParameterSetError: the table or the numbers give no set.
    """
    chosen = scale or scale_of(table)
    rising = monotone(table) if falls(table) else table
    curves = ForceCurves(table=rising, scale=chosen)
    middle = float(table.supply[table.supply.size // 2])
    rate = 1.0 / (lag or ASSUMED_LAG)
    said = "given" if lag is not None else "assumed: the table has no time; fit it, or give it"
    given = {
        "command_scale": (1.0, "1", "the table", _SHARE),
        "delta_u1": (curves.edges[0], "V", "last command without force or speed at any supply", None),
        "delta_u2": (curves.edges[1], "V", "last command without force or speed at any supply", None),
        "rate": (rate, "1/s", said, None if lag is not None else _ASSUMED_SHARE * rate),
        "thrust_scale": (1.0, "1", "the table", _SHARE),
        "nominal_supply": (nominal_supply or middle, "V", "given" if nominal_supply else "the table's middle", None),
    }
    parameters = {
        name: Parameter(value=value, unit=unit, source=source, standard_deviation=deviation)
        for name, (value, unit, source, deviation) in given.items()
    }
    return ParameterSet(
        name=table.name,
        model_name="force_table",
        source=table.source,
        parameters=parameters,
        command=chosen,
        force_table=rising,
    )
