"""What a vehicle may do that its model does not know: one definition in one file each, switched on by name."""
