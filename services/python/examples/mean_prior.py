#!/usr/bin/python3
"""A stage of the graph in Python: a prior as simple as can be, in the place of sprout-prior.

    ./mean_prior.py                                        # beside sprout-refine and sprout-grow
    ./mean_prior.py --replay run.lcm --record prior.lcm    # over a log
    scripts/check_stage prior -- ./mean_prior.py           # is it one?
"""
import numpy

import sprout


@sprout.stage("prior")
def my_prior(frame: sprout.Frame, config: sprout.Config) -> object:
    """The mean disparity of the seeds, everywhere."""
    if len(frame.seeds) == 0:
        return "no seeds"
    disparity = (frame.seeds["u"] - frame.seeds["u_right"]).astype(numpy.float64)
    if abs(disparity.mean()) > 1023:
        return "the seeds' mean is more than a map can hold"
    return sprout.PriorMap(numpy.full(frame.left.shape[:2], disparity.mean()), max(disparity.std(), 0.1))


if __name__ == "__main__":
    sprout.run()
