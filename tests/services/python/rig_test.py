import pathlib
import pickle
import unittest

import numpy

import sprout
from frames import FolderTest

# calib.txt of a sequence of KITTI's odometry set: no R0_rect.
KITTI = """P0: 700 0 600 0 0 700 180 0 0 0 1 0
P1: 700 0 600 -350 0 700 180 0 0 0 1 0
P2: 707.0912 0 601.8873 45.38225 0 707.0912 183.1104 -0.1130887 0 0 1 0.003779761
P3: 707.0912 0 601.8873 -333.0627 0 707.0912 183.1104 2.334 0 0 1 0.002
Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0
"""


def rig_with_tof() -> sprout.Rig:
    turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    tof = sprout.TofCamera(176, 144, 230, 231, 87.5, 71.5, distortion=[-0.1, 0.02, 0, 0, 0],
                           rotation=turn, translation_m=(0.05, -0.01, 0.002))
    return sprout.Rig(640, 480, 700, 0.12, cx=310, cy=235, cx_right=305, tof=tof)


class RigTest(FolderTest):
    def test_has_principal_points_in_the_middle_when_it_is_not_told(self) -> None:
        rig = sprout.Rig(640, 480, 700.0, 0.12)
        self.assertEqual((rig.cx, rig.cy, rig.cx_right), (319.5, 239.5, 319.5))
        self.assertIsNone(rig.tof)
        numpy.testing.assert_array_equal(rig.K, [[700, 0, 319.5], [0, 700, 239.5], [0, 0, 1]])

    def test_comes_back_from_a_dict_a_pickle_and_its_repr(self) -> None:
        rig = rig_with_tof()
        self.assertEqual(sprout.Rig.from_dict(rig.to_dict()), rig)
        self.assertEqual(pickle.loads(pickle.dumps(rig)), rig)
        self.assertEqual(eval(repr(rig), {"Rig": sprout.Rig, "TofCamera": sprout.TofCamera}), rig)
        self.assertEqual(pickle.loads(pickle.dumps(rig)).rig_id, rig.rig_id)
        self.assertEqual(hash(pickle.loads(pickle.dumps(rig))), hash(rig))
        self.assertNotEqual(sprout.Rig(640, 480, 700, 0.12), rig)
        tof = rig.tof
        assert tof is not None
        self.assertEqual(pickle.loads(pickle.dumps(tof)).to_dict(), tof.to_dict())
        numpy.testing.assert_allclose(tof.rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
        numpy.testing.assert_array_equal(tof.translation_m, [0.05, -0.01, 0.002])

    def test_comes_from_q_of_cv2_and_gives_it_back(self) -> None:
        # cv2.stereoRectify: Q[3, 2] = -1 / Tx with Tx = -0.12, Q[3, 3] = (cx - cx') / Tx.
        q = numpy.array([[1, 0, 0, -310], [0, 1, 0, -235], [0, 0, 0, 700], [0, 0, 1 / 0.12, -5 / 0.12]])
        rig = sprout.Rig.from_q(q, 640, 480)
        self.assertAlmostEqual(rig.baseline_m, 0.12)
        self.assertEqual((rig.focal_px, rig.cx, rig.cy), (700, 310, 235))
        self.assertAlmostEqual(rig.cx_right, 305)
        numpy.testing.assert_allclose(rig.Q, q)
        x, y, z, w = rig.Q @ [100, 50, 20, 1]
        self.assertAlmostEqual(z / w, 700 * 0.12 / (20 + rig.cx_right - rig.cx))

    def test_comes_from_a_calib_txt_of_kitti(self) -> None:
        path = self.folder / "calib.txt"
        path.write_text(KITTI)
        rig = sprout.Rig.from_kitti(path, 1226, 370)
        self.assertAlmostEqual(rig.baseline_m, (45.38225 + 333.0627) / 707.0912)
        self.assertEqual((rig.width, rig.height, rig.cx), (1226, 370, 601.8873))
        self.assertAlmostEqual(sprout.Rig.from_kitti(str(path), 1226, 370, grey=True).baseline_m, 0.5)
        path.write_text(KITTI.replace("P3", "P4"))
        with self.assertRaisesRegex(ValueError, "P3 is missing"):
            sprout.Rig.from_kitti(path, 1226, 370)

    def test_comes_from_a_rig_file_and_its_images_are_rectified(self) -> None:
        path = self.folder / "rig.textproto"
        path.write_text("""calibration {
          left { width: 64 height: 48 fx: 60 fy: 60 cx: 31 cy: 23 }
          right { width: 64 height: 48 fx: 60 fy: 60 cx: 32 cy: 24 }
          left_from_right { translation_m: [0.1, 0, 0] }
        }""")
        rig = sprout.Rig.from_file(path)
        self.assertAlmostEqual(rig.baseline_m, 0.1)
        rectifier = sprout.Rectifier(path)
        self.assertEqual(rectifier.rig, rig)
        image = numpy.full((48, 64), 90, numpy.uint8)
        left, right, tof = rectifier.rectify(image, image)
        self.assertEqual((left.shape, right.dtype, tof), ((48, 64), numpy.uint8, None))
        self.assertEqual(left[24, 32], 90)
        with self.assertRaisesRegex(ValueError, "tof: expected None, since the rig has no ToF camera"):
            rectifier.rectify(image, image, image.astype(numpy.float32))
        image[:, 48:] = 255
        with self.assertWarnsRegex(UserWarning, "16 bits"):  # of which 10 are used
            deep, _, _ = rectifier.rectify(image.astype(numpy.uint16) * 4, image.astype(numpy.uint16) * 4)
        self.assertEqual((deep.dtype, deep[24, 32]), (numpy.uint8, 90))

    def test_sees_a_range_image_over_the_left_one_at_any_resolution(self) -> None:
        rig = sprout.Rig(640, 480, 700, 0.12).with_aligned_tof(160, 120)
        assert rig.tof is not None
        self.assertEqual((rig.tof.width, rig.tof.fx, rig.tof.cx), (160, 175, 79.5))

    def test_says_what_no_camera_has(self) -> None:
        with self.assertRaisesRegex(ValueError, "baseline_m"):
            sprout.Rig(640, 480, 700, -0.12)
        for size in (0, 0), (-1, 48), (64, 0):
            with self.assertRaisesRegex(ValueError, "allowed is 1 to 16384"):
                sprout.Rig(640, 480, 700, 0.12).with_aligned_tof(*size)
        with self.assertRaisesRegex(ValueError, "keys that to_dict"):
            sprout.Rig.from_dict({"width": 3})


class ConfigTest(FolderTest):
    def test_comes_from_a_preset_a_file_several_and_a_text(self) -> None:
        path = self.folder / "mine.textproto"
        path.write_text("grow { sigma_p_px: 2.5 }")
        self.assertIs(sprout.Config("fast")["grow.sub_pixel"], False)
        self.assertEqual(sprout.Config(path)["grow.sigma_p_px"], 2.5)
        self.assertEqual(sprout.Config(str(path))["grow.sigma_p_px"], 2.5)
        both = sprout.Config("fast", path, "grow { sub_pixel: true }")
        self.assertEqual((both["grow.sub_pixel"], both["grow.sigma_p_px"]), (True, 2.5))
        self.assertEqual(both["prior.method"], "DELAUNAY")
        self.assertEqual(both["grow"], both.to_dict()["grow"])
        self.assertEqual(sprout.Config(["fast", path]), sprout.Config("fast", path))
        self.assertEqual(sprout.Config("default")["grow"], sprout.Config()["grow"])

    def test_comes_back_from_a_pickle_its_text_and_its_repr(self) -> None:
        config = sprout.Config("paper", "refine { stereo { grid_px: 9 } }"
                               if "stereo {" in sprout.Config().text else "grow { threshold: 0.25 }")
        self.assertEqual(pickle.loads(pickle.dumps(config)), config)
        self.assertEqual(sprout.Config(config.text), config)
        self.assertEqual(eval(repr(config), {"Config": sprout.Config}), config)
        self.assertEqual(pickle.loads(pickle.dumps(config)).digest, config.digest)
        self.assertNotEqual(sprout.Config(), config)

    def test_has_lists_as_lists(self) -> None:
        config = sprout.Config('ros2 { topics: "DEPTH" topics: "CLOUD" }')
        self.assertEqual(config["ros2.topics"], ["DEPTH", "CLOUD"])
        self.assertEqual(sprout.Config("depth { region: [1, 2, 30, 40] }")["depth.region"], [1, 2, 30, 40])
        self.assertEqual(eval(repr(config), {"Config": sprout.Config}), config)

    def test_says_what_cannot_be_used(self) -> None:
        for parts, why in ((["no_such"], "default, fast, paper"), (["grow { x: 1 }"], "text:1:9.*x"),
                           (["grow { threshold: 7 }"], "grow.threshold = 7: out of range; allowed: 0.001 to 0.999"), ([3], "given 3"),
                           ([pathlib.Path("nowhere")], "nowhere")):
            with self.assertRaisesRegex(ValueError, why):
                sprout.Config(*parts)
        with self.assertRaisesRegex(KeyError, "grow.no"):
            sprout.Config()["grow.no"]


if __name__ == "__main__":
    unittest.main()
