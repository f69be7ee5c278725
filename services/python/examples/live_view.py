#!/usr/bin/python3
"""The left image and the depth of the running graph, as they come.

    ./live_view.py                         # a window; Ctrl-C or closing it ends it
    ./live_view.py picture.png             # no window: the first frame as a picture

Needs python3-matplotlib.
"""
import sys
from typing import Optional

import matplotlib
import matplotlib.pyplot
import numpy

import sprout


def main(picture: Optional[str] = None) -> None:
    if picture:
        matplotlib.use("Agg")
    figure, (left, depth) = matplotlib.pyplot.subplots(1, 2, figsize=(10, 4), layout="constrained")
    left.set_axis_off()
    depth.set_axis_off()
    photo = depths = None
    for frame in sprout.listen(["left", "disparity", "rig"], timeout_s=30):
        shown = frame.left[..., ::-1] if frame.left.ndim == 3 else frame.left
        near, far = numpy.nanpercentile(frame.depth_m, (1, 99)) if numpy.isfinite(frame.depth_m).any() else (0, 1)
        if photo is None or depths is None:
            photo = left.imshow(shown, cmap="gray")
            depths = depth.imshow(frame.depth_m, cmap="turbo_r")
            figure.colorbar(depths, label="m")
        photo.set_data(shown)
        depths.set_data(frame.depth_m)
        depths.set_clim(near, far)
        depth.set_title(f"frame {frame.seq}")
        if picture:
            figure.savefig(picture)
            return
        matplotlib.pyplot.pause(0.01)
        if not matplotlib.pyplot.fignum_exists(figure.number):
            return


if __name__ == "__main__":
    try:
        main(*sys.argv[1:2])
    except KeyboardInterrupt:
        pass
