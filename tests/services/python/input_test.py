import gc
import os
import pathlib
import sys
import unittest
from typing import Any, Callable, List, Tuple

import numpy

import sprout
from frames import FolderTest, same, synthetic

# (what is wrong, how it is called, what the message must say beside the argument's name)
Wrong = Tuple[str, Callable[[sprout.Pipeline, sprout.Frame], Any], str]


def call(**wrong: Any) -> Callable[[sprout.Pipeline, sprout.Frame], Any]:
    def compute_with(pipeline: sprout.Pipeline, frame: sprout.Frame) -> Any:
        arguments = {"left": frame.left, "right": frame.right, "tof": frame.tof, "rig": frame.rig}
        arguments.update(wrong)
        return pipeline.compute(**arguments)
    return compute_with


def zeros(*shape: int, dtype: Any = numpy.uint8) -> Any:
    return numpy.zeros(shape, dtype)


GREY = r"uint8 or uint16 array of shape \(48, 64\) or \(48, 64, 3\)"
RANGE = r"float32 \(m\) or uint16 \(mm\) array of shape \(48, 64\)"
MAP = numpy.zeros((4, 5), numpy.float32)
VIEWS = numpy.tile(numpy.array([-1, 1, -1, 1], numpy.float32), (4, 5, 1))
SEEDS = zeros(2, dtype=sprout.SEED)
WRONG: List[Wrong] = [
    ("left is None", call(left=None), "left: expected " + GREY + ", given None"),
    ("left is a list", call(left=[[1, 2]]), "left: expected " + GREY + ", given list"),
    ("left is a str", call(left="left.png"), "left: .* given str 'left.png'"),
    ("left is too small", call(left=zeros(24, 32)), r"left: .* given uint8 array of shape \(24, 32\)"),
    ("left is turned", call(left=zeros(64, 48)), r"left: .* given uint8 array of shape \(64, 48\)"),
    ("left has an alpha", call(left=zeros(48, 64, 4)), r"left: .* given uint8 array of shape \(48, 64, 4\)"),
    ("left has two channels", call(left=zeros(48, 64, 2)), r"left: .*\(48, 64, 2\)"),
    ("left is channels first", call(left=zeros(3, 48, 64)), r"left: .*\(3, 48, 64\)"),
    ("left is a batch", call(left=zeros(1, 48, 64, 3)), r"left: .*\(1, 48, 64, 3\)"),
    ("left is a row", call(left=zeros(48 * 64)), r"left: .*\(3072,\)"),
    ("left is empty", call(left=zeros(0, 0)), r"left: .*\(0, 0\)"),
    ("left is a number", call(left=numpy.array(3, numpy.uint8)), r"left: .* of shape \(\)"),
    ("left is float32", call(left=zeros(48, 64, dtype="f4")), "left: .* given float32 array"),
    ("left is float64", call(left=zeros(48, 64, dtype="f8")), "left: .* given float64 array"),
    ("left is uint32", call(left=zeros(48, 64, dtype="u4")), "left: .* given uint32 array"),
    ("left is int8", call(left=zeros(48, 64, dtype="i1")), "left: .* given int8 array"),
    ("left is bool", call(left=zeros(48, 64, dtype="?")), "left: .* given bool array"),
    ("left is of objects", call(left=zeros(48, 64, dtype="O")), "left: .* given object array"),
    ("left is complex", call(left=zeros(48, 64, dtype="c8")), "left: .* given complex64 array"),
    ("right is None", call(right=None), "right: expected " + GREY + ", given None"),
    ("right is too wide", call(right=zeros(48, 65)), r"right: .*\(48, 65\)"),
    ("right is float32", call(right=zeros(48, 64, dtype="f4")), "right: .* given float32"),
    ("tof is a str", call(tof="tof"), "tof: .* given str"),
    ("tof is a number", call(tof=3.0), "tof: .* given float"),
    ("tof is too small", call(tof=zeros(4, 5, dtype="f4")), r"tof: expected .* given float32 array of shape \(4, 5\)"),
    ("tof is uint8", call(tof=zeros(48, 64)), "tof: expected .*float32 .m. or uint16 .mm.* given uint8"),
    ("tof is int32", call(tof=zeros(48, 64, dtype="i4")), "tof: .* given int32"),
    ("tof is int16", call(tof=zeros(48, 64, dtype="i2")), "tof: .* given int16"),
    ("tof has channels", call(tof=zeros(48, 64, 1, dtype="f4")), r"tof: .*\(48, 64, 1\)"),
    ("tof is of objects", call(tof=zeros(48, 64, dtype="O")), "tof: .* given object"),
    ("a Tof is too small", call(tof=sprout.Tof(MAP)), r"tof.depth_m: expected .* given float32 array of shape \(4, 5\)"),
    ("a Tof of another amplitude", lambda p, f: sprout.Tof(MAP, zeros(4, 4, dtype="f4")), r"amplitude: expected float32 array of shape \(4, 5\), given float32 array of shape \(4, 4\)"),
    ("a Tof of integers", lambda p, f: sprout.Tof(zeros(4, 5, dtype="i8")), "depth_m: .* given int64"),
    ("no ToF camera", lambda p, f: p.compute(f.left, f.right, f.tof, sprout.Rig(64, 48, 60, 0.1)), "tof: expected None"),
    ("a path of many letters that are none of ASCII", call(left=39 * "ä"), "left: .* given str 'ä"),
    ("a file whose name is not UTF-8", lambda p, f: sprout.Rig.from_file("/nope/\udcff"), r"rig file /nope/\\xff: cannot be read"),
    ("a configuration whose name is not UTF-8", lambda p, f: sprout.Pipeline("/nope/\udcff"), r"configuration /nope/\\xff: cannot be read"),
    ("a data set whose name is not UTF-8", lambda p, f: sprout.Dataset("kitti:/nope/\udcff"), r"kitti:/nope/\\xff: "),
    ("left is masked", call(left=numpy.ma.masked_less(zeros(48, 64), 1)), "left: expected an array without a mask, given one of numpy.ma that masks 3072 of 3072 elements"),
    ("right is masked", call(right=numpy.ma.array(zeros(48, 64), mask=numpy.arange(3072) == 7)), "right: .* masks 1 of 3072 elements"),
    ("a list of arrays", call(left=[MAP]), r"left: .* given list \[array\(\[\["),
    ("a dict for a rig", lambda p, f: p.compute(f.left, f.right, f.tof, {"width": 64}), "rig: expected a Rig, given dict"),
    ("a rig in the place of tof", lambda p, f: p.compute(f.left, f.right, f.rig), "rig: expected a Rig, given None"),
    ("zones of an array", call(zones=MAP), "zones: expected Zones or None, given float32 array"),
    ("zones of integers", lambda p, f: sprout.Zones(zeros(4, 5), MAP, VIEWS), "depth_m: expected float32 .*given uint8"),
    ("zones in a row", lambda p, f: sprout.Zones(MAP[0], MAP[0], VIEWS), r"depth_m: .*\(5,\)"),
    ("sigmas of other zones", lambda p, f: sprout.Zones(MAP, MAP.T, VIEWS), r"sigma_m: .*\(5, 4\)"),
    ("views of other zones", lambda p, f: sprout.Zones(MAP, MAP, VIEWS[:3]), r"views: .*\(3, 5, 4\)"),
    ("doubts of other zones", lambda p, f: sprout.Zones(MAP, MAP, VIEWS, MAP), "doubtful: expected bool"),
    ("a mode that is none", lambda p, f: sprout.Zones(MAP, MAP, VIEWS, mode="FAR"), "mode: expected MEAN or NEAREST, given 'FAR'"),
    ("a zone that ends before it begins", lambda p, f: sprout.Zones(MAP, MAP, -VIEWS), "zone 0: right"),
    ("a target without sigma", lambda p, f: sprout.Zones(MAP + 1, MAP, VIEWS), "target 0: sigma_m = 0"),
    ("too many zones", lambda p, f: sprout.Zones(zeros(65, 5, dtype="f4"), zeros(65, 5, dtype="f4"), zeros(65, 5, 4, dtype="f4")), "rows = 65"),
    ("truth of another size", lambda p, f: sprout.evaluate(MAP, MAP.T), r"truth: expected float32 array of shape \(4, 5\), given float32 array of shape \(5, 4\)"),
    ("disparity of integers", lambda p, f: sprout.evaluate(zeros(4, 5, dtype="i2"), MAP), "disparity: .* given int16"),
    ("mask of floats", lambda p, f: sprout.evaluate(MAP, MAP, mask=MAP), "mask: expected bool or uint8 array .* given float32"),
    ("confidence of floats", lambda p, f: sprout.evaluate(MAP, MAP, confidence=MAP), "confidence: expected uint8 .* given float32"),
    ("right truth of another size", lambda p, f: sprout.evaluate(MAP, MAP, right_truth=MAP.T), "right_truth: "),
    ("prior of integers", lambda p, f: sprout.PriorMap(zeros(4, 5), 1.0), "disparity: .* given uint8"),
    ("disparities that no map holds", lambda p, f: sprout.PriorMap(MAP + 1024, 1.0), r"disparity: expected -1023.97 to 1023.97 px, NaN: none; given 1024"),
    ("disparities in 1/16 px", lambda p, f: sprout.PriorMap(16 * (MAP - 70), 1.0), "disparity: .* given -1120"),
    ("a timeout that never comes", lambda p, f: sprout.listen(timeout_s=float("nan")), "timeout_s: expected 0 and more, or None: for ever; given nan"),
    ("sigma of another size", lambda p, f: sprout.PriorMap(MAP, MAP.T), r"sigma_px: .*\(5, 4\)"),
    ("a negative sigma", lambda p, f: sprout.PriorMap(MAP, -1), "sigma_px: expected 0 and more, or NaN: not known; given -1.0"),
    ("negative sigmas", lambda p, f: sprout.PriorMap(MAP, MAP - 1), "sigma_px: expected 0 and more"),
    ("Q of another shape", lambda p, f: sprout.Rig.from_q(numpy.eye(3), 64, 48), r"Q: expected float64 array of shape \(4, 4\), given float64 array of shape \(3, 3\)"),
    ("Q of a right and a left camera", lambda p, f: sprout.Rig.from_q(sprout.Rig(64, 48, 60, 0.1).Q * [[1], [1], [1], [-1]], 64, 48), r"Q\[3, 2\]: expected .* above 0, given -10.0; are left and right swapped"),
    ("rotation of another shape", lambda p, f: sprout.TofCamera(4, 3, 4, 4, 2, 1, rotation=numpy.eye(2)), r"rotation: .*\(2, 2\)"),
    ("a rotation that is none", lambda p, f: sprout.TofCamera(4, 3, 4, 4, 2, 1, rotation=2 * numpy.eye(3)),
     r"rotation: expected a rotation, .* given array\(\[\[2., 0., 0.\], \[0., 2."),
]


class InputTest(FolderTest):
    @classmethod
    def setUpClass(cls) -> None:
        scene = synthetic()
        rig = scene.rig.with_aligned_tof(64, 48)
        depth = rig.focal_px * rig.baseline_m / (scene.truth + rig.cx_right - rig.cx)
        cls.rig, cls.left, cls.right = rig, scene.left, scene.right
        cls.tof = numpy.nan_to_num(depth).astype(numpy.float32)
        cls.pipeline = sprout.Pipeline("fast")

    def depth(self, left: Any = None, right: Any = None, tof: Any = None) -> Any:
        pick = lambda given, own: own if given is None else given
        return self.pipeline.compute(pick(left, self.left), pick(right, self.right),
                                     pick(tof, self.tof), self.rig).depth_m

    def test_every_wrong_input_is_a_value_error_that_says_what_is_expected_and_given(self) -> None:
        self.assertGreaterEqual(len(WRONG), 40)

        class Given:
            left, right, tof, rig = self.left, self.right, self.tof, self.rig
        for what, wrong, text in WRONG:
            with self.subTest(what), self.assertRaisesRegex(ValueError, text):
                wrong(self.pipeline, Given)  # type: ignore[arg-type]

    def test_what_can_be_converted_gives_the_same(self) -> None:
        expected = self.depth()
        self.assertTrue(numpy.isfinite(expected).any())
        wide = numpy.zeros((48, 130, *self.left.shape[2:]), numpy.uint8)
        wide[:, 1:129:2] = self.left
        for left in (numpy.asfortranarray(self.left), wide[:, 1:129:2], self.left.copy()):
            self.assertTrue(same(self.depth(left=left), expected))
        self.assertTrue(same(self.depth(tof=self.tof.astype(numpy.float64)), expected))
        self.assertTrue(same(self.depth(tof=numpy.asfortranarray(self.tof)), expected))
        self.assertTrue(same(self.depth(tof=self.tof.astype(">f4")), expected))
        millimetres = numpy.round(self.tof * 1000).astype(numpy.uint16)
        metres = millimetres.astype(numpy.float32) * numpy.float32(0.001)
        self.assertTrue(same(self.depth(tof=millimetres), self.depth(tof=metres)))

    def test_what_is_no_return_is_none_however_it_is_written(self) -> None:
        hole = numpy.zeros(self.tof.shape, bool)
        hole[10:30, 20:40] = True
        millimetres = numpy.round(self.tof * 1000).astype(numpy.uint16)
        expected = self.depth(tof=numpy.where(hole, 0, millimetres).astype(numpy.uint16))
        self.assertFalse(same(expected, self.depth(tof=millimetres)))
        self.assertTrue(same(self.depth(tof=numpy.where(hole, 65535, millimetres).astype(numpy.uint16)), expected))
        self.assertTrue(same(self.depth(tof=numpy.ma.array(millimetres, mask=hole)), expected))
        metres = millimetres.astype(numpy.float32) * numpy.float32(0.001)
        for value in (0, -1, numpy.nan, numpy.inf, 65535):
            self.assertTrue(same(self.depth(tof=numpy.where(hole, value, metres).astype("f4")), expected))
        self.assertTrue(same(self.depth(tof=numpy.ma.array(metres, mask=hole)), expected))

    def test_what_is_masked_is_not_known(self) -> None:
        known = numpy.full((4, 5), 10, numpy.float32)
        masked = numpy.ma.array(known, mask=numpy.arange(20).reshape(4, 5) < 5)
        self.assertEqual(sprout.evaluate(known, masked, mask=known > 0).scored, 15)
        self.assertEqual(sprout.evaluate(masked, known, mask=known > 0).density, 75)
        prior = sprout.PriorMap(masked, 1.0)
        self.assertTrue(numpy.isnan(prior.disparity[0]).all())
        self.assertTrue((prior.disparity[1:] == 10).all())
        self.assertTrue((sprout.PriorMap(known, masked / 10).sigma_px[0] > 15).all())
        self.assertTrue((sprout.PriorMap(known, known.std() + 1).sigma_px == 1).all())
        zones = sprout.Zones(masked, known, VIEWS)
        self.assertTrue((zones.depth_m[0] == 0).all() and (zones.depth_m[1:] == 10).all())

    def test_an_image_that_masks_nothing_is_taken(self) -> None:
        self.assertTrue(same(self.depth(left=numpy.ma.array(self.left)), self.depth()))

    def test_names_of_files_have_the_bytes_that_python_gives_them(self) -> None:
        name = os.fsencode(self.folder) + b"/\xff.textproto"
        pathlib.Path(os.fsdecode(name)).write_text("grow { sub_pixel: false }")
        for given in (os.fsdecode(name), pathlib.Path(os.fsdecode(name))):
            self.assertFalse(sprout.Config(given)["grow.sub_pixel"])
        config = sprout.Config('capture { source: "log:\udcff" }')
        self.assertEqual(config["capture.source"], "log:\udcff")
        self.assertEqual(config.to_dict()["capture"]["source"], "log:\udcff")
        with self.assertRaisesRegex(KeyError, r"no\\\\xff: no such key"):
            config[b"no\xff"]  # type: ignore[index]

    def test_images_of_10_bits_in_16_are_as_those_of_8(self) -> None:
        left, right = (image.astype(numpy.uint16) * 4 for image in (self.left, self.right))
        pipeline = sprout.Pipeline("fast")
        frame = pipeline.compute(left, right, self.tof, self.rig)
        self.assertTrue(same(frame.depth_m, self.depth()))
        self.assertTrue(any("16 bits" in warning for warning in frame.warnings))

    def test_contiguous_inputs_are_not_copied(self) -> None:
        frame = self.pipeline.compute(self.left, self.right, self.tof, self.rig)
        self.assertIs(frame.left, self.left)
        self.assertIs(frame.right, self.right)
        self.assertIs(frame.tof.depth_m, self.tof)
        turned = numpy.asfortranarray(self.left)
        self.assertIsNot(self.pipeline.compute(turned, self.right, self.tof, self.rig).left, turned)

    def test_arrays_outlive_frame_and_pipeline_and_stay_as_they_are(self) -> None:
        pipeline = sprout.Pipeline()
        frame = pipeline.compute(self.left.copy(), self.right.copy(), self.tof.copy(), self.rig)
        kept = [frame.disparity, frame.depth_m, frame.confidence, frame.seeds, frame.left, frame.points()]
        copies = [array.copy() for array in kept]
        for _ in range(3):
            pipeline.compute(self.right, self.left, None, self.rig)
        del frame, pipeline
        gc.collect()
        for array, copy in zip(kept, copies):
            self.assertTrue(same(array, copy))

    def test_a_thousand_frames_take_no_memory_and_leave_no_reference(self) -> None:
        def resident_kb() -> int:
            status = pathlib.Path("/proc/self/status").read_text()
            return int(status.split("VmRSS:")[1].split()[0])
        left, right, tof = self.left.copy(), self.right.copy(), self.tof.copy()
        before = [sys.getrefcount(thing) for thing in (left, right, tof, self.rig)]
        for i in range(1000):
            frame = self.pipeline.compute(left, right, tof, self.rig)
            frame.points(colors=True), frame.depth_m, frame.disparity, frame.seeds, frame.prior, repr(frame)
            try:
                self.pipeline.compute(left, None, tof, self.rig)
            except ValueError:
                pass
            if i == 200:
                start = resident_kb()
        del frame
        after = [sys.getrefcount(thing) for thing in (left, right, tof, self.rig)]
        self.assertEqual(before, after)
        self.assertLess(resident_kb() - start, 2000, "kB more after another 800 frames")


if __name__ == "__main__":
    unittest.main()
