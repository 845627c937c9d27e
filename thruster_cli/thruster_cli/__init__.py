"""The command `thruster`: recordings, sets, fits and diagnoses under one name."""

from run_bag.missing_modules import tell_missing

tell_missing()  # before typer is asked for
