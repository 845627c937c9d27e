"""The errors of this package."""


class ThrusterRuntimeError(Exception):
    """Base of all errors of this package."""


class StartRefused(ThrusterRuntimeError):
    """A node that will not start, with the reason as one sentence; its process ends with status 2."""
