"""Depth maps from a range image and a stereo pair.

    import sprout

    pipeline = sprout.Pipeline("default")
    frame = pipeline.compute(left, right, tof, rig)    # NumPy in, NumPy out
    frame.depth_m, frame.disparity, frame.confidence, frame.points(colors=True)

    with sprout.Log("run.lcm") as log:                 # what the graph recorded
        for frame in log.frames():
            ...

    for frame in sprout.listen(["left", "disparity"]):  # the running graph
        ...

    @sprout.stage("prior")                             # a stage of the graph, in Python
    def my_prior(frame, config):
        return sprout.PriorMap(disparity, sigma_px)

    if __name__ == "__main__":
        sprout.run()

Seeds are arrays of SEED: u, v in the left image and u_right (px), sigma_px of the disparity u - u_right,
origin (0: range camera, 1: stereo), tof_u, tof_v (pixel of the range image; -1: none).

Images are uint8, (H, W) or (H, W, 3) BGR; disparities px, depths m, float32, NaN where there is none.
"""
import importlib
import os
import pkgutil
import sys
from typing import Any, Callable, Dict, List, NoReturn, Optional, Sequence, Tuple, TypeVar

from ._sprout import (
    SEED,
    Config,
    Dataset,
    Evaluation,
    Finding,
    Frame,
    Listener,
    Log,
    LogFrames,
    Motion,
    Pipeline,
    PriorMap,
    Rectifier,
    Rig,
    Tof,
    TofCamera,
    Zones,
    __version__,
    _run_stage,
    check_inputs,
    evaluate,
    listen,
    set_threads,
)

__all__ = [
    "SEED",
    "Config",
    "Dataset",
    "Evaluation",
    "Finding",
    "Frame",
    "Listener",
    "Log",
    "LogFrames",
    "Motion",
    "Pipeline",
    "PriorMap",
    "Rectifier",
    "Rig",
    "Tof",
    "TofCamera",
    "Zones",
    "__version__",
    "check_inputs",
    "evaluate",
    "listen",
    "run",
    "set_threads",
    "stage",
]

_Stage = Callable[[Frame, Config], Any]
_S = TypeVar("_S", bound=_Stage)
_stages: Dict[str, Tuple[_Stage, Optional[Sequence[str]]]] = {}


def stage(name: str, inputs: Optional[Sequence[str]] = None) -> Callable[[_S], _S]:
    """Makes a function a stage of the graph: refine, prior or grow.

    It is called with each frame that has what the stage joins, and the configuration, and gives the
    stage's answer: refine an array of SEED, prior a PriorMap, grow a disparity map ((H, W) float32, px,
    NaN: none); or a dict of several parts by their names, {"disparity": ..., "confidence": ...}; or a
    str, which says why there is nothing to give: the answer is empty then. The same frame must get the
    same answer. An exception, or an answer with a disparity far below that of infinity (mostly 0) or from
    the image's width on, costs the frame, is counted and in the status, and the stage goes on.

    inputs: names of the parts that it joins; None: as the C++ stage with the same configuration.
    """
    if name not in ("refine", "prior", "grow"):
        raise ValueError(f"stage: expected refine, prior or grow, given {name!r}")

    def register(function: _S) -> _S:
        _stages[name] = (function, inputs)
        return function

    return register


def run(name: Optional[str] = None, arguments: Optional[List[str]] = None) -> NoReturn:
    """Runs a stage that stage() made, live or over logs, with the flags of every stage.

    --config, --replay, --record, --frames, --channel-prefix, --lcm-url, ...: --help has all. Ends the
    program with the exit code of a stage.

    name: which one, when there are several. arguments: instead of those of the program.
    """
    if name is None and len(_stages) == 1:
        (name,) = _stages
    if name is None or name not in _stages:
        known = ", ".join(_stages) or "none"
        raise ValueError(f"run: expected the name of a stage of this program ({known}), given {name!r}")
    function, inputs = _stages[name]
    given = sys.argv if arguments is None else [sys.argv[0], *arguments]
    description = function.__doc__ or f"The stage {name} in Python."
    sys.exit(_run_stage(name, function, inputs, description, [os.fsencode(a) for a in given]))


def _load_message_types() -> None:
    """What lcm-gen --python made lies beside this file; as its own package has it: sprout.header_t."""
    for found in pkgutil.iter_modules(__path__):
        if found.name.endswith("_t"):
            message = importlib.import_module("." + found.name, __name__)
            globals()[found.name] = getattr(message, found.name)


_load_message_types()
