"""refine and grow by another pipeline, and what goes wrong: my_stages.py STAGE FLAGS..."""
import sys
from typing import Any, Dict

import sprout

pipeline = sprout.Pipeline("default")


@sprout.stage("refine")
def my_refine(frame: sprout.Frame, config: sprout.Config) -> Any:
    seeds = pipeline.compute(frame.left, frame.right, frame.tof, frame.rig).seeds
    if "fast" in sys.argv and frame.seq % 2:
        seeds["u"][3] = float("nan")
    return seeds


@sprout.stage("grow", inputs=["left", "right", "tof", "rig"])
def my_grow(frame: sprout.Frame, config: sprout.Config) -> Dict[str, Any]:
    if "fast" in sys.argv and frame.seq % 2:
        raise RuntimeError("odd frames are too much")
    seen = pipeline.compute(frame.left, frame.right, frame.tof, frame.rig)
    return {"disparity": seen.disparity, "confidence": seen.confidence}


if __name__ == "__main__":
    sprout.run(sys.argv[1], sys.argv[2:])
