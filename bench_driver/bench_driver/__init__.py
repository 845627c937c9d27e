"""Driver of the thruster bench: protocols, link, serial port, emulated device."""
