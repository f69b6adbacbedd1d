# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""python3 -m pcl_ssfr SOURCE TARGET: align two files. ssfr_align has more options and draws pictures."""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import sys
import time
from typing import Any, Optional

import numpy as np

import pcl_ssfr

ALIGNED, NOT_ALIGNED, USAGE, FILES = range(4)  # exit codes


def parser() -> argparse.ArgumentParser:
    words = argparse.ArgumentParser(
        prog="python3 -m pcl_ssfr",
        description="Find where the scan SOURCE lies in the frame of the scan TARGET.",
        epilog="Exit code: 0 aligned; 1 ran, but no pose is certain enough; 2 the command line is wrong; 3 a file "
        f"cannot be read or written. Formats: {' '.join(pcl_ssfr.READABLE_FORMATS)}",
        allow_abbrev=False,
    )
    words.add_argument("source", metavar="SOURCE")
    words.add_argument("target", metavar="TARGET")
    words.add_argument("--json", metavar="FILE", help="write what was found as JSON, as ssfr_align does; -: to stdout")
    words.add_argument("--transform", metavar="FILE", help="write T_target_source as 4x4 text; -: to stdout")
    words.add_argument("--guess", metavar="FILE", help="4x4 text: a pose to judge as one more candidate")
    words.add_argument("--profile", choices=("default", "paper2017"), default="default")
    words.add_argument("--viewpoint", choices=("auto", "sensor", "unknown", "unused"), default="auto")
    words.add_argument("--gravity", metavar="X,Y,Z", help="up direction in both scans")
    words.add_argument("--leaf", metavar="M", type=float, help="spacing that the scans are thinned to")
    words.add_argument("--min-confidence", metavar="P", type=float, help="accept a pose from this confidence on")
    words.add_argument("--time-limit", metavar="S", type=float, help="stop after so many seconds")
    words.add_argument("--threads", metavar="N", type=int, default=0, help="processors to use, 0: all")
    words.add_argument("--version", action="version", version=f"pcl_ssfr {pcl_ssfr.__version__}")
    return words


def joined(words: list[str]) -> list[str]:
    """The words with each direction part of its option: argparse takes -0.1,0,1 for an option of its own."""
    result: list[str] = []
    for word in words:
        if result and result[-1] == "--gravity" and re.match(r"-[.\d]", word):
            result[-1] += "=" + word
        else:
            result.append(word)
    return result


def options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options that were given. Raises ValueError."""
    options: dict[str, Any] = {
        "profile": arguments.profile,
        "viewpoint_mode": arguments.viewpoint,
        "threads": arguments.threads,
    }
    for name in ("leaf", "min_confidence", "time_limit"):
        if getattr(arguments, name) is not None:
            options[name] = getattr(arguments, name)
    if arguments.gravity is not None:
        try:
            options["gravity"] = [float(number) for number in arguments.gravity.split(",")]
        except ValueError:
            raise ValueError(f"--gravity: {arguments.gravity!r} is not x,y,z") from None
    return options


def without_points(path: str, scan: pcl_ssfr.ScanFile) -> Optional[str]:
    """What to say of a scan that has nothing to register."""
    if np.isfinite(scan.points).all(axis=1).any():
        return None
    return f"{path}: none of its {len(scan.points)} points is finite"


def place(viewpoint: Optional[np.ndarray[Any, Any]]) -> Optional[list[float]]:
    return None if viewpoint is None else viewpoint.tolist()


def as_json(result: pcl_ssfr.Result, arguments: argparse.Namespace, seconds: float) -> str:
    """With the keys of ssfr_align."""
    judged = arguments.profile != "paper2017"
    found = {
        "method": "ssfr" if judged else "ssfr_paper2017",
        "status": str(result.status),
        "converged": result.converged,
        "message": result.message,
        "T_target_source": result.T_target_source.tolist(),
        "overlap": result.overlap,
        "confidence": result.confidence if judged else None,
        "contradiction": result.contradiction if judged else None,
        "rmse_m": result.rmse,
        "correspondence_distance_m": result.correspondence_distance if judged else None,
        "time_s": seconds,
        "peak_rss_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,  # Linux counts in KiB
        "probability_of_none": result.probability_of_none if judged else None,
        "candidates": [
            {
                "T_target_source": candidate.T_target_source.tolist(),
                "probability": candidate.probability,
                "score": candidate.score,
                "overlap": candidate.overlap,
                "contradiction": candidate.contradiction,
                "rmse_m": candidate.rmse,
                "from_guess": candidate.from_guess,
            }
            for candidate in result.candidates
        ],
        "unobservable": [
            {
                "kind": "rotation" if open_one.rotation else "translation",
                "direction": open_one.direction.tolist(),
                "strength": open_one.strength,
            }
            for open_one in result.unobservable
        ],
        "information": result.information.tolist(),
        "source_viewpoint_used": result.source_viewpoint is not None,
        "target_viewpoint_used": result.target_viewpoint is not None,
        "source_viewpoint_found": result.source_viewpoint_found,
        "target_viewpoint_found": result.target_viewpoint_found,
        "source_viewpoint_m": place(result.source_viewpoint),
        "target_viewpoint_m": place(result.target_viewpoint),
        "stages": [
            {"name": stage.name, "seconds": stage.seconds, "in": stage.count_in, "out": stage.count_out}
            for stage in result.stages
        ],
        "source": arguments.source,
        "target": arguments.target,
        "version": pcl_ssfr.__version__,
    }
    return as_lines(found)


def nothing_as_json(message: str, arguments: argparse.Namespace) -> str:
    return as_lines(
        {
            "method": "ssfr" if arguments.profile != "paper2017" else "ssfr_paper2017",
            "status": str(pcl_ssfr.Status.TOO_FEW_POINTS),
            "converged": False,
            "message": message,
            "source": arguments.source,
            "target": arguments.target,
            "version": pcl_ssfr.__version__,
        }
    )


def as_lines(found: dict[str, Any]) -> str:
    return json.dumps(found, indent=2) + "\n"


def as_text(result: pcl_ssfr.Result, arguments: argparse.Namespace, seconds: float) -> str:
    if result.converged:
        lines = [f"Aligned {arguments.source} onto {arguments.target}"]
    else:
        lines = [f"Not aligned, {result.status}: {result.message}"]
    if result.candidates:
        if not result.converged:
            lines.append("Best pose that was considered, not to be used unchecked:")
        lines.append("  T_target_source (a point of TARGET is T times a point of SOURCE)")
        lines += ["    " + " ".join(f"{number:14.9f}" for number in row) for row in result.T_target_source]
        lines.append(f"  confidence {result.confidence:.2f}, overlap {100 * result.overlap:.0f} %, {seconds:.2f} s")
    return "\n".join(lines) + "\n"


def write(path: str, text: str) -> None:
    if path == "-":
        sys.stdout.write(text)
        return
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise pcl_ssfr.FileError(f"{path}: cannot be written: {error.strerror}") from error


def say(text: str, as_json_text: str, arguments: argparse.Namespace) -> None:
    """What was found, as JSON or for people; where standard output is of the pose, they get no more than a refusal."""
    if arguments.json is not None:
        write(arguments.json, as_json_text)
    elif arguments.transform != "-":
        sys.stdout.write(text)
    elif text.startswith("Not aligned"):
        print(f"pcl_ssfr: {text.splitlines()[0]}", file=sys.stderr)


def run(words: Optional[list[str]] = None) -> int:
    """Align as the command line says; the exit code. Raises ValueError, FileError for files."""
    arguments = parser().parse_args(joined(sys.argv[1:] if words is None else words))
    if arguments.json == arguments.transform == "-":
        raise ValueError("--json: '-' is also --transform")
    options = options_of(arguments)
    guess = None if arguments.guess is None else pcl_ssfr.read_transform(arguments.guess)
    source, target = (pcl_ssfr.read_scan_file(path) for path in (arguments.source, arguments.target))
    message = without_points(arguments.source, source) or without_points(arguments.target, target)
    if message is not None:
        found = f"Not aligned, {pcl_ssfr.Status.TOO_FEW_POINTS}: {message}\n"
        say(found, nothing_as_json(message, arguments), arguments)
        return NOT_ALIGNED
    start = time.perf_counter()
    result = pcl_ssfr.register_scans(
        source.points,
        target.points,
        guess=guess,
        source_viewpoint=source.viewpoint,
        target_viewpoint=target.viewpoint,
        source_normals=source.normals,
        target_normals=target.normals,
        **options,
    )
    seconds = time.perf_counter() - start
    if arguments.transform is not None and result.converged:
        rows = [" ".join(repr(float(number)) for number in row) for row in result.T_target_source]
        write(arguments.transform, "\n".join(rows) + "\n")
    say(as_text(result, arguments, seconds), as_json(result, arguments, seconds), arguments)
    return ALIGNED if result.converged else NOT_ALIGNED


def main() -> int:
    try:
        code = run()
        sys.stdout.flush()
        return code
    except ValueError as error:
        print(f"pcl_ssfr: {error}", file=sys.stderr)
        return FILES if isinstance(error, pcl_ssfr.FileError) else USAGE
    except (MemoryError, OSError) as error:  # a scan too large, a pipe that is closed
        print(f"pcl_ssfr: {str(error) or 'out of memory'}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left for standard output goes nowhere
        return FILES


if __name__ == "__main__":
    sys.exit(main())
