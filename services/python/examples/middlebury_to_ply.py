#!/usr/bin/python3
"""A Middlebury scene to a coloured point cloud, and how good its disparities are.

    ./middlebury_to_ply.py FOLDER cloud.ply [PRESET]

FOLDER has a scene of 2005, 2006 or 2014. A coarse ToF camera (SR4000) is made up from the ground truth.
"""
import sys

import sprout


def main(folder: str, cloud: str, preset: str = "default") -> None:
    scene = sprout.Dataset(f"middlebury:{folder}?tof=sr4000")[0]
    frame = sprout.Pipeline(preset).compute(scene.left, scene.right, scene.tof, scene.rig)
    frame.write_ply(cloud)
    print(f"{cloud}: {len(frame.points())} points")
    print(sprout.evaluate(frame.disparity, scene.truth, scene.right_truth, scene.nonoccluded,
                          confidence=frame.confidence))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
