# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Global registration of LiDAR scans of structured scenes, on numpy arrays.

>>> import pcl_ssfr
>>> source, _ = pcl_ssfr.read_scan("scan2.pcd")
>>> target, _ = pcl_ssfr.read_scan("scan1.pcd")
>>> result = pcl_ssfr.register_scans(source, target)
>>> if result.converged:
...     T = result.T_target_source
...     moved = source @ T[:3, :3].T + T[:3, 3]

Lengths are in metres, angles in degrees; those of the information and covariance matrices in radians. What is wrong
with an argument is a ValueError that names it. Every function leaves the interpreter free for other threads while it
runs, and gives the same bits for any number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._core import (
    READABLE_FORMATS,
    Candidate,
    CandidateEvidence,
    PreparedScan,
    Result,
    StageReport,
    UnobservableDirection,
    __version__,
)
from ._enums import FileError, LinkStatus, Status

__all__ = [
    "READABLE_FORMATS",
    "Candidate",
    "CandidateEvidence",
    "FileError",
    "LinkStatus",
    "PreparedScan",
    "Result",
    "ScanFile",
    "StageReport",
    "Status",
    "UnobservableDirection",
    "__version__",
    "default_numbers",
    "default_options",
    "list_e57_scans",
    "map_scans",
    "number_names",
    "prepare_scan",
    "read_scan",
    "read_scan_file",
    "read_transform",
    "register_scans",
]

Points = Union[npt.NDArray[np.float32], npt.NDArray[np.float64]]
Path = Union[str, "os.PathLike[str]"]


def register_scans(
    source: Union[Points, PreparedScan],
    target: Union[Points, PreparedScan],
    *,
    guess: Optional[npt.ArrayLike] = None,
    source_viewpoint: Optional[npt.ArrayLike] = None,
    target_viewpoint: Optional[npt.ArrayLike] = None,
    gravity: Optional[npt.ArrayLike] = None,
    threads: int = 0,
    source_normals: Optional[Points] = None,
    target_normals: Optional[Points] = None,
    **options: Any,
) -> Result:
    """Find the pose of `source` in the frame of `target`.

    source, target: arrays of shape (N, 3), float32 or float64, points in metres, NaN where nothing was measured; or
        what prepare_scan() gave. Contiguous float32 is read in place. float64 is copied as float32; an offset is taken off
        large coordinates (map frames) first, and put back into the result. What a masked array masks is NaN.
    guess: rigid motion, shape (4, 4); refined and judged as one more candidate. Never needed.
    source_viewpoint, target_viewpoint: where the sensor was, shape (3,), in the coordinates of the points [m]; the
        origin when None. The option viewpoint_mode says whether that is checked against the points.
    gravity: direction up in both scans, shape (3,), or one for source and target, shape (2, 3); only poses that keep it
        within the option gravity_tolerance_deg (5) are considered.
    threads: 0: all processors. The result does not depend on it.
    source_normals, target_normals: unit normals of the points; only the profile "paper2017" reads them.

    Options, all of which have defaults that follow from the data (default_options(); docs/PARAMETERS.md):
        profile: "default", or "paper2017" for the method as published.
        viewpoint_mode: "auto": the viewpoints are checked against the points, and looked for in them where they do not
            fit; "sensor": they are right; "unknown": they are looked for; "unused": do without.
        guess_tolerance: (degrees, metres): only poses that near to the guess, which it needs, are considered.
        gravity_tolerance_deg: three standard deviations of `gravity`.
        normal_radius, density_radius, bin_width, leaf, overlap_radius: scales [m] ([chord] for the second); 0: from the
            data.
        min_confidence: accept an answer from this confidence on, 0.7.
        max_candidates: poses listed in the result, 10.
        refine: polish the answer, True. max_refinement_steps: of the polish, 30.
        time_limit: of the whole call [s]; 0: none.
        numbers: a dict of tuned numbers, for those who experiment (default_numbers()).
    Where a scan is prepared, options that are not given are those that it was prepared with.

    Data never raise: Result.status and Result.message say what happened. Raises ValueError when an argument is wrong:
    shape, dtype, an empty array or one without a finite point, an option that does not exist or is out of range, scans
    that were prepared with other options.
    """
    if gravity is not None:
        options["gravity"] = gravity
    options["threads"] = threads
    return _core.register_scans(
        source, target, guess, source_viewpoint, target_viewpoint, source_normals, target_normals, options
    )


def prepare_scan(
    points: Points,
    *,
    viewpoint: Optional[npt.ArrayLike] = None,
    normals: Optional[Points] = None,
    threads: int = 0,
    **options: Any,
) -> PreparedScan:
    """Do once what a registration does with each scan; register_scans() takes the result in place of the array.

    Arguments are those of register_scans(), and the options profile, viewpoint_mode, normal_radius, density_radius, leaf
    and numbers: the others are of a registration. It takes as long as it takes. The array is not kept. A prepared scan never changes and may be used by
    several threads. Raises ValueError as register_scans() does.
    """
    options["threads"] = threads
    return _core.prepare_scan(points, viewpoint, normals, options)


def default_options(profile: str = "default") -> dict[str, Any]:
    """The options of register_scans() with their defaults in a profile; 0 means that the data decide."""
    return _core.default_options(profile)


def default_numbers() -> dict[str, Union[int, float]]:
    """What the option `numbers` knows, with the defaults: tuned numbers of the default profile (docs/PARAMETERS.md)."""
    return _core.default_numbers()


def number_names() -> list[str]:
    """The names of default_numbers()."""
    return list(default_numbers())


class ScanFile(NamedTuple):
    """What a file of a scan holds."""

    points: Points
    """Every point in file coordinates, shape (N, 3) [m]; float64 where coordinates are large, else float32."""
    viewpoint: Optional[npt.NDArray[np.float64]]
    """Where the sensor was, shape (3,), file coordinates [m]; None when the file says the origin or nothing."""
    normals: Optional[npt.NDArray[np.float32]]
    """Normals of the points, shape (N, 3), as the file has them."""
    intensity: Optional[npt.NDArray[np.float32]]
    """Intensities of the points, shape (N,), as the file has them."""
    T_file_scan: Optional[npt.NDArray[np.float64]]
    """Where the file places the scan among others (E57): maps its points into the frame that they share, (4, 4) [m]."""


def read_scan_file(path: Path) -> ScanFile:
    """Read all that the programs use of a scan; formats: READABLE_FORMATS, see docs/FORMATS.md.

    Of an E57 file with several scans, "site.e57#2" or "site.e57#NAME" is one (list_e57_scans()).
    Raises FileError, which is a ValueError and an OSError, with the file and what is wrong with it.
    """
    return ScanFile(*_core.read_scan_fields(os.fsencode(path)))


def read_scan(path: Path) -> tuple[Points, Optional[npt.NDArray[np.float64]]]:
    """Points and viewpoint of a file, as register_scans() takes them; see ScanFile and read_scan_file()."""
    scan = read_scan_file(path)
    return scan.points, scan.viewpoint


def list_e57_scans(path: Path) -> list[str]:
    """The scans of an E57 file, each as a path that the readers take ("site.e57#2"). Raises FileError."""
    return _core.list_e57_scans(os.fsencode(path))


def read_transform(path: Path) -> npt.NDArray[np.float64]:
    """A rigid motion, shape (4, 4), from a text file of 16 numbers, row by row. Raises FileError."""
    return _core.read_transform(os.fsencode(path))


if hasattr(_core, "map_scans"):
    from ._core import LoopClosure, MapLink, MapScan, ScanMap

    __all__ += ["LoopClosure", "MapLink", "MapScan", "ScanMap"]


def _name_pairs(argument: str, pairs: object) -> list[tuple[str, str]]:
    """Pairs of names. Raises ValueError for anything else."""
    found: list[Any] = list(pairs) if isinstance(pairs, Iterable) else [pairs]
    for pair in found:
        if not isinstance(pair, (tuple, list)) or len(pair) != 2 or not all(isinstance(name, str) for name in pair):
            raise ValueError(f"{argument}: {pair!r}, must be two names of scans")
    return [(a, b) for a, b in found]


def map_scans(
    scans: Sequence[Union[Path, Points, tuple[Points, Optional[npt.ArrayLike]]]],
    *,
    names: Optional[Sequence[str]] = None,
    gravity: Optional[npt.ArrayLike] = None,
    gravity_tolerance_deg: Optional[float] = None,
    pairs: str = "auto",
    threads: int = 0,
    project: Optional[Path] = None,
    resume: bool = False,
    poses: Optional[Mapping[str, npt.ArrayLike]] = None,
    pose_tolerance: tuple[float, float] = (10.0, 1.0),
    pins: Iterable[str] = (),
    accept: Iterable[tuple[str, str]] = (),
    reject: Iterable[tuple[str, str]] = (),
    progress: Optional[Callable[[str, int, int], object]] = None,
    **options: Any,
) -> ScanMap:
    """Place many scans in one frame, in any order and without guesses (docs/MAPS.md).

    scans: files, which are read as they are needed and never all at once; or arrays of shape (N, 3); or pairs of an
        array and the viewpoint of its sensor.
    names: one for each scan, all different; None: the paths, and "scan 3" for the array at 3.
    gravity: direction up in the frame of every scan, shape (3,), right within gravity_tolerance_deg (None: 5).
    pairs: which pairs are linked: "all", "candidates" (those that are likely to share a place), or "auto": all of up to
        150 scans, candidates of more.
    project: file that every link is kept in as it is found; with resume, what it holds is used again.
    poses: what is known of poses beforehand, by name: T_map_scan, shape (4, 4), right within pose_tolerance
        (degrees, metres).
    pins: names of scans that hold the frame of their component.
    accept, reject: pairs of names whose best pose is right, or is not to be used.
    progress: called as progress(stage, done, total), from any thread. What it raises ends its calls, and is raised when
        the map is done.
    options: of each registration, as register_scans() takes them.

    A scan that cannot be read or placed is a component of its own, and MapScan.reason says why.
    Raises ValueError when an argument is wrong, fewer than two scans can be used, or accepted links do not agree;
    FileError when the project cannot be read or written; NotImplementedError where the package was built without Ceres
    and SQLite.
    """
    if progress is not None and not callable(progress):
        raise ValueError(f"progress = {progress!r}, must be callable")
    pinned = list(pins)
    if isinstance(pins, str) or not all(isinstance(name, str) for name in pinned):
        raise ValueError(f"pins = {pins!r}, must be a list of names")
    if not hasattr(_core, "map_scans"):
        raise NotImplementedError("map_scans: the package was built without Ceres and SQLite")
    inputs: list[object] = []
    given: list[str] = []
    for i, scan in enumerate(scans):
        if isinstance(scan, (str, os.PathLike)):
            inputs.append(os.fsencode(scan))
            given.append(os.fspath(scan))
        else:
            if isinstance(scan, tuple) and len(scan) != 2:
                raise ValueError(f"scan {i}: a tuple of {len(scan)}, must be points and viewpoint")
            inputs.append(scan if isinstance(scan, tuple) else (scan, None))
            given.append(f"scan {i}")
    if names is not None:
        given = [str(name) for name in names]
        if len(given) != len(inputs):
            raise ValueError(f"names: {len(given)} for {len(inputs)} scans")
    options["threads"] = threads
    return _core.map_scans(
        given,
        inputs,
        gravity,
        None if gravity_tolerance_deg is None else float(gravity_tolerance_deg),
        pairs,
        b"" if project is None else os.fsencode(project),
        resume,
        dict(poses or {}),
        (float(pose_tolerance[0]), float(pose_tolerance[1])),
        pinned,
        _name_pairs("accept", accept),
        _name_pairs("reject", reject),
        progress,
        options,
    )


for _name in __all__:
    _item = globals()[_name]
    if getattr(_item, "__module__", "").startswith(__name__ + "."):
        _item.__module__ = __name__
del _name, _item
