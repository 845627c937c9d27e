"""Runs: record, read and import them (MCAP in rosbag2 directories)."""

from . import missing_modules  # noqa: F401  first of all: what is missing is said in a sentence
from .errors import (
    CannotWriteError,
    ClockError,
    EmptyRunError,
    InvalidRunError,
    MissingChannelError,
    MissingTopicError,
    NotARunError,
    RecordingError,
    RunError,
    RunExistsError,
    SchemaError,
    StampOrderError,
    TooLargeError,
)
from .reader import read_run
from .run import Channel, Run
from .topic import Topic
from .writer import write_run

__all__ = [
    "CannotWriteError",
    "Channel",
    "ClockError",
    "EmptyRunError",
    "InvalidRunError",
    "MissingChannelError",
    "MissingTopicError",
    "NotARunError",
    "RecordingError",
    "Run",
    "RunError",
    "RunExistsError",
    "SchemaError",
    "StampOrderError",
    "TooLargeError",
    "Topic",
    "read_run",
    "write_run",
]
