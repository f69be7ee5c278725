#!/usr/bin/env python3
"""Prints how far away the middle of every depth image of a log is.

    lcm-gen --python --ppath generated /usr/local/share/lcmtypes/*.lcm
    PYTHONPATH=generated ./read_log.py LOG

Needs nothing but the classes that lcm-gen writes; Debian 12 has no LCM module for Python.
"""
import struct
import sys

from sprout import depth_image_t

EVENT = struct.Struct(">IqqII")  # sync word, number, time (us), lengths of channel and data
SYNC = 0xEDA1DA01


def events(path):
    """Channel and data of every event; a damaged log ends the program."""
    with open(path, "rb") as log:
        while head := log.read(EVENT.size):
            if len(head) < EVENT.size:
                sys.exit(f"{path}: ends inside an event")
            sync, _, _, channel_length, data_length = EVENT.unpack(head)
            if sync != SYNC:
                sys.exit(f"{path}: no event at byte {log.tell() - EVENT.size}")
            channel, data = log.read(channel_length), log.read(data_length)
            if len(data) < data_length:
                sys.exit(f"{path}: ends inside an event")
            yield channel.decode(), data


if len(sys.argv) != 2:
    sys.exit(__doc__)
for channel, data in events(sys.argv[1]):
    if not channel.endswith("SPROUT_DEPTH"):
        continue
    try:
        image = depth_image_t.decode(data)
    except ValueError:
        sys.exit(f"{channel}: no depth_image_t; a compressed log has to be expanded (sprout-log expand)")
    pixel = image.height // 2 * image.width + image.width // 2
    (count,) = struct.unpack_from("<H", image.depth, 2 * pixel)
    print(f"frame {image.header.seq}:", f"{count * image.metres_per_count:.6g} m" if count else "no depth")
