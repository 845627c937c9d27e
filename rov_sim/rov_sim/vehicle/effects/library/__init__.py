"""The effects of a vehicle, one file each; a file here is found by itself."""
