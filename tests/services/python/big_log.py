#!/usr/bin/python3
"""A log of whole frames of 2 MP, of any length: big_log.py PATH FRAMES [--read]

--read: goes through it and prints the memory that the process had at the first and the last frame.
"""
import pathlib
import sys

import numpy

import sprout
from frames import EVENT, SYNC

SIZE = (1624, 1224)


def write(path: str, frames: int) -> None:
    width, height = SIZE
    scene = sprout.Dataset(f"synthetic:{width}x{height}")[0]
    frame = sprout.Pipeline("fast").compute(scene.left, scene.right, scene.tof, scene.rig)
    counts = numpy.where(numpy.isfinite(frame.disparity), frame.disparity * 32, -32768).astype("<i2")
    with open(path, "wb") as log:
        number = 0

        def add(utime: int, channel: str, message: object) -> None:
            nonlocal number
            data, name = message.encode(), channel.encode()  # type: ignore[attr-defined]
            log.write(EVENT.pack(SYNC, number, utime, len(name), len(data)) + name + data)
            number += 1
        for seq in range(frames):
            utime = 10**15 + seq * 100000
            for channel, image in (("SPROUT_LEFT", frame.left), ("SPROUT_RIGHT", frame.right)):
                message = sprout.image_t()
                message.width, message.height = width, height
                colors = 1 if image.ndim == 2 else 3
                message.row_stride, message.size = colors * width, image.size
                message.pixel_format = message.PIXEL_FORMAT_GREY if colors == 1 else message.PIXEL_FORMAT_BGR3
                message.data = image.tobytes()
                message.header.utime, message.header.seq = utime, seq
                message.header.rig_id = frame.rig_id
                add(utime, channel, message)
            message = sprout.disparity_image_t()
            message.width, message.height = width, height
            message.header.utime, message.header.seq = utime, seq
            message.header.rig_id = frame.rig_id
            message.counts_per_px, message.invalid = 32, -32768
            message.encoding, message.size, message.data = message.ENCODING_RAW_INT16, counts.nbytes, counts.tobytes()
            add(utime, "SPROUT_DISPARITY", message)


def resident_mb() -> float:
    return int(pathlib.Path("/proc/self/status").read_text().split("VmRSS:")[1].split()[0]) / 1024


if __name__ == "__main__":
    if "--read" not in sys.argv:
        write(sys.argv[1], int(sys.argv[2]))
    else:
        number, first = 0, 0.0
        for frame in sprout.Log(sys.argv[1]).frames():
            number += 1
            if number == 100:
                first = resident_mb()
        print(f"{number} frames; {first:.1f} MB at frame 100, {resident_mb():.1f} MB at the last")
