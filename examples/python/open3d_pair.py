# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""Two files through Open3D: read, registered, written as one cloud and drawn from above.

Usage: python3 open3d_pair.py SOURCE TARGET OUT.ply OUT.png     (Debian: python3-open3d)
"""

import sys

import numpy as np
import open3d as o3d

import pcl_ssfr

WIDTH = 1200  # of the picture [pixels]
ORANGE, BLUE = (0.85, 0.45, 0.0), (0.0, 0.35, 0.75)


def draw(clouds, path):
    """The clouds from above, each in its colour: darker where more points lie."""
    points = np.vstack([np.asarray(cloud.points) for cloud in clouds])
    low, high = np.percentile(points[:, :2], (1, 99), axis=0)  # far returns would make the picture small
    low, high = low - 0.05 * (high - low), high + 0.05 * (high - low)
    scale = (WIDTH - 1) / (high - low).max()
    columns, rows = (np.ceil((high - low) * scale).astype(int) + 1).tolist()
    picture = np.ones((rows, columns, 3))
    for cloud in clouds:
        pixels = ((np.asarray(cloud.points)[:, :2] - low) * scale).round().astype(int)
        inside = ((pixels >= 0) & (pixels < (columns, rows))).all(axis=1)
        counts = np.zeros((rows, columns))
        np.add.at(counts, (rows - 1 - pixels[inside, 1], pixels[inside, 0]), 1)
        ink = np.minimum(1, counts / max(1, np.percentile(counts[counts > 0], 80)))[..., None]
        picture *= 1 - ink * (1 - np.asarray(cloud.colors)[0])
    o3d.io.write_image(path, o3d.geometry.Image(np.ascontiguousarray((255 * picture).astype(np.uint8))))


def main(source_path, target_path, cloud_path, picture_path):
    source, target = o3d.io.read_point_cloud(source_path), o3d.io.read_point_cloud(target_path)
    result = pcl_ssfr.register_scans(np.asarray(source.points), np.asarray(target.points))
    print(f"{result.status}, confidence {result.confidence:.3f}: {result.message}")
    if not result.converged:
        return 1
    source.transform(result.T_target_source)
    source.paint_uniform_color(ORANGE)
    target.paint_uniform_color(BLUE)
    o3d.io.write_point_cloud(cloud_path, source + target)
    draw([target, source], picture_path)
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
