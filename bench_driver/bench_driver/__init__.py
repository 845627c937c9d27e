"""Driver of the thruster bench: the rig's text protocol, without any I/O."""
