# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""The stubs say what there is, everything is documented, and mypy finds what is wrong and nothing else."""

import ast
import inspect
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT, needs_maps

import pcl_ssfr
from pcl_ssfr import _core

PACKAGE = pathlib.Path(pcl_ssfr.__file__).parent


def mypy(*words):
    pytest.importorskip("mypy")
    environment = dict(os.environ, MYPYPATH=str(PACKAGE.parent))
    return subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", str(ROOT / "python" / "mypy.ini"), "--cache-dir", os.devnull,
         *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, env=environment,
    )


def test_mypy_finds_nothing_in_the_package():
    done = mypy(PACKAGE)
    assert done.returncode == 0, done.stdout


def test_mypy_sees_what_users_do_wrong(tmp_path):
    user = tmp_path / "user.py"
    user.write_text(
        """import numpy as np
import pcl_ssfr

points, viewpoint = pcl_ssfr.read_scan("a.pcd")
result = pcl_ssfr.register_scans(points, pcl_ssfr.prepare_scan(points), source_viewpoint=viewpoint, leaf=0.1)
moved = points @ result.T_target_source[:3, :3].T
good: bool = result.converged and result.status == pcl_ssfr.Status.CONVERGED
found = pcl_ssfr.map_scans(["a.pcd", points, (points, None)])
poses = {scan.name: scan.T_map_scan for scan in found.scans}
""",
        encoding="ascii",
    )
    assert mypy(user).returncode == 0, mypy(user).stdout
    wrong = [
        'pcl_ssfr.register_scans("a.pcd", points)',
        "pcl_ssfr.register_scans(points, points, threads='all')",
        "pcl_ssfr.register_scans(points, points, points)",
        "result.transform",
        "result.converged = True",
        "text: str = result.confidence",
    ]
    start = len(user.read_text(encoding="ascii").splitlines()) + 1
    with open(user, "a", encoding="ascii") as file:
        file.write("\n".join(wrong) + "\n")
    found = mypy(user).stdout
    for number, line in enumerate(wrong, start):
        assert f"user.py:{number}: error" in found, (line, found)


def stub_of(node):
    return {item.name for item in node.body if isinstance(item, ast.FunctionDef)}


def public(item):
    return {name for name in vars(item) if not name.startswith("_")}


@needs_maps
def test_the_stub_names_what_there_is():
    stub = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
    classes = {node.name: stub_of(node) for node in stub.body if isinstance(node, ast.ClassDef)}
    assert classes == {name: public(item) for name, item in vars(_core).items() if inspect.isclass(item)}
    variables = {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
    assert stub_of(stub) | set(classes) | variables == public(_core) | {"__version__"}


@needs_maps
def test_the_arguments_of_the_stub_are_those_of_the_functions():
    stub = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
    for node in stub.body:
        if isinstance(node, ast.FunctionDef):
            words = getattr(_core, node.name).__doc__.splitlines()[0]
            inside = words[words.index("(") + 1 : words.rindex(") ->")]
            depth, names = 0, []
            for part in inside.split(", "):
                if depth == 0 and part:
                    names.append(part.split(":")[0])
                depth += part.count("[") - part.count("]")
            assert names == [argument.arg for argument in node.args.args], node.name


@needs_maps
def test_types_of_properties(aligned):
    """What the stub says of each property of a result is what comes."""
    stub = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
    scan_map = pcl_ssfr.map_scans([str(ROOT / "data" / f"apartment_{i}.pcd") for i in range(2)])
    items = [aligned, *aligned.candidates, aligned.candidates[0].evidence, *aligned.stages, scan_map, *scan_map.scans]
    items += scan_map.links
    simple = {"float": float, "bool": bool, "int": int, "str": str, "Status": pcl_ssfr.Status}
    seen = set()
    for node in (node for node in stub.body if isinstance(node, ast.ClassDef)):
        for item in (item for item in items if type(item).__name__ == node.name):
            seen.add(node.name)
            for method in node.body:
                said, value = ast.unparse(method.returns), getattr(item, method.name)
                if said in simple:
                    assert type(value) is simple[said], (node.name, method.name)
                elif said.startswith("list"):
                    assert isinstance(value, list)
                elif said.startswith("npt.NDArray"):
                    assert isinstance(value, np.ndarray) and value.dtype == np.float64
    assert seen >= {"Result", "Candidate", "CandidateEvidence", "StageReport", "ScanMap", "MapScan", "MapLink"}


def test_everything_is_documented_and_exported():
    for name in pcl_ssfr.__all__:
        item = getattr(pcl_ssfr, name)
        if inspect.isclass(item) or callable(item):
            assert inspect.getdoc(item), name
            assert item.__module__ == "pcl_ssfr", name
        for part in vars(item) if inspect.isclass(item) and item.__module__ == "pcl_ssfr" else ():
            if not part.startswith("_") and isinstance(vars(item)[part], property):
                assert vars(item)[part].__doc__, f"{name}.{part}"


def test_statuses_are_those_of_the_library():
    text = (ROOT / "src" / "common" / "result.cpp").read_text(encoding="utf-8")
    named = {line.split('"')[1] for line in text.splitlines() if line.strip().startswith('return "')}
    assert named - {"unknown"} == {str(status) for status in pcl_ssfr.Status}  # no status has that one


def test_signatures():
    """What users' scripts rely on."""
    register = inspect.signature(pcl_ssfr.register_scans).parameters
    assert list(register)[:2] == ["source", "target"] and register["options"].kind is inspect.Parameter.VAR_KEYWORD
    for name in ("guess", "source_viewpoint", "target_viewpoint", "gravity", "threads"):
        assert register[name].kind is inspect.Parameter.KEYWORD_ONLY
        assert register[name].default == (0 if name == "threads" else None)
