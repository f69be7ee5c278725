import pathlib
import threading
import time
import unittest
from typing import List, Tuple

import numpy

import sprout
from frames import (BIN, PRESETS, SAMPLE, FolderTest, compute, events, message, run, same, synthetic, without_points,
                    write_log)


def as_grey(data: bytes) -> bytes:
    image = message("image_t").decode(data)
    if image.pixel_format == image.PIXEL_FORMAT_GREY:
        return data
    pixels = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.row_stride // 3, 3)
    image.data = pixels.mean(axis=2).astype(numpy.uint8).tobytes()
    image.pixel_format, image.row_stride = image.PIXEL_FORMAT_GREY, image.row_stride // 3
    image.size = len(image.data)
    return bytes(image.encode())


class DepthSettingsTest(unittest.TestCase):
    def test_depth_settings_leave_out_of_depths_and_points(self) -> None:
        frame = synthetic("96x72")
        whole = compute(sprout.Pipeline("default"), frame)
        limit = float(numpy.nanmedian(whole.depth_m))
        near = compute(sprout.Pipeline("default", f"depth {{ max_m: {limit} }}"), frame)
        kept = whole.depth_m <= limit
        self.assertTrue(same(near.depth_m, numpy.where(kept, whole.depth_m, numpy.float32("nan"))))
        self.assertEqual(len(near.points()), int(kept.sum()))
        self.assertTrue(same(near.disparity, whole.disparity))
        with self.assertRaisesRegex(ValueError, "depth.box"):
            sprout.Pipeline("default", "depth { box { max_z_m: 2 } }")


class BytesTest(FolderTest):
    """Against sprout-pipeline --replay, which gives the bytes of the three processes."""

    def variants(self) -> List[Tuple[str, pathlib.Path]]:
        made = []
        for color in (True, False):
            for points in (True, False):
                items = []
                for utime, channel, data in events(SAMPLE):
                    if channel in ("SPROUT_LEFT", "SPROUT_RIGHT") and not color:
                        data = as_grey(data)
                    if channel == "SPROUT_TOF" and not points:
                        data = without_points(data)
                    if channel in ("SPROUT_LEFT", "SPROUT_RIGHT", "SPROUT_TOF", "SPROUT_RIG"):
                        items.append((utime, channel, data))
                path = self.folder / f"{color}_{points}.lcm"
                write_log(path, items)
                made.append((f"colour {color}, ToF {points}", path))
        return made

    def test_compute_gives_the_bytes_of_the_replay(self) -> None:
        for what, path in self.variants():
            for preset in PRESETS:
                answers = self.folder / "answers.lcm"
                # Only preset default has seeds without range points; without seeds maps are empty.
                is_empty = "ToF False" in what and preset != "default"
                run("sprout-pipeline", "--config", preset, "--log-level", "error", "--replay", path,
                    "--record", answers, expect=1 if is_empty else 0)
                self.compare(what + ", " + preset, sprout.Pipeline(preset), path, answers)

    def compare(self, what: str, pipeline: sprout.Pipeline, inputs: pathlib.Path,
                answers: pathlib.Path) -> None:
        frames = 0
        for given, expected in zip(sprout.Log(inputs).frames(), sprout.Log(answers).frames()):
            self.assertEqual((given.seq, given.utime), (expected.seq, expected.utime))
            frame = compute(pipeline, given)
            self.assertTrue(same(frame.disparity, expected.disparity), what)
            self.assertTrue(same(frame.confidence, expected.confidence), what)
            self.assertTrue(same(frame.seeds, expected.seeds), what)
            self.assertTrue(same(frame.left_seeds, expected.left_seeds), what)
            self.assertEqual(frame.seed_counts, expected.seed_counts)
            if frame.prior is not None and expected.prior is not None:
                self.assertTrue(same(frame.prior.disparity, expected.prior.disparity), what)
                self.assertTrue(same(frame.prior.sigma_px, expected.prior.sigma_px), what)
            rig = given.rig
            z = rig.focal_px * rig.baseline_m / (frame.disparity.astype(float) + rig.cx_right - rig.cx)
            self.assertTrue(same(numpy.where(z > 0, z, numpy.nan).astype(numpy.float32), frame.depth_m))
            self.assertEqual(frame.depth_sigma_m is None, frame.sigma_px is None)
            if frame.sigma_px is not None:
                known = (z > 0) & (frame.sigma_px < 15.9)
                numpy.testing.assert_allclose(
                    frame.depth_sigma_m[known],
                    (z**2 / (rig.focal_px * rig.baseline_m) * frame.sigma_px)[known], rtol=1e-6)
                numpy.testing.assert_array_equal(numpy.isnan(frame.depth_sigma_m), numpy.isnan(frame.depth_m))
            frames += int(numpy.isfinite(frame.disparity).any())
        # Presets without stereo seeds have nothing to grow from when there is no range image.
        if "ToF True" in what or "default" in what:
            self.assertGreaterEqual(frames, 3, what)

    def test_a_memory_goes_on_from_frame_to_frame_of_a_data_set(self) -> None:
        scenes = sprout.Dataset("synthetic:160x120?tof=grid", sprout.Config("capture { rate_hz: 4 }"))
        pipeline = sprout.Pipeline("default", "temporal { in_pipeline: true }")
        frames = [scenes[number] for number in range(3)]
        self.assertEqual([frame.utime for frame in frames], [250000, 500000, 750000])
        resets = [compute(pipeline, frame, seq=frame.seq, utime=frame.utime).motion.reset for frame in frames]
        self.assertEqual(resets, ["FIRST", "NONE", "NONE"])
        slow = sprout.Dataset("synthetic:64x48", sprout.Config("capture { rate_hz: 1e-300 }"))
        self.assertEqual(slow[1].utime, 9 * 10**18)

    def test_fused_maps_and_motions_have_the_bytes_of_sprout_temporal(self) -> None:
        config = ("default", "temporal { in_pipeline: true }")
        pipeline, of_fused = sprout.Pipeline(*config), sprout.Pipeline(*config, "depth { input: FUSED }")
        chain, answers = self.folder / "chain.lcm", self.folder / "answers.lcm"
        run("sprout-pipeline", "--config", "default", "--log-level", "error", "--replay", SAMPLE,
            "--record", chain)
        run("sprout-temporal", "--config", "default", "--log-level", "error", "--replay", SAMPLE,
            "--replay", chain, "--record", answers)
        frames = list(sprout.Log(SAMPLE).frames())
        self.assertGreaterEqual(len(frames), 3)
        for number, (given, expected) in enumerate(zip(frames, sprout.Log(answers).frames())):
            frame = compute(pipeline, given, seq=given.seq, utime=given.utime)
            self.assertEqual((frame.seq, frame.utime), (expected.seq, expected.utime))
            self.assertTrue(same(frame.fused, expected.fused))
            self.assertTrue(same(frame.fused_confidence, expected.fused_confidence))
            for field in ("last_from_left", "start_from_left", "covariance"):
                self.assertTrue(same(getattr(frame.motion, field), getattr(expected.motion, field)))
            for field in ("last_seq", "start_seq", "tracked", "inliers", "reset", "resets"):
                self.assertEqual(getattr(frame.motion, field), getattr(expected.motion, field))
            self.assertEqual(frame.motion.reset == "FIRST", number == 0)
            self.assertEqual(same(frame.fused, frame.disparity), number == 0)
            other = compute(of_fused, given, seq=given.seq, utime=given.utime)
            z = given.rig.focal_px * given.rig.baseline_m / (
                frame.fused.astype(float) + given.rig.cx_right - given.rig.cx)
            z = numpy.where(z > 0, z, numpy.nan).astype(numpy.float32)
            self.assertTrue(same(other.depth_m, z))
            self.assertEqual(len(other.points()), numpy.isfinite(z).sum())
        # Frames need no numbers; reset() forgets earlier ones.
        pipeline.reset()
        first, second = compute(pipeline, frames[0]), compute(pipeline, frames[1])
        self.assertEqual((first.motion.reset, second.motion.reset), ("FIRST", "NONE"))
        self.assertTrue(same(first.fused, first.disparity))
        with self.assertRaisesRegex(ValueError, "seq, utime: expected both or neither"):
            compute(pipeline, frames[2], seq=3)
        with self.assertRaisesRegex(ValueError, r"time.utime: -1; allowed: 0 to 2\^62"):
            compute(pipeline, frames[2], seq=3, utime=-1)
        # The given poses are the measured ones, in another frame.
        given = sprout.Pipeline(*config, "temporal { motion: CHANNEL }")
        world = numpy.array([[0, 0, 1, 7], [0, 1, 0, 0], [-1, 0, 0, 2], [0, 0, 0, 1]], float)
        pipeline.reset()
        for number, frame in enumerate(frames):
            measured = compute(pipeline, frame, seq=number, utime=100_000 * number).motion
            told = compute(given, frame, seq=number, utime=100_000 * number,
                           pose=world @ measured.start_from_left).motion
            self.assertEqual((told.reset, told.tracked), (measured.reset, 0))
            numpy.testing.assert_allclose(told.start_from_left, measured.start_from_left, atol=1e-9)
        self.assertEqual(compute(given, frames[0], seq=99, utime=1_000_000).motion.reset, "GAP")
        self.assertEqual(compute(given, frames[0], seq=100, utime=1_000_001).motion.reset, "FEW_POINTS")
        for pose, text in ((numpy.eye(3), r"pose: expected float64 array of shape \(4, 4\), given"),
                           (2 * numpy.eye(4), r"pose: expected a rotation R.* given array\(\[\[2., 0., 0., 0.\], \[0., 2."), ("here", "pose: expected")):
            with self.assertRaisesRegex(ValueError, text):
                compute(given, frames[0], seq=101, utime=1_000_002, pose=pose)
        with self.assertRaisesRegex(ValueError, "pose: expected with seq and utime"):
            compute(given, frames[0], pose=world)
        for unused in (pipeline, sprout.Pipeline("default", "temporal { motion: CHANNEL }")):
            with self.assertRaisesRegex(ValueError, "time.pose: given, but the configuration does not use it"):
                compute(unused, frames[0], seq=101, utime=1_000_002, pose=world)
        without = compute(sprout.Pipeline("default"), frames[0])
        self.assertEqual((without.fused, without.fused_confidence, without.motion), (None, None, None))

    def test_depth_is_that_of_sprout_depth(self) -> None:
        answers = self.folder / "depth.lcm"
        run("sprout-depth", "--config", "depth { mm_per_count: 1 scale: 1 }", "--log-level", "error",
            "--replay", SAMPLE, "--record", answers)
        for given, expected in zip(sprout.Log(SAMPLE).frames(), sprout.Log(answers).frames()):
            near = given.depth_m < 65.5
            numpy.testing.assert_allclose(given.depth_m[near], expected.depth_m[near], atol=0.000501)
            numpy.testing.assert_allclose(given.intrinsics, expected.intrinsics)

    def test_sigma_of_depth_is_that_of_sprout_depth(self) -> None:
        run("sprout-pipeline", "--config", "default", "--log-level", "error", "--replay", SAMPLE,
            "--record", self.folder / "maps.lcm")
        run("sprout-log", "cut", SAMPLE, self.folder / "images.lcm", "--channels", "SPROUT_LEFT,SPROUT_RIG")
        run("sprout-log", "merge", self.folder / "images.lcm", self.folder / "maps.lcm", "--out",
            self.folder / "all.lcm")
        run("sprout-depth", "--config", "depth { publish_sigma: true }", "--log-level", "error",
            "--replay", self.folder / "all.lcm", "--record", self.folder / "depth.lcm")
        frames = 0
        for given, expected in zip(sprout.Log(self.folder / "all.lcm").frames(),
                                   sprout.Log(self.folder / "depth.lcm").frames()):
            self.assertIn("depth_sigma", expected.parts)
            near = given.depth_m < 65.5
            low = near & (given.depth_sigma_m < 4)
            numpy.testing.assert_allclose(given.depth_sigma_m[low], expected.depth_sigma_m[low], atol=0.0000626)
            self.assertTrue((expected.depth_sigma_m[near & ~low] > 3.99).all())
            frames += int(low.any())
        self.assertGreaterEqual(frames, 3)


class ThreadTest(unittest.TestCase):
    def test_others_run_while_it_computes_and_the_same_pipeline_is_refused(self) -> None:
        frame = synthetic("1624x1224")
        pipeline = sprout.Pipeline("default")
        started = threading.Event()
        done: List[sprout.Frame] = []

        def work() -> None:
            started.set()
            done.append(compute(pipeline, frame))
        thread = threading.Thread(target=work)
        thread.start()
        started.wait()
        time.sleep(0.02)
        self.assertFalse(done, "too fast a machine: make the image larger")
        with self.assertRaisesRegex(RuntimeError, "Pipeline: in use by another thread"):
            compute(pipeline, frame)
        ticks = 0
        while thread.is_alive() and ticks < 50:
            ticks += 1
            time.sleep(0)
        self.assertEqual(ticks, 50, "the interpreter's lock is held")
        thread.join()
        self.assertTrue(same(compute(pipeline, frame).disparity, done[0].disparity))

    def test_two_pipelines_in_two_threads_give_the_same(self) -> None:
        scenes = [synthetic("128x96", number=i) for i in range(4)]
        expected = [compute(sprout.Pipeline(), scene).disparity for scene in scenes]
        wrong: List[int] = []

        def work() -> None:
            pipeline = sprout.Pipeline()
            for i in range(8):
                if not same(compute(pipeline, scenes[i % 4]).disparity, expected[i % 4]):
                    wrong.append(i)
        threads = [threading.Thread(target=work) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])


class FrameTest(FolderTest):
    def test_has_points_colours_and_a_ply_of_them(self) -> None:
        scene = synthetic("64x48")
        frame = compute(sprout.Pipeline(), scene)
        points, colors = frame.points(colors=True)
        seen = numpy.isfinite(frame.depth_m)
        self.assertEqual(points.shape, (seen.sum(), 3))
        numpy.testing.assert_array_equal(points[:, 2], frame.depth_m[seen])
        numpy.testing.assert_array_equal(colors.reshape(-1, 3)[:, 0],
                                         (frame.left if frame.left.ndim == 2 else frame.left[..., 0])[seen])
        v, u = numpy.nonzero(seen)
        numpy.testing.assert_allclose(points[:, 0], (u - frame.rig.cx) * points[:, 2] / frame.rig.focal_px,
                                      rtol=1e-5, atol=1e-6)
        self.assertTrue(same(frame.points(), points))
        path = self.folder / "cloud.ply"
        frame.write_ply(path)
        self.assertIn(f"element vertex {len(points)}".encode(), path.read_bytes())
        frame.write_ply(str(path), mesh=True)
        self.assertIn(b"element face", path.read_bytes())
        with self.assertRaisesRegex(OSError, "nowhere"):
            frame.write_ply("/nowhere/cloud.ply")

    def test_says_that_there_is_nothing(self) -> None:
        scene = synthetic()
        with self.assertRaisesRegex(ValueError, "no disparity map"):
            scene.points()
        self.assertIsNone(scene.depth_m)
        blind = sprout.Pipeline("fast").compute(scene.left, scene.right, None, scene.rig)
        self.assertRegex(" ".join(blind.warnings), "refine: ")
        self.assertFalse(numpy.isfinite(blind.depth_m).any())

    def test_says_how_far_the_range_sensor_is_off(self) -> None:
        scene = synthetic("640x480")
        right = sprout.Pipeline().compute(scene.left, scene.right, scene.tof, scene.rig)
        self.assertEqual(right.range_error, "")
        off = sprout.Tof(scene.tof.depth_m + 0.1, scene.tof.amplitude)
        told = sprout.Pipeline().compute(scene.left, scene.right, off, scene.rig).range_error
        self.assertRegex(told, r"^depths of the range sensor are off by \+\d")

    @unittest.skipUnless((BIN / "sprout-evaluate").exists(), "built without SPROUT_EVALUATE")
    def test_is_evaluated_as_sprout_evaluate_does(self) -> None:
        import json
        path = self.folder / "result.json"
        run("sprout-evaluate", "scenes", "synthetic:128x96", "--tof", "grid:10", "--json", path)
        methods = json.loads(path.read_text())["scenes"][0]["methods"]
        scene = synthetic("128x96")
        frame = compute(sprout.Pipeline("default"), scene)
        whole = next(method for method in methods if "confidence" in method)
        score = sprout.evaluate(frame.disparity, scene.truth, right_truth=scene.right_truth,
                                confidence=frame.confidence)
        for name, value in whole["nonocc"].items():
            self.assertAlmostEqual(getattr(score, name), value, 9, name)
        self.assertAlmostEqual(score.confidence_area, whole["confidence"]["area"], 9)
        self.assertEqual(score.confidence_bad1, whole["confidence"]["bad1"])
        everything = sprout.evaluate(frame.disparity, scene.truth, mask=numpy.ones((96, 128), bool))
        self.assertAlmostEqual(everything.correct_le1, whole["all"]["correct_le1"], 9)


if __name__ == "__main__":
    unittest.main()
