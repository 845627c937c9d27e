"""Set points of thrust and feedback control of one thruster's speed."""
