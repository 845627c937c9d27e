"""The load cell: geometry, calibration, structural resonance, and thrust out of its ringing."""
