"""The folder of a blind check: sealed keys, published hashes, cases with their runs, diagnoses.

hashes.txt                    SHA-256 of each seal, complete before any diagnosis starts
sealed/<case>.json, .npz      what is hidden; noise-free channels
cases/<case>/model.yaml       the parameter set that the simulator uses
cases/<case>/library.json     effects that are taken out of the diagnosis' library
cases/<case>/runs/<name>/     the recordings
cases/<case>/predictions.npz  predicted channels, if the diagnosis gives them
cases/<case>/failed.txt       why the diagnosis broke off, if it did
cases/<case>/diagnosis.json   written last: a case that has it is finished
"""

import hashlib
import io
import json
import secrets
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.blind_check.cases import MODELS, Case, Plan, draw, recordings
from gap_diagnosis.blind_check.generator import GeneratedRun
from gap_diagnosis.blind_check.sealing import BrokenSealError, Seal, seal, unseal
from run_bag import Topic, write_run
from safe_files.whole_files_io import write_whole
from thruster_model.parameter_set_io import dump_parameter_set, load_parameter_set

__all__ = ["Store", "nominal_parameters", "write_case", "write_generated_run"]

Array = NDArray[np.float64]

_SIGN_MEASURED = 1  # thruster_msgs/msg/ThrusterState.SIGN_MEASURED


def nominal_parameters() -> dict[str, dict[str, float]]:
    """Return the parameters of the sets that the simulator uses, by model and name."""
    return {model: dict(load_parameter_set(model).values) for model in MODELS}


def write_generated_run(run: GeneratedRun, folder: Path, channels: Sequence[str]) -> Path:
    """Write the recording to the new directory `folder`/<name>, the throttle and these channels; return that."""
    throttle, n = run.recorded["throttle"], run.recorded["n"]
    topics = [Topic.of_thruster(0, "throttle", throttle.time, {"commanded": throttle.values})]
    sign = np.full(n.values.size, _SIGN_MEASURED)
    topics.append(Topic.of_thruster(0, "state", n.time, {"n": n.values, "sign_source": sign}))
    if "ambient" in channels:
        flow = run.recorded["ambient"]
        topics.append(Topic.of_thruster(0, "flow", flow.time, {"ambient": flow.values}))
    loads = {"thrust": "wrench.force.x", "torque": "wrench.torque.x"}
    fields = {path: run.recorded[name].values for name, path in loads.items() if name in channels}
    if fields:
        topics.append(Topic.of_thruster(0, "load", run.recorded["thrust"].time, fields))
    return write_run(folder / run.name, topics, {"run": run.name})


def write_case(folder: Path, case: Case, runs: Sequence[GeneratedRun]) -> list[Path]:
    """Write what the diagnosis may see to a case's folder; return the paths of the runs."""
    folder.mkdir(parents=True, exist_ok=True)
    _keep(folder / "model.yaml", dump_parameter_set(load_parameter_set(case.model)).encode())
    _keep(folder / "library.json", json.dumps(list(case.excluded)).encode())
    shutil.rmtree(folder / "runs", ignore_errors=True)
    return [write_generated_run(run, folder / "runs", case.channels) for run in runs]


class Store:
    """The folder of one check."""

    def __init__(self, folder: Path, seed: int) -> None:
        """Open the folder of the check with this seed."""
        self.folder, self.seed = folder, seed
        self._nominal = nominal_parameters()

    def case_folder(self, name: str) -> Path:
        """Return the folder of a case."""
        return self.folder / "cases" / name

    def publish(self, plans: Sequence[Plan], progress: Callable[[Plan], None] = lambda _: None) -> dict[str, str]:
        """Seal the cases that are not yet, write hashes.txt; return the hash of each seal by case.

        Raises:
            BrokenSealError: a seal that is there does not have its published hash.
            ValueError: the folder holds a check of another seed, or other cases under the same names.
        """
        published = self.hashes()
        for each in plans:
            if each.name in published:
                key = unseal(each.name, self._read_seal(each.name), published[each.name])
                self.check_key(each, key, self.folder)
            else:
                published[each.name] = self._seal(each).hash
            progress(each)
        lines = "".join(f"{value}  {name}\n" for name, value in sorted(published.items()))
        _keep(self.folder / "hashes.txt", lines.encode())
        return published

    def hashes(self) -> dict[str, str]:
        """Return the published hashes by case."""
        file = self.folder / "hashes.txt"
        lines = file.read_text("utf-8").splitlines() if file.exists() else []
        return {name: value for value, name in (line.split() for line in lines)}

    def finished(self, name: str) -> bool:
        """Return whether the case has its diagnosis."""
        return (self.case_folder(name) / "diagnosis.json").is_file()

    def failed(self, name: str) -> bool:
        """Return whether the last diagnosis of the case broke off."""
        return (self.case_folder(name) / "failed.txt").is_file() and not self.finished(name)

    def prepare(self, plan: Plan) -> tuple[list[Path], Path, tuple[str, ...]]:
        """Write the runs of a case; return them, the simulator's parameter set and the effects that are taken out.

        Raises:
            BrokenSealError: nothing is diagnosed whose hash has not been published, or that the generator, changed
                since, would no longer record as it was sealed.
        """
        key = self.key(plan.name)
        case = draw(plan, self.seed, self._nominal)
        runs = recordings(case, self._nominal)
        if key["recordings"] != _fingerprint(runs):
            raise BrokenSealError(plan.name, key["recordings"], _fingerprint(runs))
        folder = self.case_folder(plan.name)
        return write_case(folder, case, runs), folder / "model.yaml", case.excluded

    def keep(self, name: str, diagnosis: Mapping[str, Any], *, keep_runs: bool = False) -> None:
        """Save the diagnosis of a case, which is finished then, and remove its runs unless they are to stay."""
        folder, found = self.case_folder(name), dict(diagnosis)
        arrays = {
            f"{kind}/{run}/{channel}": np.asarray(values, dtype=np.float32)
            for kind, by_run in found.pop("predictions", {}).items()
            for run, channels in by_run.items()
            for channel, values in channels.items()
        }
        if not keep_runs:
            shutil.rmtree(folder / "runs")
        _keep(folder / "predictions.npz", _compressed(arrays))
        _keep(folder / "diagnosis.json", json.dumps(found, indent=1).encode())
        (folder / "failed.txt").unlink(missing_ok=True)

    def note_failure(self, name: str, reason: str) -> None:
        """Save why the diagnosis of a case broke off."""
        _keep(self.case_folder(name) / "failed.txt", f"{reason}\n".encode())

    def key(self, name: str) -> dict[str, Any]:
        """Open the seal of a case.

        Raises:
            BrokenSealError: the seal does not have its published hash.
        """
        return unseal(name, self._read_seal(name), self.hashes().get(name))

    def check_key(self, plan: Plan, key: Mapping[str, Any], where: Path) -> None:
        """Check that a key, or the part of it that is found in `where`, is that of a planned case of this seed.

        Raises:
            ValueError: it is not.
        """
        expected = draw(plan, self.seed, self._nominal).described()
        if any(value != key[name] for name, value in json.loads(json.dumps(expected)).items() if name in key):
            raise ValueError(f"{where}: {plan.name} was sealed for another seed or another choice of cases")

    def opened(self, name: str) -> tuple[dict[str, Any], dict[str, Any], dict[str, dict[str, Array]]]:
        """Open the seal of a finished case: (key, diagnosis, clean channels by run).

        Raises:
            BrokenSealError: the seal does not have its published hash.
        """
        key, sealed = self.key(name), self._read_seal(name)
        found = json.loads((self.case_folder(name) / "diagnosis.json").read_text("utf-8"))
        clean: dict[str, dict[str, Array]] = {}
        with np.load(io.BytesIO(sealed.channels)) as file:
            for entry in file.files:
                run, channel = entry.split("/")
                clean.setdefault(run, {})[channel] = file[entry]
        with np.load(self.case_folder(name) / "predictions.npz") as file:
            for entry in file.files:
                kind, run, channel = entry.split("/")
                predicted = found.setdefault("predictions", {}).setdefault(kind, {})
                predicted.setdefault(run, {})[channel] = file[entry]
        return key, found, clean

    def _seal(self, plan: Plan) -> Seal:
        case = draw(plan, self.seed, self._nominal)
        runs = recordings(case, self._nominal)
        arrays = {f"{r.name}/{c}": values.astype(np.float32) for r in runs for c, values in r.clean.items()}
        key = {**case.described(), "recordings": _fingerprint(runs)}
        sealed = seal(key, _compressed(arrays), secrets.token_hex(32))
        _keep(self.folder / "sealed" / f"{plan.name}.npz", sealed.channels)
        _keep(self.folder / "sealed" / f"{plan.name}.json", sealed.key)
        return sealed

    def _read_seal(self, name: str) -> Seal:
        folder = self.folder / "sealed"
        parts = [folder / f"{name}{end}" for end in (".json", ".npz")]
        missing = [str(part) for part in parts if not part.is_file()]
        if missing:
            raise BrokenSealError(name, self.hashes().get(name), f"no file {', '.join(missing)}")
        return Seal(parts[0].read_bytes(), parts[1].read_bytes())


def _fingerprint(runs: Sequence[GeneratedRun]) -> str:
    digest = hashlib.sha256()
    for run in runs:
        for name, samples in run.recorded.items():
            digest.update(f"{run.name}/{name}".encode())
            digest.update(np.round(samples.time, 9).tobytes())
            digest.update(np.round(samples.values, 9).tobytes())
    return digest.hexdigest()


def _compressed(arrays: Mapping[str, NDArray[np.floating]]) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


def _keep(file: Path, content: bytes) -> None:
    """Write a file in place of an earlier one; its folder is made where there is none."""
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, content, replace=True)
