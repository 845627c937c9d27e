"""The thesis' closed-loop experiments on one thruster (section 5.1), in simulation, beside the real ones."""
