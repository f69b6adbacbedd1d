# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""`pip install .`: the Python package, by CMake (docs/PYTHON.md).

There is no pyproject.toml on purpose: with one, pip would fetch what the build needs from the network, though the system
has it (python3-skbuild, pybind11-dev). Options of CMake: the environment variable CMAKE_ARGS.
"""

import pathlib
import re

from skbuild import setup

root = pathlib.Path(__file__).resolve().parent
version = re.search(r"^project\(pcl_ssfr VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text(), re.MULTILINE)
off = ("APPS", "BASELINES", "BENCHMARKS", "EXAMPLES", "SIMULATOR", "TESTS")

setup(
    name="pcl_ssfr",
    version=version.group(1),
    description="Global registration of LiDAR scans of structured scenes",
    license="BSD-3-Clause",
    python_requires=">=3.8",
    install_requires=["numpy"],
    packages=["pcl_ssfr"],
    package_dir={"": "python"},
    package_data={"pcl_ssfr": ["py.typed", "*.pyi"]},
    include_package_data=False,
    cmake_args=["-DCMAKE_BUILD_TYPE=Release", "-DPCL_SSFR_BUILD_PYTHON=ON", "-DPCL_SSFR_PYTHON_INSTALL_DIR=."]
    + [f"-DPCL_SSFR_BUILD_{part}=OFF" for part in off],
    cmake_install_dir="python/pcl_ssfr",
    cmake_install_target="pcl_ssfr_python_install",
    zip_safe=False,
)
