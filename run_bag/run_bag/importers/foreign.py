"""Files that are no table of text: what they are, and how they become one."""

from __future__ import annotations

from pathlib import Path

__all__ = ["told_of_others"]

_READ = "read are tables of text (csv), rosbag2, MCAP and ROS 1 bags, and ArduPilot's .BIN and .tlog"
_SHEET = "a spreadsheet's program saves it as CSV, and pandas' `read_excel` and `to_csv` make one"
_NET = "`scipy.io.netcdf_file`, or `xarray.open_dataset` and `to_dataframe`, then pandas' `to_csv` make one"
_JSON = "pandas' `read_json`, with `lines=True` for an object in each line, and `to_csv` make one"
_FMT = "give the .BIN that it was made of, or a CSV of each of its messages, such as RCOU.csv"
_KINDS = (
    (b"MATLAB", "a MATLAB file", "in MATLAB `writetable`, in Python `scipy.io.loadmat` and pandas' `to_csv` make one"),
    (b"\x89HDF", "an HDF5 file (or a MATLAB file of version 7.3)", "in MATLAB `writetable`, in Python `h5py` make one"),
    (b"PK\x03\x04", "a packed file, such as a spreadsheet or npz", _SHEET),
    (b"\xd0\xcf\x11\xe0", "a spreadsheet", _SHEET),
    (b"PAR1", "a Parquet file", "`pandas.read_parquet` and `to_csv` make one"),
    (b"\x93NUMPY", "an array of NumPy", "`numpy.savetxt` makes one"),
    (b"ULog", "a log of PX4", "`ulog2csv` of pyulog makes one"),
    *((b"CDF" + version, "a netCDF file", _NET) for version in (b"\x01", b"\x02", b"\x05")),
    *((first, "JSON", _JSON) for first in (b'{"', b"{\n", b"{ ", b"{\r", b"[{", b"[\n", b"[ {", b"[[")),
    (b"FMT,", "ArduPilot's log as text", _FMT),
    (b"\xff\xfe", "text in UTF-16", "an editor saves it as UTF-8"),
    (b"\xfe\xff", "text in UTF-16", "an editor saves it as UTF-8"),
    (b"\x1f\x8b", "a file packed by gzip", "unpack it first"),
    (b"\xfd7zXZ", "a file packed by xz", "unpack it first"),
    (b"BZh", "a file packed by bzip2", "unpack it first"),
)
"""How files begin, what they are, and what makes a table of text of one."""
_MATLAB = _KINDS[0]


def told_of_others(path: Path, data: bytes) -> str:
    """Return in a sentence what a file is and what to do about it, "" where it may be a table of text."""
    known = [each for each in _KINDS if data.startswith(each[0])]
    if path.suffix.lower() == ".mat":  # version 4 has no word of its own at the beginning
        known += [_MATLAB]
    if not known:
        return ""
    _, what, how = known[0]
    return f"expected a table of text, found {what}: bring it to csv first ({how}); {_READ}"
