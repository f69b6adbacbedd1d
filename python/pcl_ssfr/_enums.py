# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Enumerations and exceptions of pcl_ssfr, which the compiled part uses too."""

from __future__ import annotations

import enum


class _Word(str, enum.Enum):
    """An enumerator that is its word: ``Status.CONVERGED == "converged"``."""

    def __str__(self) -> str:
        return str(self.value)


class Status(_Word):
    """Why a registration ended as it did. Only CONVERGED means that the pose may be used."""

    NOT_RUN = "not_run"
    CONVERGED = "converged"
    INVALID_INPUT = "invalid_input"
    TOO_FEW_POINTS = "too_few_points"
    TOO_FEW_DIRECTIONS = "too_few_directions"
    NO_CANDIDATE = "no_candidate"
    AMBIGUOUS = "ambiguous"
    UNOBSERVABLE = "unobservable"
    LOW_OVERLAP = "low_overlap"
    CONTRADICTED = "contradicted"
    TIME_LIMIT = "time_limit"


class LinkStatus(_Word):
    """What became of a link of a map."""

    USED = "used"
    REJECTED = "rejected"
    AMBIGUOUS = "ambiguous"
    NONE = "none"


class FileError(ValueError, OSError):
    """A file that cannot be read or written; the text names the file, the field and the value."""
