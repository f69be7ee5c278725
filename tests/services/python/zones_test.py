import unittest
from typing import Any

import numpy

import sprout
from frames import SAMPLE, FolderTest, compute, events, message, run, same, without_points, write_log


def zones_message(header: Any, zones: sprout.Zones) -> bytes:
    """A tof_zones_t, written field by field."""
    out = message("tof_zones_t")()
    out.header = header
    out.rows, out.columns, out.targets_per_zone = zones.depth_m.shape
    out.zone_count, out.target_count = out.rows * out.columns, zones.depth_m.size
    out.mode = {"MEAN": out.MODE_MEAN, "NEAREST": out.MODE_NEAREST}[zones.mode]
    out.left_from_sensor_rotation = [1, 0, 0, 0]
    out.left_from_sensor_translation_m = list(zones.translation_m)
    out.left, out.right, out.top, out.bottom = zones.views.reshape(-1, 4).T.tolist()
    out.depth_m, out.sigma_m = zones.depth_m.ravel().tolist(), zones.sigma_m.ravel().tolist()
    out.status = [0 if z == 0 else 2 if doubt else 1
                  for z, doubt in zip(zones.depth_m.ravel(), zones.doubtful.ravel())]
    return bytes(out.encode())


def far_zones() -> sprout.Zones:
    """Two columns and a row, two targets each: a wall on the left that is too far for what stands there,
    and nothing that is sure on the right."""
    views = numpy.array([[[-1, 0.125, -1, 1], [0.125, 1, -1, 1]]], numpy.float32)
    depth = numpy.array([[[50, 0], [50, 0]]], numpy.float32)
    return sprout.Zones(depth, numpy.full((1, 2, 2), 0.5, numpy.float32), views,
                        doubtful=numpy.array([[[False, False], [True, False]]]),
                        translation_m=(0.01, 0, 0))


class ZonesTest(FolderTest):
    """Against the replays of sprout-pipeline and sprout-refine."""

    def test_zones_give_the_bytes_of_the_replay(self) -> None:
        config = ("default", "refine { zones: true }")
        zones = far_zones()
        path, answers = self.folder / "zones.lcm", self.folder / "answers.lcm"
        items = []
        for utime, channel, data in events(SAMPLE):
            if channel == "SPROUT_TOF":
                data = without_points(data)
                header = message("tof_image_t").decode(data).header
                items.append((utime, "SPROUT_TOF_ZONES", zones_message(header, zones)))
            if channel in ("SPROUT_LEFT", "SPROUT_RIGHT", "SPROUT_TOF", "SPROUT_RIG"):
                items.append((utime, channel, data))
        write_log(path, items)
        # All frames are degenerate: these zones leave no seed.
        run("sprout-pipeline", "--config", config[0], "--config", config[1], "--log-level", "error",
            "--replay", path, "--record", answers, expect=1)
        seeds = self.folder / "seeds.lcm"
        run("sprout-refine", "--config", config[0], "--config", config[1], "--log-level", "error",
            "--replay", path, "--record", seeds, expect=1)
        pipeline, without = sprout.Pipeline(*config), sprout.Pipeline("default")
        frames = list(sprout.Log(path).frames())
        self.assertGreaterEqual(len(frames), 3)
        for given, expected, refined in zip(frames, sprout.Log(answers).frames(), sprout.Log(seeds).frames()):
            self.assertIn("tof_zones", given.parts)
            for field in ("depth_m", "sigma_m", "views", "doubtful", "translation_m", "rotation"):
                self.assertTrue(same(getattr(given.tof_zones, field), getattr(zones, field)), field)
            frame = compute(pipeline, given, zones=zones)
            self.assertTrue(same(frame.seeds, expected.seeds))
            self.assertTrue(same(frame.seeds, refined.seeds))
            self.assertTrue(same(frame.left_seeds, expected.left_seeds))
            self.assertTrue(same(frame.disparity, expected.disparity))
            self.assertTrue(same(compute(pipeline, given, zones=given.tof_zones).disparity, frame.disparity))
            # These zones remove seeds.
            self.assertLess(len(frame.seeds), len(compute(without, given).seeds))
            self.assertTrue(same(compute(pipeline, given).seeds, compute(without, given).seeds))
        with self.assertRaisesRegex(ValueError, "zones: 2x1, but refine.zones is false"):
            compute(without, frames[0], zones=zones)

    def test_zones_of_a_data_set_are_what_they_were_made_of(self) -> None:
        zones = sprout.Dataset("synthetic:160x120?tof=zones:8x6")[0].tof_zones
        self.assertEqual(zones.depth_m.shape[:2], (6, 8))
        again = sprout.Zones(zones.depth_m, zones.sigma_m, zones.views, zones.doubtful, zones.mode,
                             zones.rotation, zones.translation_m)
        for field in ("depth_m", "sigma_m", "views", "doubtful", "translation_m", "rotation"):
            self.assertTrue(same(getattr(again, field), getattr(zones, field)), field)
        self.assertEqual(repr(again), "<sprout.Zones 8x6>")
        one = sprout.Zones(zones.depth_m[..., 0], zones.sigma_m[..., 0], zones.views, mode="NEAREST")
        self.assertEqual((one.depth_m.shape, one.mode), ((6, 8, 1), "NEAREST"))
        self.assertTrue(same(one.depth_m[..., 0], zones.depth_m[..., 0].copy()))
        self.assertFalse(one.doubtful.any())


if __name__ == "__main__":
    unittest.main()
