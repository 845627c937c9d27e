"""What every node needs once: executor switch, clean stop, QoS profiles, diagnostics, joins."""
