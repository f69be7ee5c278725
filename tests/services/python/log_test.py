import pathlib
import signal
import subprocess
import sys
import time
import unittest
import warnings

import numpy

import sprout
from frames import SAMPLE, FolderTest, events, run, same, write_log


def recorded(folder: pathlib.Path, copies: int) -> pathlib.Path:
    """The sample again and again, as one long log."""
    from frames import message
    items = []
    sample = list(events(SAMPLE))
    first, last = sample[0][0], sample[-1][0]
    for copy in range(copies):
        for utime, channel, data in sample:
            if channel in ("SPROUT_LEFT", "SPROUT_RIGHT"):
                image = message("image_t").decode(data)
                image.header.seq += 1000 * copy
                image.header.utime += copy * (last - first + 100000)
                items.append((image.header.utime, channel, bytes(image.encode())))
            elif channel == "SPROUT_RIG" and copy == 0:
                items.append((utime, channel, data))
    path = folder / "long.lcm"
    write_log(path, items)
    return path


class ExportTest(FolderTest):
    def test_npz_of_a_log_has_what_its_frames_have(self) -> None:
        run("sprout-log", "export", SAMPLE, self.folder, "--npz", "--depth")
        for frame in sprout.Log(SAMPLE).frames():
            with numpy.load(self.folder / f"{frame.seq:06}_depth.npz") as arrays:
                self.assertTrue(same(arrays["depth_m"], frame.depth_m))
                self.assertTrue(same(arrays["K"], frame.intrinsics))
                self.assertTrue(same(arrays["confidence"], frame.confidence))
                given = numpy.where(numpy.isinf(arrays["disparity_px"]), numpy.nan, arrays["disparity_px"])
                self.assertTrue(same(given, frame.disparity))
                self.assertEqual((arrays["seq"], arrays["utime"]), (frame.seq, frame.utime))


class LogTest(FolderTest):
    def test_gives_the_frames_with_what_is_recorded(self) -> None:
        with sprout.Log(SAMPLE) as log:
            frames = list(log.frames())
            self.assertEqual(len(log), len(frames))
            channels = log.channels
        self.assertEqual(channels, {channel: sum(c == channel for _, c, _ in events(SAMPLE))
                                    for channel in {c for _, c, _ in events(SAMPLE)}})
        for frame in frames:
            self.assertTrue({"left", "right", "tof", "rig", "seeds", "prior", "disparity"} <= set(frame.parts))
            self.assertEqual(frame.left.shape[:2], frame.disparity.shape)
            self.assertEqual(frame.rig.rig_id, frame.rig_id)
            self.assertEqual(frame.seeds.dtype, sprout.SEED)
            self.assertGreater((frame.seeds["u"] - frame.seeds["u_right"]).min(), 0)
            self.assertEqual(frame.prior.sigma_px.shape, frame.disparity.shape)
            self.assertTrue(numpy.isfinite(frame.depth_m).any())
        self.assertEqual([f.seq for f in frames], sorted(f.seq for f in frames))

    def test_gives_no_depths_by_the_calibration_of_other_images(self) -> None:
        from frames import message
        path = self.folder / "other.lcm"
        items = []
        for utime, channel, data in events(SAMPLE):
            if channel == "SPROUT_RIG":
                rig = message("rig_t").decode(data)
                rig.width *= 2
                data = bytes(rig.encode())
            if channel in ("SPROUT_RIG", "SPROUT_DISPARITY", "SPROUT_SIGMA"):
                items.append((utime, channel, data))
        write_log(path, items)
        for frame in sprout.Log(path).frames():
            self.assertIsNotNone(frame.disparity)
            self.assertIsNone(frame.depth_m)
            self.assertIsNone(frame.depth_sigma_m)
            self.assertIsNone(frame.intrinsics)

    def test_gives_seeds_whose_bytes_are_the_same_every_time(self) -> None:
        between = numpy.ones(sprout.SEED.itemsize, bool)
        for kind, begin in ((field[0], field[1]) for field in sprout.SEED.fields.values()):
            between[begin:begin + kind.itemsize] = False
        self.assertTrue(between.any())
        for frame in sprout.Log(SAMPLE).frames():
            seeds = frame.seeds.view(numpy.uint8).reshape(len(frame.seeds), -1)
            self.assertFalse(seeds[:, between].any())

    def test_finds_frames_by_place_seq_and_time(self) -> None:
        with sprout.Log(str(SAMPLE)) as log:
            frames = list(log)
            middle = frames[len(frames) // 2]
            place = log.seek(seq=middle.seq)
            self.assertEqual(place, len(frames) // 2)
            self.assertEqual(log.seek(utime=middle.utime), place)
            self.assertEqual(log.seek(utime=middle.utime - 1), place)
            self.assertEqual(log.seek(utime=0), 0)
            self.assertTrue(same(log[place].disparity, middle.disparity))
            self.assertEqual(log[-1].seq, frames[-1].seq)
            self.assertEqual([f.seq for f in log.frames(start=place)], [f.seq for f in frames[place:]])
            self.assertEqual(log[place].parts, middle.parts)
            for wrong in (len(frames), -len(frames) - 1):
                with self.assertRaises(IndexError):
                    log[wrong]
            with self.assertRaisesRegex(KeyError, "no such frame"):
                log.seek(seq=10**9)
            with self.assertRaises(ValueError):
                log.seek()

    def test_reads_the_parts_that_are_asked_for(self) -> None:
        frames = list(sprout.Log(SAMPLE).frames(["disparity", "rig"]))
        self.assertEqual(frames[0].parts, ["rig", "disparity"])
        self.assertIsNone(frames[0].left)
        for wrong in (["dispariti"], "left", 3):
            with self.assertRaisesRegex(ValueError, "part"):
                sprout.Log(SAMPLE).frames(wrong)  # type: ignore[arg-type]

    def test_reads_compressed_maps_and_another_prefix(self) -> None:
        paths = []
        for encoding in ("RAW_INT16", "DELTA_ZSTD"):
            paths.append(self.folder / f"{encoding}.lcm")
            run("sprout-grow", "--config", "bus { disparity_encoding: %s }" % encoding, "--log-level", "error",
                "--replay", SAMPLE, "--record", paths[-1])
        self.assertLess(paths[1].stat().st_size, paths[0].stat().st_size * 0.7)
        for a, b in zip(sprout.Log(paths[0]).frames(), sprout.Log(paths[1]).frames(), strict=True):
            self.assertTrue(same(a.disparity, b.disparity))
            self.assertTrue(numpy.isfinite(a.disparity).any())
        other = self.folder / "prefix.lcm"
        write_log(other, [(utime, "B_" + channel, data) for utime, channel, data in events(SAMPLE)])
        self.assertEqual(len(sprout.Log(other, prefix="B_")), len(sprout.Log(SAMPLE)))
        self.assertEqual(len(sprout.Log(other)), 0)

    def test_goes_on_behind_damage_and_says_where_it_is(self) -> None:
        path = self.folder / "damaged.lcm"
        data = bytearray(SAMPLE.read_bytes())
        middle = data.index(b"\xed\xa1\xda\x01", len(data) // 2)
        data[middle:middle + 500] = bytes(500)
        path.write_bytes(data[:-100])
        with sprout.Log(path) as log:
            self.assertGreaterEqual(len(list(log.frames())), len(sprout.Log(SAMPLE)) - 2)
            self.assertEqual(len(log.damage), 2)
            self.assertRegex(log.damage[0], "unreadable bytes at byte")
        self.assertEqual(sprout.Log(SAMPLE).damage, [])

    def test_counts_messages_that_cannot_be_used(self) -> None:
        path = self.folder / "bad.lcm"
        items = list(events(SAMPLE))
        at = next(i for i, item in enumerate(items) if item[1] == "SPROUT_DISPARITY")
        items[at] = (items[at][0], items[at][1], items[at][2][:100])
        write_log(path, items)
        frames = sprout.Log(path).frames()
        self.assertEqual(sum("disparity" in frame.parts for frame in frames), len(sprout.Log(SAMPLE)) - 1)
        self.assertEqual(frames.bad_messages, 1)
        self.assertRegex(frames.first_bad_message, "SPROUT_DISPARITY: ")

    def test_says_what_is_no_log(self) -> None:
        with self.assertRaisesRegex(FileNotFoundError, "nowhere.lcm"):
            sprout.Log("/nowhere.lcm")
        with self.assertRaisesRegex(OSError, r"cannot be opened \(File name too long\)"):
            sprout.Log("/" + 300 * "x")
        with self.assertRaisesRegex(OSError, "README.md"):
            sprout.Log(SAMPLE.parent / "README.md")
        log = sprout.Log(SAMPLE)
        frames = log.frames()
        log.close()
        self.assertRegex(repr(log), "closed")
        for use in (log.frames, lambda: len(log), lambda: log[0], lambda: next(frames)):
            with self.assertRaisesRegex(ValueError, "closed"):
                use()

    def test_a_long_log_takes_the_memory_of_one_frame(self) -> None:
        def resident_kb() -> int:
            return int(pathlib.Path("/proc/self/status").read_text().split("VmRSS:")[1].split()[0])
        path = recorded(self.folder, 200)
        read = 0
        for frame in sprout.Log(path).frames():
            read += 1
            if read == 200:
                start = resident_kb()
        self.assertGreater(read, 900)
        # The index takes 300 bytes a frame.
        self.assertLess(resident_kb() - start, 2000 + read * 0.3)

    def test_listening_says_why_no_frame_comes(self) -> None:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                next(sprout.listen(["left"], prefix="NOBODY_", url="udpm://239.255.76.67:17667?ttl=0", timeout_s=5))
            except TimeoutError as error:
                self.assertIn("no frame within timeout_s: nothing heard on NOBODY_SPROUT_LEFT", str(error))
            except OSError:
                self.skipTest("no network here")
        self.assertEqual([str(warning.message) for warning in said][0].split(";")[0],
                         "nothing heard on NOBODY_SPROUT_LEFT")

    def test_ctrl_c_ends_reading_and_computing(self) -> None:
        programs = {
            "compute": "while True: pipeline.compute(frame.left, frame.right, frame.tof, frame.rig)",
            "read": f"while True: list(sprout.Log({str(SAMPLE)!r}).frames())",
            "listen": "next(sprout.listen(url='udpm://239.255.76.67:17667?ttl=0'))",
        }
        for what, program in programs.items():
            with self.subTest(what), subprocess.Popen(
                    [sys.executable, "-c", "import sprout\npipeline = sprout.Pipeline()\n"
                     "frame = sprout.Dataset('synthetic:64x48')[0]\n"
                     "print('ready', flush=True)\n" + program],
                    stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
                process.stdout.readline()
                time.sleep(0.3)
                process.send_signal(signal.SIGINT)
                error = process.stderr.read()
                if "OSError" in error and what == "listen":
                    continue  # no network here
                self.assertIn("KeyboardInterrupt", error)
                self.assertEqual(process.wait(20), -signal.SIGINT)


if __name__ == "__main__":
    unittest.main()
