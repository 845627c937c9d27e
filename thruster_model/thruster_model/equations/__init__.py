"""The equations, each written once, callable from Python (arrays broadcast) and from compiled code."""
