#!/usr/bin/python3
"""Depth of every frame of a log as a NumPy archive.

    ./log_to_npz.py run.lcm run.npz

Arrays: utime (N,) us, seq (N,), depth_m (N, H, W) float32 with NaN for none, K (3, 3).
"""
import sys

import numpy

import sprout


def main(path: str, archive: str) -> None:
    utimes, numbers, depths, intrinsics = [], [], [], None
    with sprout.Log(path) as log:
        for frame in log.frames(["disparity", "rig"]):
            if frame.depth_m is None:
                continue  # a recording that began within a frame
            utimes.append(frame.utime)
            numbers.append(frame.seq)
            depths.append(frame.depth_m)
            intrinsics = frame.intrinsics
        for damage in log.damage:
            print(f"{path}: {damage}", file=sys.stderr)
    if intrinsics is None:
        sys.exit(f"{path}: no frame with SPROUT_DISPARITY and SPROUT_RIG")
    numpy.savez_compressed(archive, utime=utimes, seq=numbers, depth_m=depths, K=intrinsics)
    print(f"{archive}: {len(depths)} frames")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
