# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Arrays in and out: what memory is read how, what is refused, and that nothing is copied without need."""

import resource
import threading
import time

import numpy as np
import pytest

import pcl_ssfr


def pose(result):
    return result.T_target_source.tobytes()


def layouts(points):
    """The same points in other memory: each must give the same bits."""
    wide = np.zeros((len(points), 5), np.float32)
    wide[:, 1:4] = points
    odd = np.zeros(points.nbytes + 1, np.uint8)[1:].view(np.uint8)
    unaligned = np.frombuffer(odd, np.uint8)[: points.nbytes].view(np.float32).reshape(points.shape)
    unaligned[:] = points
    record = np.zeros(len(points), [("xyz", np.float32, 3), ("i", np.uint8)])
    record["xyz"] = points
    read_only = points.copy()
    read_only.flags.writeable = False
    return {
        "float64": points.astype(np.float64),
        "columns of a wider array": wide[:, 1:4],
        "Fortran order": np.asfortranarray(points),
        "reversed twice": points[::-1].copy()[::-1],
        "unaligned": unaligned,
        "field of records": record["xyz"],
        "read only": read_only,
        "subclass": points.view(np.recarray),
        "list": points.tolist(),
    }


def test_every_layout_gives_the_same_bits(apartment):
    source, target = (np.ascontiguousarray(points[::20]) for points in apartment)
    expected = pose(pcl_ssfr.register_scans(source, target))
    for name, array in layouts(source).items():
        before = None if isinstance(array, list) else array.copy()
        assert pose(pcl_ssfr.register_scans(array, target)) == expected, name
        assert before is None or np.array_equal(array, before), name


def test_order_of_rows_and_not_finite_points(apartment):
    source, target = (np.ascontiguousarray(points[::20]) for points in apartment)
    expected = pose(pcl_ssfr.register_scans(source, target))
    holes = np.full((2 * len(source), 3), np.nan, np.float32)
    holes[::2] = source
    holes[1::4] = np.inf
    assert pose(pcl_ssfr.register_scans(holes, target)) == expected


def test_results_are_arrays_of_their_own(aligned):
    T = aligned.T_target_source
    assert (T.shape, T.dtype, T.flags.c_contiguous) == ((4, 4), np.float64, True)
    assert T[3].tolist() == [0, 0, 0, 1]
    assert np.abs(T[:3, :3].T @ T[:3, :3] - np.eye(3)).max() < 1e-12
    T[:] = 0
    assert aligned.T_target_source[3, 3] == 1
    information = aligned.information
    assert (information.shape, information.dtype) == ((6, 6), np.float64)
    assert np.allclose(information, information.T) and np.linalg.eigvalsh(information)[0] > 0


def test_fields_of_a_result(aligned):
    assert aligned.converged and aligned.status == "converged" and aligned.status is pcl_ssfr.Status.CONVERGED
    assert str(aligned.status) == "converged" and isinstance(aligned.message, str)
    assert 0.7 <= aligned.confidence <= 1 and 0 < aligned.overlap <= 1 and aligned.rmse > 0
    first = aligned.candidates[0]
    assert first.T_target_source.tolist() == aligned.T_target_source.tolist()
    assert first.probability == aligned.confidence and first.evidence.patches > 0 and not first.from_guess
    assert abs(sum(c.probability for c in aligned.candidates) + aligned.probability_of_none - 1) < 1e-9
    assert aligned.unobservable == [] and aligned.stages[0].name == "source thinning"
    assert aligned.source_viewpoint.tolist() == [0, 0, 0] and not aligned.source_viewpoint_found
    assert "converged" in repr(aligned)


def test_the_pose_maps_source_onto_target(apartment, aligned):
    source, target = apartment
    T = aligned.T_target_source
    moved = source[::50] @ T[:3, :3].T + T[:3, 3]
    near = sum(np.abs(target - point).sum(axis=1).min() < 0.1 for point in moved[::10])
    assert near > 0.8 * len(moved[::10])


def test_float32_is_read_in_place():
    """An array of 120 MB: a copy would show in the peak of the memory."""
    count = 10_000_000
    points = np.zeros((count, 3), np.float32)
    points[:] = np.nan
    points[:100] = np.random.default_rng(1).uniform(-3, 3, (100, 3))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    result = pcl_ssfr.register_scans(points, points[:200], viewpoint_mode="unused")
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    assert grown < points.nbytes / 4, f"{grown / 1e6:.0f} MB for an array of {points.nbytes / 1e6:.0f} MB"
    assert result.status in tuple(pcl_ssfr.Status)


WRONG_POINTS = {
    "shape": (np.zeros((5, 2), np.float32), r"shape \(5, 2\), must be of shape \(N, 3\)"),
    "flat": (np.zeros(6, np.float32), r"shape \(6,\), must be of shape \(N, 3\)"),
    "cube": (np.zeros((2, 3, 3)), r"shape \(2, 3, 3\)"),
    "integers": (np.zeros((5, 3), int), "dtype int64"),
    "half": (np.zeros((5, 3), np.float16), "dtype float16"),
    "other byte order": (np.zeros((5, 3), ">f4"), "dtype >f4"),
    "objects": (np.array([[None, 1, 2]]), "dtype object"),
    "empty": (np.zeros((0, 3), np.float32), "has no points"),
    "not finite": (np.full((5, 3), np.nan), "none of its 5 points is finite"),
    "infinite": (np.full((5, 3), np.inf, np.float32), "none of its 5 points is finite"),
    "half finite": (np.array([[1.0, np.nan, 1.0]]), "none of its 1 points is finite"),
    "None": (None, "must be of float32 or float64"),
    "text": ("scan.pcd", "must be of float32 or float64"),
    "ragged": ([[1.0, 2.0, 3.0], [1.0]], "source|target|points"),
}


@pytest.mark.parametrize("case", WRONG_POINTS)
def test_wrong_points(apartment, case):
    array, text = WRONG_POINTS[case]
    with pytest.raises(ValueError, match=f"^source: .*({text})" if case != "ragged" else "^source: "):
        pcl_ssfr.register_scans(array, apartment[1])
    with pytest.raises(ValueError, match=f"^target: .*({text})" if case != "ragged" else "^target: "):
        pcl_ssfr.register_scans(apartment[0], array)
    with pytest.raises(ValueError, match="^points: "):
        pcl_ssfr.prepare_scan(array)


WRONG_OPTIONS = [
    ({"leaf": -1}, "leaf = -1, must be 0 or positive, and finite"),
    ({"leaf": "wide"}, "leaf = 'wide', must be a number"),
    ({"leaf": None}, "leaf = None, must be a number"),
    ({"leef": 1}, "leef is no option"),
    ({"unknown": None}, "unknown is no option"),
    ({"min_confidence": 2}, "min_confidence = 2, must be in [0, 1]"),
    ({"max_candidates": 0}, "max_candidates = 0, must be at least 1"),
    ({"max_candidates": 1.5}, "max_candidates = 1.5, must be a whole number"),
    ({"max_candidates": 10**20}, "must be a whole number"),
    ({"refine": 1}, "refine = 1, must be True or False"),
    ({"threads": -1}, "threads = -1, must be 0 (all) or more"),
    ({"threads": 5000}, "threads = 5000"),
    ({"time_limit": float("nan")}, "time_limit = nan"),
    ({"profile": "best"}, "profile = 'best', must be one of 'default', 'paper2017'"),
    ({"viewpoint_mode": 3}, "viewpoint_mode = 3, must be one of 'auto', 'sensor', 'unknown', 'unused'"),
    ({"gravity": [0, 0, 0]}, "gravity = [0, 0, 0], must be a direction"),
    ({"gravity": [[0, 0, 1], [0, 1]]}, "gravity = [0, 1], must be three finite numbers"),
    ({"gravity": {"a": 1, "b": 2}}, "gravity = {'a': 1, 'b': 2}, must be a direction"),
    ({"gravity": "up"}, "gravity = u, must be three finite numbers"),
    ({"gravity_tolerance_deg": 3}, "gravity_tolerance_deg needs gravity"),
    ({"gravity": [0, 0, 1], "gravity_tolerance_deg": 200}, "gravity.tolerance = "),
    ({"guess_tolerance": 3}, "guess_tolerance = 3, must be a pair of degrees and metres"),
    ({"guess_tolerance": (3, 1)}, "guess_tolerance needs guess"),
    ({"guess_tolerance": (3, -1)}, "guess_tolerance.translation = -1"),
    ({"guess": np.eye(3)}, "guess: must be an array of numbers of shape (4, 4)"),
    ({"guess": 2 * np.eye(4)}, "guess is not a rigid motion"),
    ({"guess": np.full((4, 4), np.nan)}, "guess is not finite"),
    ({"source_viewpoint": [1, 2]}, "source_viewpoint = [1, 2], must be three finite numbers"),
    ({"target_viewpoint": [1, 2, np.nan]}, "target_viewpoint = "),
    ({"source_normals": np.zeros((3, 3))}, "source_normals: has 3 rows for"),
    ({"numbers": {"search.width": 1}}, "search.width"),
    ({"numbers": {"preparation.match": -1}}, "preparation.match = -1, must"),
    ({"numbers": {"preparation.patches.min_points": 2}}, "preparation.patches.min_points = 2, must"),
    ({"numbers": 3}, "numbers = 3, must be a dict"),
]


@pytest.mark.parametrize("options,text", WRONG_OPTIONS, ids=lambda value: None if isinstance(value, dict) else value)
def test_wrong_options(apartment, options, text):
    with pytest.raises(ValueError) as raised:
        pcl_ssfr.register_scans(*apartment, **options)
    assert text in str(raised.value)


def test_few_points_are_a_status_and_no_error(apartment):
    result = pcl_ssfr.register_scans(apartment[0][:5], apartment[1])
    assert result.status == pcl_ssfr.Status.TOO_FEW_POINTS and not result.converged and result.message


def test_defaults_are_options(apartment):
    source, target = (points[::20] for points in apartment)
    for profile in ("default", "paper2017"):
        defaults = pcl_ssfr.default_options(profile)
        assert defaults["profile"] == profile and defaults["threads"] == 0 and defaults["max_candidates"] == 10
        assert pose(pcl_ssfr.register_scans(source, target, **defaults)) == pose(
            pcl_ssfr.register_scans(source, target, profile=profile)
        )


def test_numbers(apartment):
    source, target = (points[::20] for points in apartment)
    plain = pcl_ssfr.register_scans(source, target)
    assert pose(pcl_ssfr.register_scans(source, target, numbers={"preparation.match": 0.1})) == pose(plain)
    changed = {"refinement.distinct_distance": 0.15, "preparation.patches.min_points": 7}
    defaults = pcl_ssfr.default_numbers()
    assert set(changed) <= set(defaults) and list(defaults) == pcl_ssfr.number_names()
    assert pose(pcl_ssfr.register_scans(source, target, numbers=defaults)) == pose(plain)
    assert pose(pcl_ssfr.register_scans(source, target, numbers=changed)) != pose(plain)


def test_normals_are_read_by_the_profile_of_the_paper(apartment):
    source, target = (np.ascontiguousarray(points[::10]) for points in apartment)
    up = np.zeros_like(source)
    up[:, 2] = 1
    plain = pcl_ssfr.register_scans(source, target, profile="paper2017")
    result = pcl_ssfr.register_scans(source, target, profile="paper2017", source_normals=up)
    assert result.status == "too_few_directions" != plain.status
    wide = np.hstack([source, up])  # both with the stride of the wider array
    again = pcl_ssfr.register_scans(wide[:, :3], target, profile="paper2017", source_normals=wide[:, 3:])
    assert (again.message, pose(again)) == (result.message, pose(result))
    mixed = pcl_ssfr.register_scans(source, target, profile="paper2017", source_normals=up.astype(np.float64))
    assert (mixed.message, pose(mixed)) == (result.message, pose(result))


def test_viewpoints(apartment):
    source, target = (points[::5] for points in apartment)
    shift = np.array([3.0, -2.0, 0.5])
    moved = (source + shift).astype(np.float32)
    given = pcl_ssfr.register_scans(moved, target, source_viewpoint=shift)
    assert given.source_viewpoint.tolist() == shift.tolist() and not given.source_viewpoint_found
    wrong = pcl_ssfr.register_scans(moved, target, source_viewpoint=shift + 20)
    assert wrong.source_viewpoint_found, "it does not fit the points, so it is looked for"
    sure = pcl_ssfr.register_scans(moved, target, source_viewpoint=shift + 20, viewpoint_mode="sensor")
    assert sure.source_viewpoint.tolist() == (shift + 20).tolist()
    assert pcl_ssfr.register_scans(moved, target, viewpoint_mode="unused").source_viewpoint is None


def test_masked_points_are_none(apartment, aligned):
    points = apartment[0].copy()
    masked = np.zeros(points.shape, bool)
    masked[1::2] = True
    expected = pcl_ssfr.register_scans(np.where(masked, np.nan, points).astype(np.float32), apartment[1])
    points[1::2] = 3 * points[1::2] + 1
    result = pcl_ssfr.register_scans(np.ma.masked_array(points, masked), apartment[1])
    assert pose(result) == pose(expected) != pose(aligned)


class TestPrepared:
    def test_same_bits(self, apartment, aligned):
        prepared = [pcl_ssfr.prepare_scan(points) for points in apartment]
        assert prepared[0].points == len(apartment[0]) and prepared[0].options["profile"] == "default"
        for source, target in ((prepared[0], prepared[1]), (prepared[0], apartment[1]), (apartment[0], prepared[1])):
            assert pose(pcl_ssfr.register_scans(source, target)) == pose(aligned)

    def test_keeps_nothing_of_the_array(self, apartment, aligned):
        source = apartment[0].copy()
        prepared = pcl_ssfr.prepare_scan(source)
        source[:] = np.nan
        assert pose(pcl_ssfr.register_scans(prepared, apartment[1])) == pose(aligned)

    def test_its_options_hold(self, apartment):
        source = pcl_ssfr.prepare_scan(apartment[0], leaf=0.05)
        result = pcl_ssfr.register_scans(source, apartment[1])
        assert pose(result) == pose(pcl_ssfr.register_scans(*apartment, leaf=0.05))
        with pytest.raises(ValueError, match="^source: was prepared with other options"):
            pcl_ssfr.register_scans(source, apartment[1], leaf=0.1)
        with pytest.raises(ValueError, match="^target: was prepared with other options"):
            pcl_ssfr.register_scans(pcl_ssfr.prepare_scan(apartment[0]), source)
        with pytest.raises(ValueError, match="^source_viewpoint: the source is prepared already"):
            pcl_ssfr.register_scans(source, apartment[1], source_viewpoint=[0, 0, 0])

        again = pcl_ssfr.register_scans(source, apartment[1], profile="default")
        assert pose(again) == pose(result), "the profile that it is of resets nothing"

    def test_numbers_of_two_scans(self, apartment):
        """Numbers of the search are no part of a preparation, so two scans may have different ones."""
        search = [{"judgement.decided": 0.9}, {"judgement.decided": 0.8}]
        source, target = (pcl_ssfr.prepare_scan(p, numbers=n) for p, n in zip(apartment, search))
        with pytest.raises(ValueError, match="^numbers: source and target were prepared with other ones"):
            pcl_ssfr.register_scans(source, target)
        assert pcl_ssfr.register_scans(source, target, numbers=search[1]).converged

    @pytest.mark.parametrize(
        "options",
        [{"gravity": [0, 0, 1]}, {"guess_tolerance": (1, 1)}, {"min_confidence": 1}, {"time_limit": 1}, {"refine": False}],
        ids=lambda options: next(iter(options)),
    )
    def test_options_of_a_search(self, apartment, options):
        with pytest.raises(ValueError, match=next(iter(options)) + " is read by register_scans"):
            pcl_ssfr.prepare_scan(apartment[0], **options)

    def test_wrong_viewpoint(self, apartment):
        with pytest.raises(ValueError, match="^viewpoint = 3, must be three finite numbers"):
            pcl_ssfr.prepare_scan(apartment[0], viewpoint=3)


class TestThreads:
    def test_the_interpreter_is_free_while_it_runs(self, apartment):
        """Another thread beats on during a registration: hundreds of times; were it not free, once or twice."""
        done = threading.Event()
        beats = []

        def beat():
            while not done.is_set():
                time.sleep(0.0005)
                beats.append(None)

        counter = threading.Thread(target=beat)
        counter.start()
        before = len(beats)
        pcl_ssfr.register_scans(*apartment, threads=1)
        during = len(beats) - before
        done.set()
        counter.join()
        assert during > 10

    def test_two_at_a_time(self, apartment, aligned):
        results = [None] * 4
        prepared = pcl_ssfr.prepare_scan(apartment[0])

        def work(i):
            results[i] = pcl_ssfr.register_scans(prepared, apartment[1], threads=1 + i % 2)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(len(results))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert {pose(result) for result in results} == {pose(aligned)}

    def test_time_limit(self, apartment):
        result = pcl_ssfr.register_scans(*apartment, time_limit=1e-6)
        assert result.status == pcl_ssfr.Status.TIME_LIMIT and "time limit" in result.message
