# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""scripts/public_benchmark: each layout on a small folder made up here, its true poses, and what it says of broken ones.

Usage: public_benchmark_test.py [SSFR_BENCHMARK]; exits with 77 without numpy."""
import csv
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy
except ImportError:
    print("skipped: numpy is missing")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "scripts" / "public_benchmark"
PROGRAM = None
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "scripts"))
# pylint: disable=wrong-import-position
from public_benchmarks import common, kitti, published, run, scannetpp, whu_tls  # noqa: E402

RANDOM = numpy.random.default_rng(7)
# Points of a made-up place, in its frame [m].
WORLD = RANDOM.uniform((-30, -30, 0), (60, 30, 6), (400, 3))


def some_pose(place, degrees=0.0, axis=(0, 0, 1)):
    half = numpy.radians(degrees) / 2
    axis = numpy.asarray(axis, dtype=float) / numpy.linalg.norm(axis)
    return common.pose(place, (*(numpy.sin(half) * axis), numpy.cos(half)), "test")


def track(count, step):
    """Poses of a drive, a step [m] between two."""
    return [some_pose((step * i, 0.005 * i * i, 0.1 * i), 3 * i, (0.1, 0.05, 1)) for i in range(count)]


def in_frame(T_world_scan):
    """The points of the place as a scan at that pose sees them."""
    T = common.inverse(T_world_scan)
    return WORLD @ T[:3, :3].T + T[:3, 3]


def row(T):
    return " ".join(f"{v:.12g}" for v in T[:3].flatten())


def rows(T, separator=" "):
    return "\n".join(separator.join(f"{v:.12g}" for v in line) for line in T)


def tum(T):
    return " ".join(f"{v:.12g}" for v in (*T[:3, 3], *common.quaternion_of(T[:3, :3])))


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def write_bin(path, points):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(numpy.hstack([points, numpy.ones((len(points), 1))]).astype("<f4").tobytes())


def write_pcd(path, points, viewpoint=None):
    path.parent.mkdir(parents=True, exist_ok=True)
    common.write_pcd(path, points)
    if viewpoint is not None:
        path.write_bytes(path.read_bytes().replace(b"VIEWPOINT 0 0 0", b"VIEWPOINT %g %g %g" % tuple(viewpoint)))


def write_ply(path, points):
    path.parent.mkdir(parents=True, exist_ok=True)
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    header += "property float x\nproperty float y\nproperty float z\nend_header\n"
    path.write_bytes(header.encode() + points.astype("<f4").tobytes())


def write_las(path, points):
    """LAS 1.2, point format 0."""
    path.parent.mkdir(parents=True, exist_ok=True)
    scale = 0.0001
    head = bytearray(227)
    head[:4] = b"LASF"
    head[24:26] = bytes([1, 2])
    struct.pack_into("<HI", head, 94, 227, 227)
    struct.pack_into("<BHI", head, 104, 0, 20, len(points))
    struct.pack_into("<6d", head, 131, scale, scale, scale, 0, 0, 0)
    low, high = points.min(axis=0), points.max(axis=0)
    struct.pack_into("<6d", head, 179, high[0], low[0], high[1], low[1], high[2], low[2])
    records = numpy.zeros(len(points), dtype=[("xyz", "<i4", 3), ("rest", "V8")])
    records["xyz"] = numpy.round(points / scale)
    path.write_bytes(bytes(head) + records.tobytes())


def read_cloud(path):
    """Points of a converted scan."""
    data = path.read_bytes()
    if path.suffix == ".bin":
        return numpy.frombuffer(data, dtype="<f4").reshape(-1, 4)[:, :3]
    if path.suffix == ".csv":
        return numpy.loadtxt(path, delimiter=",", skiprows=1)[:, 1:4]
    if path.suffix == ".las":
        count, = struct.unpack_from("<I", data, 107)
        return numpy.frombuffer(data, dtype=[("xyz", "<i4", 3), ("rest", "V8")], count=count, offset=227)["xyz"] * 0.0001
    mark = b"DATA binary\n" if path.suffix == ".pcd" else b"end_header\n"
    return numpy.frombuffer(data[data.index(mark) + len(mark):], dtype="<f4").reshape(-1, 3)


class Case(unittest.TestCase):
    """A folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.root = self.top / "published"
        self.root.mkdir()
        self.out = self.top / "out"

    def convert(self, key, **choice):
        run.convert(key, self.root, self.out, common.Choice(**choice))
        with open(self.out / "dataset" / "pairs.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def check_points(self, pairs, tolerance=1e-3, count=len(WORLD)):
        """T of each pair lays the points of its source on those of its target."""
        self.assertTrue(pairs)
        for pair in pairs:
            T = numpy.array([[float(pair[f"T{r}{c}"]) for c in range(4)] for r in range(4)])
            source, target = (read_cloud(self.out / "dataset" / "scans" / pair[name]) for name in ("source", "target"))
            self.assertEqual((len(source), len(target)), (count, count))
            self.assertLess(numpy.abs(source @ T[:3, :3].T + T[:3, 3] - target).max(), tolerance, pair)
            self.assertGreater(numpy.abs(source - target).max(), 0.5, "the identity would do")
        self.check_that_it_is_read()

    def check_that_it_is_read(self):
        """ssfr_benchmark takes the folder and reads the clouds of its first pair; points at random have no right pose."""
        if PROGRAM is None:
            return
        out = tempfile.mkdtemp(dir=self.top)
        done = subprocess.run([PROGRAM, "--dataset", self.out / "dataset", "--out", out, "--pairs", "0", "--no-rmse",
                               "--pictures", "0"],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(pathlib.Path(out) / "results.csv", newline="", encoding="utf-8") as file:
            results = list(csv.DictReader(file))
        self.assertEqual(len(results), 1)
        self.assertNotIn(results[0]["status"], ("failed", "crashed", "bad_output", "missing", "timeout"), results[0]["message"])

    def error_of(self, key, **choice):
        with self.assertRaises(common.Failure) as caught:
            self.convert(key, **choice)
        self.assertNotIn("\n", str(caught.exception))
        return str(caught.exception)

    def description(self):
        return json.loads((self.out / "dataset" / "dataset.json").read_text())


class Kitti(Case):
    """sequences/NN and poses/NN.txt."""

    T_CAMERA_VELODYNE = common.rigid(
        [0.0, -1.0, 0.0, -0.004, 0.0, 0.0, -1.0, -0.076, 1.0, 0.0, 0.0, -0.27], "test")

    def make(self, sequence="08", cameras=None):
        cameras = cameras or track(30, 1.3)
        for i, T in enumerate(cameras):
            write_bin(self.root / "sequences" / sequence / "velodyne" / f"{i:06d}.bin", in_frame(T @ self.T_CAMERA_VELODYNE))
        write(self.root / "sequences" / sequence / "calib.txt",
              "P0: " + "1 " * 11 + f"1\nTr: {row(self.T_CAMERA_VELODYNE)}\n")
        write(self.root / "poses" / f"{sequence}.txt", "".join(row(T) + "\n" for T in cameras))

    def test_poses_and_pairs(self):
        self.make()
        pairs = self.convert("kitti", sequences=["08"])
        self.check_points(pairs)
        # Seven steps of 1.3 m and a little to the side are the last below 10 m; the next source follows the target.
        self.assertEqual([(p["source"], p["target"]) for p in pairs],
                         [("08_000000.bin", "08_000007.bin"), ("08_000008.bin", "08_000015.bin"),
                          ("08_000016.bin", "08_000023.bin")])
        self.assertEqual(self.description()["success"], {"rotation_deg": 5, "translation_m": 2})
        self.assertTrue((self.out / "dataset" / "scans" / "08_000000.bin").is_symlink())
        poses = (self.out / "dataset" / "poses.txt").read_text().splitlines()
        self.assertEqual(len(poses), 1 + 6)

    def test_the_three_sequences_without_a_choice(self):
        for sequence in kitti.TEST_SEQUENCES:
            self.make(sequence)
        self.assertEqual(len(self.convert("kitti")), 9)
        self.assertFalse((self.out / "dataset" / "poses.txt").exists(), "poses of three worlds are not those of one")

    def test_a_refined_pose_replaces_that_of_the_file(self):
        self.make()
        (self.root / "icp").mkdir()
        numpy.save(self.root / "icp" / "8_0_7.npy", some_pose((1, 2, 3), 45))
        pairs = self.convert("kitti", sequences=["08"])
        self.assertEqual([float(pairs[0][f"T{r}3"]) for r in range(3)], [1, 2, 3])
        self.assertIn("1 poses from icp/", self.description()["note"])

    def test_the_wrong_pair_is_left_out(self):
        cameras = [some_pose((0.1 * i if i < 15 else 12 + 0.23 * (i - 15), 0, 0), i) for i in range(63)]
        self.assertEqual(common.spaced_pairs([T[:3, 3] for T in cameras], 10), [(0, 14), (15, 58)])
        self.make(cameras=cameras)
        pairs = self.convert("kitti", sequences=["08"])
        self.assertEqual([(p["source"], p["target"]) for p in pairs], [("08_000000.bin", "08_000014.bin")])

    def test_a_list_of_pairs(self):
        self.make()
        write(self.top / "list.txt", "# mine\n08_000003 08_000009\n")
        pairs = self.convert("kitti", sequences=["08"], pair_list=self.top / "list.txt")
        self.check_points(pairs)
        self.assertEqual([(p["source"], p["target"]) for p in pairs], [("08_000003.bin", "08_000009.bin")])
        write(self.top / "list.txt", "08_000003 08_000099\n")
        self.assertIn("list.txt:1: '08_000099'", self.error_of("kitti", sequences=["08"], pair_list=self.top / "list.txt"))

    def test_what_is_wrong_is_named(self):
        self.assertIn("sequences", self.error_of("kitti"))
        self.make()
        self.assertIn("'11'", self.error_of("kitti", sequences=["11"]))
        self.assertIn("sequences/09/velodyne: there is no such folder", self.error_of("kitti"))
        poses = self.root / "poses" / "08.txt"
        lines = poses.read_text().splitlines()
        poses.write_text("\n".join(lines[:-1]) + "\n")
        self.assertIn("29 poses, but 30 scans", self.error_of("kitti", sequences=["08"]))
        poses.write_text("\n".join([*lines[:4], lines[4] + " 1", *lines[5:]]) + "\n")
        self.assertIn("08.txt:5: 13 columns, expected 12", self.error_of("kitti", sequences=["08"]))
        poses.write_text("\n".join([*lines[:4], "nan" + lines[4][1:], *lines[5:]]) + "\n")
        self.assertIn("08.txt:5: 'nan", self.error_of("kitti", sequences=["08"]))
        poses.write_text("\n".join([*lines[:4], row(2 * some_pose((0, 0, 0))), *lines[5:]]) + "\n")
        self.assertIn("08.txt:5: the matrix is no rigid motion", self.error_of("kitti", sequences=["08"]))
        poses.write_text("\n".join(lines) + "\n")
        (self.root / "sequences" / "08" / "calib.txt").write_text("P0: 1\n")
        self.assertIn("calib.txt: has no line 'Tr:'", self.error_of("kitti", sequences=["08"]))
        (self.root / "sequences" / "08" / "calib.txt").unlink()
        self.assertIn("calib.txt: there is no such file", self.error_of("kitti", sequences=["08"]))


class Eth(Case):
    """Both layouts."""

    def make_sequence(self, local="csv_local", poses="csv_global", count=4):
        truth = [some_pose((2 * i, 1, 0.1 * i), 40 * i, (0, 0.2, 1)) for i in range(count)]
        lines = ["poseId, timestamp, T00, T01, T02, T03, T10, T11, T12, T13, T20, T21, T22, T23, T30, T31, T32, T33"]
        for i, T in enumerate(truth):
            points = in_frame(T)
            table = "\n".join(f"{j}, {x:.6f}, {y:.6f}, {z:.6f}, 1" for j, (x, y, z) in enumerate(points))
            write(self.root / local / f"Hokuyo_{i}.csv", f"timestamp, x, y, z, Intensities\n{table}\n")
            lines.append(f"{i}, {1e9 + i:.3f}, " + ", ".join(f"{v:.12g}" for v in T.flatten()))
        write(self.root / poses / "pose_scanner_leica.csv", "\n".join(lines) + "\n")

    def test_a_sequence_of_the_makers(self):
        self.make_sequence()
        pairs = self.convert("eth")
        self.check_points(pairs)
        self.assertEqual([(p["source"], p["target"]) for p in pairs],
                         [(f"Hokuyo_{i + 1}.csv", f"Hokuyo_{i}.csv") for i in range(3)])
        self.assertEqual(self.description()["success"], {"rotation_deg": 2, "translation_m": 0.3})

    def test_the_other_names_of_its_folders(self):
        self.make_sequence("local_frame", "global_frame", 3)
        self.check_points(self.convert("eth"))

    def test_the_test_set(self):
        truth = [some_pose((i, 0.5 * i, 0), 50 * i) for i in range(3)]
        for i, T in enumerate(truth):
            write_ply(self.root / "gazebo_summer" / f"Hokuyo_{i}.ply", in_frame(T))
        records = [f"{a}\t {b}\t 3\n{rows(common.relative(truth[a], truth[b]), chr(9) + ' ')}" for a, b in ((0, 1), (0, 2))]
        write(self.root / "gazebo_summer" / "gt.log", "\n".join(records) + "\n")
        pairs = self.convert("eth")
        self.check_points(pairs)
        self.assertEqual([(p["source"], p["target"]) for p in pairs],
                         [("gazebo_summer_0.ply", "gazebo_summer_1.ply"), ("gazebo_summer_0.ply", "gazebo_summer_2.ply")])
        (self.root / "gazebo_summer" / "Hokuyo_2.ply").unlink()
        self.assertIn("Hokuyo_2.ply: there is no such file", self.error_of("eth"))
        write(self.root / "gazebo_summer" / "gt.log", "\n".join(records[0].splitlines()[:4]) + "\n")
        self.assertIn("gt.log: 4 lines", self.error_of("eth"))

    def test_what_is_wrong_is_named(self):
        self.assertIn("pose_scanner_leica.csv", self.error_of("eth"))
        self.make_sequence()
        (self.root / "csv_local" / "Hokuyo_3.csv").unlink()
        self.assertIn("4 poses, but 3 scans", self.error_of("eth"))
        path = self.root / "csv_global" / "pose_scanner_leica.csv"
        write(self.root / "csv_local" / "Hokuyo_7.csv", "timestamp, x, y, z\n")
        self.assertIn("pose 3 has no scan", self.error_of("eth"))
        path.write_text(path.read_text().replace("\n0, 1000000000.000, 1,", "\n0, 1000000000.000, one,"))
        self.assertIn("pose_scanner_leica.csv:2: 'one'", self.error_of("eth"))


class WhuTls(Case):
    """SCENE/1-RawPointCloud and 3-GroundTruth."""

    def make(self, aligned=True, swapped=False):
        truth = {i: some_pose((5.0 * i, -3, 0.2 * i), 70 * i) for i in (1, 2, 3)}
        scene = self.root / "3-Mountain"
        for i, T in truth.items():
            write_las(scene / "1-RawPointCloud" / f"{i}.las", in_frame(T))
            if aligned:
                write_las(scene / "2-AlignedPointCloud" / f"{i}.las", WORLD)
        for source, target in ((1, 2), (3, 2)):
            T = common.relative(truth[target], truth[source])
            write(scene / "3-GroundTruth" / f"{source}-{target}" / "transformation.txt",
                  rows(common.inverse(T) if swapped else T) + "\n")
        return scene

    def test_the_direction_is_taken_from_the_aligned_clouds(self):
        for swapped in (False, True):
            self.make(swapped=swapped)
            pairs = self.convert("whu_tls")
            self.check_points(pairs)
            self.assertEqual([(p["source"], p["target"]) for p in pairs],
                             [("3-Mountain_1.las", "3-Mountain_2.las"), ("3-Mountain_3.las", "3-Mountain_2.las")])
            self.assertIn("checked against", self.description()["note"])
        self.assertEqual(self.description()["viewpoint"], "unknown")

    def test_without_aligned_clouds_the_note_says_so(self):
        scene = self.make(aligned=False)
        self.check_points(self.convert("whu_tls"))
        self.assertIn("not checked", self.description()["note"])
        write_las(scene / "2-AlignedPointCloud" / "1.las", WORLD[::-1])  # another order: no poses from it
        self.convert("whu_tls")
        self.assertIn("not checked", self.description()["note"])

    def test_what_is_wrong_is_named(self):
        self.assertIn("3-GroundTruth", self.error_of("whu_tls"))
        scene = self.make()
        path = scene / "3-GroundTruth" / "1-2" / "transformation.txt"
        path.write_text(rows(some_pose((9, 9, 9), 10)) + "\n")
        self.assertIn("1-2/transformation.txt: neither", self.error_of("whu_tls"))
        path.write_text("1 0 0\n")
        self.assertIn("transformation.txt: 3 numbers", self.error_of("whu_tls"))
        (scene / "1-RawPointCloud" / "3.las").unlink()
        self.make(aligned=False)
        (scene / "1-RawPointCloud" / "3.las").rename(scene / "1-RawPointCloud" / "4.las")
        self.assertIn("no scan 3.las", self.error_of("whu_tls"))
        for path in (scene / "1-RawPointCloud").iterdir():
            path.rename(path.with_suffix(".laz"))
        self.assertIn("compressed", self.error_of("whu_tls"))

    def test_a_broken_las_file(self):
        path = self.root / "a.las"
        path.write_bytes(b"no")
        with self.assertRaisesRegex(common.Failure, "a.las: is no LAS file"):
            whu_tls.las_sample(path)
        write_las(path, WORLD)
        path.write_bytes(path.read_bytes()[:-1])
        with self.assertRaisesRegex(common.Failure, "400 points of 20 bytes do not fit"):
            whu_tls.las_sample(path)


class Resso(Case):
    """PLY files and a file of poses."""

    def make(self):
        truth = [some_pose((3 * i, 0, 0), 60 * i) for i in range(3)]
        for i, T in enumerate(truth):
            write_ply(self.root / "office" / f"s{i}.ply", in_frame(T))
        write(self.root / "office" / "poses.reg", "3\n" + "".join(f"s{i}.ply\n{rows(T)}\n" for i, T in enumerate(truth)))

    def test_consecutive_scans(self):
        self.make()
        pairs = self.convert("resso")
        self.check_points(pairs)
        self.assertEqual([(p["source"], p["target"]) for p in pairs],
                         [("office_s1.ply", "office_s0.ply"), ("office_s2.ply", "office_s1.ply")])

    def test_pairs_of_plade(self):
        self.make()
        write(self.root / "office" / "file_pairs.txt", "data/s0.ply\ndata/s2.ply\n")
        pairs = self.convert("resso")
        self.check_points(pairs)
        self.assertEqual([(p["source"], p["target"]) for p in pairs], [("office_s2.ply", "office_s0.ply")])
        write(self.root / "office" / "file_pairs.txt", "s0.ply\ns9.ply\n")
        self.assertIn("'s9.ply' has no pose", self.error_of("resso"))

    def test_what_is_wrong_is_named(self):
        self.assertIn("poses", self.error_of("resso"))
        self.make()
        path = self.root / "office" / "poses.reg"
        text = path.read_text()
        path.write_text(text.replace("3\n", "4\n", 1))
        self.assertIn("poses.reg: says 4 scans", self.error_of("resso"))
        path.write_text(text)
        (self.root / "office" / "s1.ply").unlink()
        self.assertIn("s1.ply: there is no such file", self.error_of("resso"))


class Drives(Case):
    """TIERS, Newer College, Oxford Spires, HeLiPR."""

    def make_numbered(self, folder, poses, extension="pcd", pose_name="poses_kitti.txt", scans="scans"):
        for i, T in enumerate(poses):
            path = self.root / folder / scans / f"{i:06d}.{extension}"
            if extension == "bin":
                write_bin(path, in_frame(T))
            else:
                write_pcd(path, in_frame(T), (7, 8, 9))
        write(self.root / folder / pose_name, "".join(row(T) + "\n" for T in poses))

    def check_viewpoints(self, pairs, place=(0, 0, 0)):
        for pair in pairs:
            header = (self.out / "dataset" / "scans" / pair["source"]).read_bytes()[:400]
            line = next(text for text in header.split(b"\n") if text.startswith(b"VIEWPOINT"))
            self.assertEqual([float(f) for f in line.split()[1:4]], list(place))

    def test_tiers(self):
        for sensor in ("os0_128", "vel16"):
            self.make_numbered(f"tiers_indoor06/{sensor}", track(12, 0.6))
        self.make_numbered("tiers_road02/vel16", track(12, 0.6))  # not of the published figures
        pairs = self.convert("tiers")
        self.check_points(pairs)
        self.check_viewpoints(pairs)
        self.assertEqual({p["source"].rsplit("_", 1)[0] for p in pairs}, {"tiers_indoor06_os0_128", "tiers_indoor06_vel16"})
        self.assertEqual(pairs[0]["target"], "tiers_indoor06_os0_128_000003.pcd")
        write(self.top / "list.txt", "tiers_indoor06_os0_128_000001 tiers_indoor06_vel16_000001\n")
        self.assertIn("not in one frame", self.error_of("tiers", pair_list=self.top / "list.txt"))
        (self.root / "tiers_indoor06" / "vel16" / "scans" / "000011.pcd").unlink()
        self.assertIn("12 poses, but 11 scans", self.error_of("tiers"))
        self.assertIn("tiers_road02", self.convert("tiers", sequences=["tiers_road02"])[0]["source"])
        self.assertIn("'indoor99'", self.error_of("tiers", sequences=["indoor99"]))

    def test_tiers_as_bags(self):
        self.assertIn("poses_kitti.txt", self.error_of("tiers"))
        (self.root / "Indoor06.bag").write_bytes(b"#ROSBAG V2.0\n")
        self.assertIn("bag files", self.error_of("tiers"))

    def test_newer_college_extracted(self):
        self.make_numbered("01_short_experiments", track(16, 1.1))
        pairs = self.convert("newer_college")
        self.check_points(pairs)
        self.check_viewpoints(pairs)
        self.assertEqual(self.description()["success"], {"rotation_deg": 5, "translation_m": 2})

    def test_newer_college_of_the_makers(self):
        """Poses are those of the camera, between two of which the time of a scan lies."""
        T_camera_ouster = common.pose((-0.084, -0.025, 0.050), (0, 0, 0.924, 0.383), "test")
        lines = ["#sec,nsec,x,y,z,qx,qy,qz,qw"]
        begin = 1583836591
        for i in range(16):
            half = [some_pose((1.2 * (i + s), 0.3, 0), 4 * (i + s)) for s in (0, 0.5)]
            write_pcd(self.root / "raw_format" / "ouster_scan" / f"cloud_{begin + i // 10}_{i % 10}50000000.pcd",
                      in_frame(half[1] @ T_camera_ouster), (1, 2, 3))
            lines.append(f"{begin + i // 10},{i % 10}00000000," + ",".join(tum(half[0]).split()))
        lines.append(f"{begin + 1},600000000," + ",".join(tum(some_pose((1.2 * 16, 0.3, 0), 64)).split()))
        write(self.root / "ground_truth" / "registered_poses.csv", "\n".join(lines) + "\n")
        pairs = self.convert("newer_college")
        self.check_points(pairs, 2e-3)
        self.check_viewpoints(pairs)
        self.assertEqual(pairs[0]["source"], f"published_cloud_{begin}_050000000.pcd")
        write(self.root / "ground_truth" / "registered_poses.csv", "\n".join(lines[:2]) + "\n")
        self.assertIn("registered_poses.csv: 0 of 16 scans", self.error_of("newer_college"))
        write(self.root / "ground_truth" / "registered_poses.csv", "\n".join(lines[:2]) + ",1\n")
        self.assertIn("registered_poses.csv:2: 10 columns", self.error_of("newer_college"))

    def test_newer_college_that_is_not_there(self):
        self.assertIn("neither raw_format", self.error_of("newer_college"))

    def make_spires(self, folder, T_base_cloud):
        sequence = self.root / "sequences" / "2024-03-12-keble-college-02" / "processed"
        lines = []
        for i, T in enumerate(track(24, 1.0)):
            write_pcd(sequence / folder / f"cloud_1710000000_{i:02d}0000000.pcd", in_frame(T @ T_base_cloud), (4, 4, 4))
            lines.append(f"1710000000.{i:02d} {tum(T)}")
        write(sequence / "trajectory" / "gt-tum.txt", "# t x y z qx qy qz qw\n" + "\n".join(lines) + "\n")

    def test_oxford_spires(self):
        self.make_spires("vilens-slam/undist-clouds", numpy.eye(4))
        pairs = self.convert("oxford_spires")
        self.check_points(pairs)
        self.check_viewpoints(pairs, (0, 0, 0.124))
        self.assertEqual(self.description()["viewpoint"], "sensor")

    def test_oxford_spires_in_the_frame_of_the_lidar(self):
        T_base_lidar = some_pose((0, 0, 0.124), 180)
        self.make_spires("lidar-undistortion/undist-clouds-image-synced", T_base_lidar)
        pairs = self.convert("oxford_spires")
        self.check_points(pairs)
        self.check_viewpoints(pairs)

    def test_oxford_spires_broken(self):
        self.assertIn("processed", self.error_of("oxford_spires"))
        (self.root / "a" / "processed").mkdir(parents=True)
        self.assertIn("unpack", self.error_of("oxford_spires"))
        self.make_spires("vilens-slam/undist-clouds", numpy.eye(4))
        path = self.root / "sequences" / "2024-03-12-keble-college-02" / "processed" / "trajectory" / "gt-tum.txt"
        (self.root / "a" / "processed").rmdir()
        path.write_text(path.read_text().replace("1710000000.03 ", "yesterday "))
        self.assertIn("gt-tum.txt:5: 'yesterday' is no time", self.error_of("oxford_spires"))
        path.unlink()
        self.assertIn("gt-tum.txt: there is no such file", self.error_of("oxford_spires"))

    RECORDS = {"Ouster": ("<ffffIHHH", (1, 2, 3, 4, 5)), "Velodyne": ("<ffffHf", (1, 2, 3)), "Avia": ("<fffBBBI", (1, 2, 3, 4)),
               "Aeva": ("<fffffiB", (1, 2, 3, 4))}

    def make_helipr(self, sensor, begin=1691936500000000000):
        layout, rest = self.RECORDS[sensor]
        lines = []
        for i, T in enumerate(track(12, 3.0)):
            stamp = begin + 100000000 * i
            more = ("f", (9.0,)) if sensor == "Aeva" and stamp > 1691936557946849179 else ("", ())
            data = b"".join(struct.pack(layout + more[0], *p, *rest, *more[1]) for p in in_frame(T))
            path = self.root / "LiDAR" / sensor / f"{stamp}.bin"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            if i != 1:  # a scan without a pose
                lines.append(f"{stamp} {tum(T)}")
        write(self.root / "LiDAR_GT" / f"{sensor}_gt.txt", "\n".join(lines) + "\n")

    def test_helipr(self):
        for sensor in self.RECORDS:
            self.make_helipr(sensor)
        for sensor in self.RECORDS:
            pairs = self.convert("helipr", sequences=[sensor])
            self.check_points(pairs)
            self.assertEqual(pairs[0]["target"], f"{sensor}_1691936500300000000.pcd")
        self.assertEqual({p["source"].split("_")[0] for p in self.convert("helipr")}, {"Avia", "Aeva", "Ouster"})

    def test_helipr_later_scans_of_the_aeva(self):
        self.make_helipr("Aeva", 1691936557946849179 + 1)
        self.check_points(self.convert("helipr"))

    def test_helipr_extracted(self):
        self.make_numbered("Avia", track(12, 3.0), "bin", "poses.txt", "velodyne")
        self.check_points(self.convert("helipr"))

    def test_helipr_broken(self):
        self.assertIn("LiDAR/SENSOR", self.error_of("helipr"))
        self.make_helipr("Avia")
        path = next((self.root / "LiDAR" / "Avia").glob("*500000000.bin"))
        path.write_bytes(path.read_bytes()[:-1])
        first = self.root / "LiDAR" / "Avia" / "1691936500000000000.bin"
        first.write_bytes(first.read_bytes()[:-1])
        self.assertIn("not a whole number of Avia points of 19 bytes", self.error_of("helipr"))
        (self.root / "LiDAR_GT" / "Avia_gt.txt").write_text("1 0 0 0 0 0 0 1\n")
        self.assertIn("Avia_gt.txt: 0 of the 12 scans", self.error_of("helipr"))
        (self.root / "LiDAR_GT" / "Avia_gt.txt").write_text("1 0 0 0 0 0 0 3\n")
        self.assertIn("Avia_gt.txt:1: the quaternion has the length 3", self.error_of("helipr"))


class ScanNet(Case):
    """One cloud of a scene and the poses of its scanners."""

    @staticmethod
    def room():
        """Floor and walls of a room of 6 x 5 x 3 m, and a wall of another one that only the third scanner sees."""
        a, b = (g.flatten() for g in numpy.meshgrid(numpy.arange(0, 6, 0.06), numpy.arange(0, 5, 0.06)))
        c, d = (g.flatten() for g in numpy.meshgrid(numpy.arange(0, 6, 0.06), numpy.arange(0, 3, 0.06)))
        floor = numpy.stack([a, b, 0 * a], axis=1)
        wall = numpy.stack([c, 0 * c, d], axis=1)
        return numpy.vstack([floor, wall, wall + (0, 5, 0), wall[:, [1, 0, 2]] + (0, 0, 0), wall + (40, 40, 0)])

    def make(self):
        scannetpp.scene_scans.cache_clear()  # folders are not changed between two calls, but here
        self.poses = [some_pose((2, 2, 1.5), 30), some_pose((4, 3, 1.4), 100), some_pose((43, 43, 1.5), 5)]
        self.scans = self.root / "data" / "0a5c013435" / "scans"
        write_ply(self.scans / "pc_aligned.ply", self.room())
        write(self.scans / "scanner_poses.json", json.dumps([T.tolist() for T in self.poses]))

    def test_scans_and_pairs(self):
        self.make()
        pairs = self.convert("scannetpp")
        self.assertEqual([(p["source"], p["target"]) for p in pairs], [("0a5c013435_0.pcd", "0a5c013435_1.pcd")])
        T = numpy.array([[float(pairs[0][f"T{r}{c}"]) for c in range(4)] for r in range(4)])
        source, target = (read_cloud(self.out / "dataset" / "scans" / pairs[0][name]) for name in ("source", "target"))
        moved = source @ T[:3, :3].T + T[:3, 3]
        nearest = numpy.array([numpy.linalg.norm(target - p, axis=1).min() for p in moved[::50]])
        self.assertLess(numpy.median(nearest), 0.01)
        self.assertEqual(self.description()["success"], {"rotation_deg": 15, "translation_m": 0.3})

    def test_what_a_scanner_sees(self):
        T = some_pose((1, 0, 0), 90)
        cloud = numpy.array([[3, 0, 0], [5, 0, 0], [1.3, 0, 0], [1, 2, 0.5]])  # behind the first; too near; elsewhere
        seen = scannetpp.seen_from(cloud, T)
        expected = (cloud[[0, 3]] - (1, 0, 0)) @ T[:3, :3]
        self.assertEqual(sorted(map(tuple, seen.round(6))), sorted(map(tuple, expected.round(6))))

    def test_overlap_against_brute_force(self):
        a, b = RANDOM.uniform(0, 0.6, (300, 3)), RANDOM.uniform(0.2, 0.8, (250, 3))
        near = (numpy.linalg.norm(a[:, None] - b[None], axis=2) <= scannetpp.VOXEL).any(axis=1).mean()
        self.assertTrue(0.05 < near < 0.95)
        self.assertEqual(scannetpp.share_near(a, b), near)
        self.assertEqual(scannetpp.share_near(a, a), 1)
        self.assertEqual(scannetpp.share_near(a, a + 10), 0)

    def test_pairs_of_the_scripts_of_bufferx(self):
        self.make()
        for i, T in enumerate(self.poses):
            write_ply(self.scans / f"trans_faro_1800x900_scanner_{i}.ply", in_frame(T))
        write(self.scans / "gt.log", f"0\t1\t3\n{rows(common.relative(self.poses[1], self.poses[0]))}\n")
        self.check_points(self.convert("scannetpp"))

    def test_what_is_wrong_is_named(self):
        self.assertIn("scanner_poses.json", self.error_of("scannetpp"))
        self.make()
        (self.scans / "scanner_poses.json").write_text("[[1, 2]]")
        self.assertIn("scanner_poses.json: is no list of 4x4 matrices", self.error_of("scannetpp"))
        self.make()
        path = self.scans / "pc_aligned.ply"
        path.write_bytes(path.read_bytes()[:-1])
        self.assertIn("pc_aligned.ply: ", self.error_of("scannetpp"))
        path.write_text("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n")
        self.assertIn("'ascii' is not binary", self.error_of("scannetpp"))


class Parts(unittest.TestCase):
    """What the layouts share."""

    def test_quaternions(self):
        for degrees, axis in ((0, (0, 0, 1)), (180, (0, 0, 1)), (180, (1, 0, 0)), (120, (1, 1, 1)), (77, (0.3, -1, 2))):
            T = some_pose((0, 0, 0), degrees, axis)
            again = common.pose((0, 0, 0), common.quaternion_of(T[:3, :3]), "test")
            self.assertLess(numpy.abs(T - again).max(), 1e-12)
            self.assertAlmostEqual(common.angle_deg(T[:3, :3]), degrees, 6)

    def test_far_places_keep_their_digits(self):
        a, b = some_pose((4.5e6, 3e6, 100), 20), some_pose((4.5e6 + 1.25, 3e6, 100), 50)
        T = common.relative(a, b)
        self.assertLess(numpy.abs(common.inverse(some_pose((0, 0, 0), 20))[:3, :3] @ (1.25, 0, 0) - T[:3, 3]).max(), 1e-9)

    def test_interpolation(self):
        poses = common.Track({100: some_pose((2, 0, 0), 50), 0: some_pose((0, 0, 0), 10)})
        middle = poses.at(25, 200)
        self.assertLess(numpy.abs(middle - some_pose((0.5, 0, 0), 20)).max(), 1e-12)
        self.assertIs(poses.at(100, 1), poses[100])
        for time, gap in ((-1, 200), (101, 200), (50, 99)):
            self.assertIsNone(poses.at(time, gap))

    def test_spaced_pairs(self):
        positions = [(x, 0, 0) for x in (0, 4, 9, 11, 12, 13, 30, 50)]
        # 0 -> 2 (11 is the first beyond 10), 3 -> 5, and from 6 on each jump is too long for a pair.
        self.assertEqual(common.spaced_pairs(positions, 10), [(0, 2), (3, 5)])
        self.assertEqual(common.spaced_pairs([(0, 0, 0)] * 5, 10), [])
        far = [(0, 0, 0)] * 99 + [(20, 0, 0)]
        self.assertEqual(common.spaced_pairs(far, 10), [(0, 98)])
        self.assertEqual(common.spaced_pairs([(0, 0, 0)] + far, 10), [(1, 99)])  # beyond the 100 scans that are looked at

    def test_published_figures_are_those_of_sets_and_methods(self):
        for key, figures in published.BUFFER_X_SUCCESS.items():
            self.assertIn(key, run.LAYOUTS)
            self.assertEqual(len(figures), len(published.BUFFER_X_METHODS))
        self.assertEqual(published.published_rows("whu_tls"), [])
        page = (ROOT / "docs" / "PUBLIC_BENCHMARKS.md").read_text()
        for figures in published.BUFFER_X_SUCCESS.values():
            self.assertIn(" | " + " | ".join(f"{figure:.2f}" for figure in figures) + " |", page)
        for layout in run.LAYOUTS.values():
            self.assertIn(f"### {layout.title}", page)

    def test_table(self):
        entry = {"method": "ssfr", "dataset": "kitti", "pairs": 4, "solved": 3, "accepted": 2, "false_positives": 0,
                 "median_rotation_error_deg": 0.1234, "median_translation_error_m": None}
        lines = run.result_table("kitti", {"methods": [entry, {**entry, "dataset": None}]}).splitlines()
        self.assertEqual(lines[2], "| ssfr | 4 | 75.00 % | 2 | 0 | 0.123 deg | - cm | this run |")
        self.assertEqual(len(lines), 3 + 5)
        self.assertIn("99.82 %", lines[3])
        self.assertEqual(len({line.count("|") for line in lines}), 1)
        self.assertIn("no figure found", run.result_table("resso", {"methods": []}))


class CommandLine(Case):
    """Use and end-to-end run."""

    def call(self, *arguments):
        return subprocess.run([sys.executable, str(SCRIPT), *map(str, arguments)], capture_output=True, text=True, check=False)

    def test_list_and_help(self):
        for option in ("--list", "--help"):
            done = self.call(option)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for key in run.LAYOUTS:
                self.assertIn(key, done.stdout)

    def test_wrong_use(self):
        for arguments in ((), ("kitti",), ("mars", self.root, "--out", self.out), ("kitti", self.root, "--fast")):
            done = self.call(*arguments)
            self.assertEqual(done.returncode, 2, arguments)

    def test_broken_input_is_one_line(self):
        for arguments, message in ((("kitti", self.top / "no", "--out", self.out), "no such folder"),
                                   (("kitti", self.root, "--out", self.root / "out"), "only read"),
                                   (("kitti", self.root, "--out", self.out), "sequences")):
            done = self.call(*arguments)
            self.assertEqual((done.returncode, done.stdout), (3, ""))
            self.assertEqual(len(done.stderr.strip().splitlines()), 1)
            self.assertIn(message, done.stderr)

    def test_scans_of_this_repository_laid_out_as_a_newer_college_sequence(self):
        """Conversion, registration and table; two pairs of data/ as consecutive scans of a drive."""
        if PROGRAM is None:
            self.skipTest("no ssfr_benchmark was named")
        with open(ROOT / "data" / "pairs.csv", newline="", encoding="utf-8") as file:
            pair = next(csv.DictReader(file))
        T = numpy.array([[float(pair[f"T{r}{c}"]) for c in range(4)] for r in range(4)])
        folder = self.root / "2024_test"
        (folder / "scans").mkdir(parents=True)
        names = [pair["source"], pair["target"], pair["target"]]
        for i, name in enumerate(names):
            (folder / "scans" / f"{i:06d}.pcd").symlink_to(ROOT / "data" / name)
        # The third scan only ends the search for a target: the first two lie near each other.
        write(folder / "poses_kitti.txt", "\n".join(row(P) for P in (T, numpy.eye(4), some_pose((50, 0, 0)))) + "\n")
        done = self.call("newer_college", self.root, "--out", self.out, "--program", PROGRAM, "--", "--no-rmse")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1 pairs of 2 scans", done.stdout)
        self.assertIn("| ssfr | 1 | 100.00 % | 1 | 0 |", done.stdout)
        self.assertIn("99.67 %", done.stdout)
        self.assertIn(done.stdout.split("\n\n")[1].strip(), (self.out / "table.md").read_text())

    def test_a_program_that_is_not_there(self):
        Drives.make_numbered(self, "a", track(16, 1.1))
        done = self.call("newer_college", self.root, "--out", self.out, "--program", self.top / "none")
        self.assertEqual(done.returncode, 3)
        self.assertIn("none: there is no such program", done.stderr)
        self.assertEqual(self.call("newer_college", self.root, "--out", self.out, "--convert-only").returncode, 0)


if __name__ == "__main__":
    if len(sys.argv) > 1 and not sys.argv[1].startswith("-") and pathlib.Path(sys.argv[1]).is_file():
        PROGRAM = sys.argv.pop(1)
    unittest.main()
