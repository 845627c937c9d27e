"""Files and folders that are there whole or not at all: on a full disk, in a read-only folder, at an interrupt.

What is written has a hidden name beside the target until it is complete and on the disk; then it takes the target's
name in one step. At SIGINT and SIGTERM what is under way is removed and the program ends, with a sentence; at SIGKILL a
hidden `.NAME.….part` may be left, which nothing reads. A target that is there is kept, unless replacing is asked for.
"""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType

from safe_files.errors import NotWrittenError

__all__ = ["expect_new_folder", "new_folder", "whole_file", "write_whole"]


def write_whole(path: Path, content: str | bytes, *, replace: bool = False) -> Path:
    """Write a file and return its path; text as UTF-8.

    Raises:
        FileExistsError: there is something already, and `replace` is not set.
        NotWrittenError: the file system refuses.
    """
    with whole_file(path, replace=replace) as partial:
        partial.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    return path


@contextmanager
def whole_file(path: Path, *, replace: bool = False) -> Iterator[Path]:
    """Hand over the hidden name under which to write a file; it takes its own when the block ends well.

    The name ends as the target's does, for writers that go by it.

    Raises:
        FileExistsError, NotWrittenError: as `write_whole`.
    """
    _refuse(path, replace)
    partial = _hidden(path, path.suffix)
    with _removed_where_not_finished(path, partial):
        yield partial
        _to_disk(partial)
        if replace:
            os.replace(partial, path)
        else:
            _named_anew(partial, path)
        _to_disk(path.parent)


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """Hand over a hidden folder to write into; when the block ends well it takes its name, a new or an empty folder's.

    Parents are made.

    Raises:
        FileExistsError: there is something already that is no empty folder.
        NotWrittenError: the file system refuses.
    """
    expect_new_folder(path)
    given, path = path, Path(os.path.abspath(path))
    partial = _hidden(path)
    with _removed_where_not_finished(given, partial):
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.mkdir()
        yield partial
        for each in partial.rglob("*"):
            _to_disk(each)
        partial.rename(path)  # refused where the folder has been filled meanwhile
        _to_disk(path.parent)


def expect_new_folder(path: Path) -> None:
    """Refuse a place where `new_folder` would: for programs that work long before they write.

    Raises:
        FileExistsError: there is something already that is no empty folder.
        NotWrittenError: the folder that it would be in is none, or may not be written.
    """
    if os.path.lexists(path) and not (path.is_dir() and not any(path.iterdir())):
        found = "files in it" if path.is_dir() else "something there"
        raise FileExistsError(f"{path}: expected a new or empty folder; found {found}")
    above = next(each for each in Path(os.path.abspath(path)).parents if os.path.lexists(each))
    number = errno.ENOTDIR if not above.is_dir() else 0 if os.access(above, os.W_OK | os.X_OK) else errno.EACCES
    if number:
        raise NotWrittenError(path, OSError(number, os.strerror(number)))


def _hidden(path: Path, ending: str = "") -> Path:
    return path.with_name(f".{path.name}.{secrets.token_hex(6)}.part{ending}")


def _refuse(path: Path, replace: bool) -> None:
    if os.path.lexists(path) and not replace:
        raise FileExistsError(f"{path}: exists and is not overwritten")


def _named_anew(partial: Path, path: Path) -> None:
    """Give a file its name unless something has it, in one step where the file system has links."""
    try:
        os.link(partial, path)
    except FileExistsError:
        raise FileExistsError(f"{path}: exists and is not overwritten") from None
    except OSError as error:
        if error.errno not in (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS):
            raise
        _refuse(path, False)
        os.replace(partial, path)
    else:
        partial.unlink()


def _to_disk(path: Path) -> None:
    """Wait until the disk has it: what a full one refuses is told here at the latest."""
    if path.is_symlink():
        return
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno != errno.EINVAL:  # a file system that has no such thing for folders
            raise
    finally:
        os.close(number)


@contextmanager
def _removed_where_not_finished(path: Path, partial: Path) -> Iterator[None]:
    with _signals_end_the_program(path):
        try:
            yield
        except OSError as error:
            if error.errno is None or isinstance(error, NotWrittenError):  # told in a sentence of its own
                raise
            raise NotWrittenError(path, error) from error
        finally:
            if partial.is_dir():
                shutil.rmtree(partial, ignore_errors=True)
            else:
                with suppress(OSError):
                    partial.unlink(missing_ok=True)


@contextmanager
def _signals_end_the_program(path: Path) -> Iterator[None]:
    """Let SIGTERM, and SIGINT where a program ends at it without a word, leave through the block's end."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, frame: FrameType | None) -> None:
        sys.stderr.write(f"{path}: interrupted by {signal.Signals(number).name}; nothing was left there\n")
        raise SystemExit(128 + number)

    ours = [number for number in (signal.SIGTERM, signal.SIGINT) if _ends_at_once(signal.getsignal(number))]
    before = {number: signal.signal(number, end) for number in ours}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _ends_at_once(handler: object) -> bool:
    """Tell whether a signal would end the process without leaving blocks; a program's own function may."""
    return handler is signal.SIG_DFL or (callable(handler) and handler is not signal.default_int_handler)
