import importlib.util
import pathlib
import subprocess
import sys
import unittest
from typing import Any

import numpy

import sprout
from frames import BIN, SAMPLE, SOURCE, FolderTest, environment

EXAMPLES = SOURCE / "services" / "python" / "examples"
ISOLATE = SOURCE / "tests" / "system" / "in_private_network"


def example(name: str, *arguments: Any) -> str:
    done = subprocess.run([sys.executable, EXAMPLES / name, *map(str, arguments)], capture_output=True,
                          text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def write_pnm(path: pathlib.Path, image: numpy.ndarray) -> None:
    kind, image = ("P5", image) if image.ndim == 2 else ("P6", image[..., ::-1])
    path.write_bytes(f"{kind}\n{image.shape[1]} {image.shape[0]}\n255\n".encode() + image.tobytes())


def write_pfm(path: pathlib.Path, values: numpy.ndarray) -> None:
    shown = numpy.nan_to_num(values, nan=numpy.inf).astype("<f4")
    path.write_bytes(f"Pf\n{values.shape[1]} {values.shape[0]}\n-1\n".encode() + shown[::-1].tobytes())


def middlebury(folder: pathlib.Path) -> None:
    """A made-up scene in the layout of 2014."""
    scene = sprout.Dataset("synthetic:320x240")[0]
    rig = scene.rig
    write_pnm(folder / "im0.ppm", scene.left)
    write_pnm(folder / "im1.ppm", scene.right)
    write_pfm(folder / "disp0.pfm", scene.truth)
    write_pfm(folder / "disp1.pfm", scene.right_truth)
    (folder / "calib.txt").write_text(
        f"cam0=[{rig.focal_px} 0 {rig.cx}; 0 {rig.focal_px} {rig.cy}; 0 0 1]\n"
        f"cam1=[{rig.focal_px} 0 {rig.cx_right}; 0 {rig.focal_px} {rig.cy}; 0 0 1]\n"
        f"doffs={rig.cx_right - rig.cx}\nbaseline={rig.baseline_m * 1000}\nwidth=320\nheight=240\n")


class ExamplesTest(FolderTest):
    def test_middlebury_pair_to_ply(self) -> None:
        middlebury(self.folder)
        cloud = self.folder / "cloud.ply"
        said = example("middlebury_to_ply.py", self.folder, cloud)
        count = int(said.split(": ")[1].split()[0])
        self.assertIn(f"element vertex {count}\n".encode(), cloud.read_bytes())
        self.assertGreater(count, 320 * 240 * 0.9)
        self.assertGreater(float(said.split("correct_le1=")[1].split()[0]), 90)

    def test_data_set_says_what_both_cameras_see(self) -> None:
        middlebury(self.folder)
        self.assertIsNone(sprout.Dataset(f"middlebury:{self.folder}")[0].nonoccluded)
        (self.folder / "disp0.pfm").rename(self.folder / "disp0GT.pfm")  # the layout of the evaluation
        mask = numpy.zeros((240, 320), numpy.uint8)
        mask[40:80, 60:200] = 255
        write_pnm(self.folder / "mask0nocc.png", mask)
        scene = sprout.Dataset(f"middlebury:{self.folder}")[0]
        numpy.testing.assert_array_equal(scene.nonoccluded, mask)
        score = sprout.evaluate(scene.truth, scene.truth, scene.right_truth, scene.nonoccluded)
        self.assertEqual(score.scored, numpy.isfinite(scene.truth[mask == 255]).sum())

    def test_log_to_npz(self) -> None:
        archive = self.folder / "run.npz"
        example("log_to_npz.py", SAMPLE, archive)
        loaded = numpy.load(archive)
        frames = list(sprout.Log(SAMPLE).frames())
        self.assertEqual(loaded["seq"].tolist(), [frame.seq for frame in frames])
        numpy.testing.assert_array_equal(loaded["depth_m"][2], frames[2].depth_m)
        numpy.testing.assert_array_equal(loaded["K"], frames[2].intrinsics)

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "no python3-matplotlib")
    def test_live_view_of_the_running_graph(self) -> None:
        picture = self.folder / "view.png"
        script = (f'trap "kill 0" EXIT; "{BIN}/sprout-pipeline" --log-level error &\n'
                  f'"{BIN}/sprout-capture" --source synthetic:160x120 --log-level error &\n'
                  f'"{sys.executable}" "{EXAMPLES}/live_view.py" "{picture}"; result=$?\n'
                  'trap - EXIT; kill $(jobs -p); exit $result')
        done = subprocess.run([ISOLATE, "bash", "-c", script], capture_output=True, text=True, timeout=120,
                              start_new_session=True, env=environment(MPLBACKEND="Agg", MPLCONFIGDIR=str(self.folder)))
        if done.returncode == 77:
            self.skipTest("no private network here")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))

    @unittest.skipUnless(importlib.util.find_spec("open3d"), "no python3-open3d")
    def test_depth_into_open3d(self) -> None:
        cloud = self.folder / "cloud.pcd"
        said = example("open3d_cloud.py", SAMPLE, cloud)
        frame = sprout.Log(SAMPLE)[-1]
        self.assertEqual(int(said.split(": ")[1].split()[0]), len(frame.points()))

    def test_are_typed(self) -> None:
        package = pathlib.Path(sprout.__file__).parent
        checked = [*sorted(EXAMPLES.glob("*.py")), package / "__init__.py", package / "_sprout.pyi"]
        done = subprocess.run(["/usr/bin/mypy", "--strict", "--ignore-missing-imports", "--cache-dir", self.folder,
                               "--python-executable", sys.executable, *map(str, checked)],
                              capture_output=True, text=True, timeout=300,
                              env=environment(MYPYPATH=str(package.parent)), cwd=package.parent)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_stubs_say_what_the_module_has(self) -> None:
        done = subprocess.run([SOURCE / "services" / "python" / "make_stubs", "--check"], capture_output=True,
                              text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
