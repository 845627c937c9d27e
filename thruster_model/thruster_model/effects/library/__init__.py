"""One file for each effect of the thruster; a new file is found by itself."""
