"""What several tests need: frames, logs, programs."""
import os
import pathlib
import struct
import subprocess
import tempfile
import unittest
from typing import Any, Dict, Iterator, List, Optional, Tuple

import numpy

import sprout

SOURCE = pathlib.Path(__file__).resolve().parents[3]
BIN = pathlib.Path(os.environ.get("SPROUT_BINARY_DIR", SOURCE / "build" / "release" / "bin"))
SAMPLE = SOURCE / "logs" / "sample.lcm"
PRESETS = ("default", "fast", "paper")

EVENT = struct.Struct(">IqqII")
SYNC = 0xEDA1DA01


class FolderTest(unittest.TestCase):
    """Each test has a folder of its own."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


def synthetic(size: str = "64x48", tof: str = "grid", number: int = 0) -> sprout.Frame:
    return sprout.Dataset(f"synthetic:{size}?tof={tof}")[number]


def compute(pipeline: sprout.Pipeline, frame: sprout.Frame, **time: Any) -> sprout.Frame:
    return pipeline.compute(frame.left, frame.right, frame.tof, frame.rig, **time)


def events(path: pathlib.Path) -> Iterator[Tuple[int, str, bytes]]:
    data = path.read_bytes()
    at = 0
    while at < len(data):
        _, _, utime, channel_length, length = EVENT.unpack_from(data, at)
        at += EVENT.size
        channel = data[at:at + channel_length].decode()
        at += channel_length
        yield utime, channel, data[at:at + length]
        at += length


def write_log(path: pathlib.Path, items: List[Tuple[int, str, bytes]]) -> None:
    with open(path, "wb") as log:
        for number, (utime, channel, data) in enumerate(items):
            name = channel.encode()
            log.write(EVENT.pack(SYNC, number, utime, len(name), len(data)) + name + data)


def run(program: str, *arguments: Any, expect: int = 0) -> str:
    done = subprocess.run([BIN / program, *map(str, arguments)], capture_output=True, text=True,
                          timeout=300)
    assert done.returncode == expect, (program, arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def same(a: Optional[numpy.ndarray], b: Optional[numpy.ndarray]) -> bool:
    """Equal to the byte, NaN for NaN."""
    if a is None or b is None:
        return a is b
    if a.dtype.names:  # between the fields there may be anything
        return a.dtype == b.dtype and numpy.array_equal(a, b)
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def message(name: str) -> Any:
    return getattr(sprout, name)


def environment(**more: str) -> Dict[str, str]:
    return {**os.environ, **more}


def without_points(data: bytes) -> bytes:
    tof = message("tof_image_t").decode(data)
    tof.width = tof.height = tof.count = tof.amplitude_count = 0
    tof.depth_m, tof.amplitude = [], []
    return bytes(tof.encode())
