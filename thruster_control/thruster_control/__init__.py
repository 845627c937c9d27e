"""Set points of thrust, inner control loops of one thruster and their scores."""
