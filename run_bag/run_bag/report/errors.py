"""What goes wrong when a report is built."""


class ReportError(ValueError):
    """Base class of all errors of this package."""


class ReportExists(ReportError, FileExistsError):
    """Refuse to overwrite a report that is already there."""


class BrowserMissing(ReportError):
    """Say which program is needed to look at a report in a browser."""
