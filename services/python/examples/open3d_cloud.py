#!/usr/bin/python3
"""Depth into Open3D: a point cloud from a frame's depth, colours and intrinsics.

    ./open3d_cloud.py run.lcm cloud.pcd    # the last frame of a log

Needs python3-open3d.
"""
import sys

import numpy
import open3d

import sprout


def main(path: str, cloud: str) -> None:
    with sprout.Log(path) as log:
        frame = log[-1]
    rig = frame.rig
    color = numpy.dstack([frame.left] * 3) if frame.left.ndim == 2 else frame.left[..., ::-1]
    rgbd = open3d.geometry.RGBDImage.create_from_color_and_depth(
        open3d.geometry.Image(numpy.ascontiguousarray(color)),
        open3d.geometry.Image(numpy.nan_to_num(frame.depth_m)),  # 0: none
        depth_scale=1.0, depth_trunc=1e4, convert_rgb_to_intensity=False)
    camera = open3d.camera.PinholeCameraIntrinsic(
        rig.width, rig.height, rig.focal_px, rig.focal_px, rig.cx, rig.cy)
    points = open3d.geometry.PointCloud.create_from_rgbd_image(rgbd, camera)
    open3d.io.write_point_cloud(cloud, points)
    print(f"{cloud}: {len(points.points)} points")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
