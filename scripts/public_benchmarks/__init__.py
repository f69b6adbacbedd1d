# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Public data sets as dataset folders of ssfr_benchmark: one module per layout; docs/PUBLIC_BENCHMARKS.md."""
