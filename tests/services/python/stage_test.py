import pathlib
import signal
import subprocess
import sys
import time
import unittest
from typing import Any, List, Tuple

import numpy

import sprout
from frames import BIN, SAMPLE, SOURCE, FolderTest, run, same

HERE = pathlib.Path(__file__).parent
PRIOR = SOURCE / "services" / "python" / "examples" / "mean_prior.py"


def python(script: Any, *arguments: Any) -> Tuple[int, str]:
    done = subprocess.run([sys.executable, HERE / script, *map(str, arguments)], capture_output=True,
                          text=True, timeout=300)
    return done.returncode, done.stdout + done.stderr


class StageTest(FolderTest):
    def replay(self, script: Any, *arguments: Any) -> Tuple[List[sprout.Frame], str]:
        record = self.folder / "answers.lcm"
        code, text = python(script, *arguments, "--replay", SAMPLE, "--record", record)
        self.assertEqual(code, 0, text)
        return list(sprout.Log(record).frames()), text

    def test_replays_a_log_as_every_stage_does(self) -> None:
        frames, text = self.replay(PRIOR, "--frames", "1:")
        self.assertRegex(text, "prior: .* frames: 4 in, 4 out")
        for frame in frames:
            given = next(f for f in sprout.Log(SAMPLE).frames() if f.seq == frame.seq)
            disparity = given.seeds["u"] - given.seeds["u_right"]
            numpy.testing.assert_allclose(frame.prior.disparity, disparity.mean(), atol=1 / 64)
            numpy.testing.assert_allclose(frame.prior.sigma_px, disparity.std(), atol=1 / 32)
            self.assertEqual((frame.utime, frame.rig_id), (given.utime, given.rig_id))

    def test_its_answers_are_those_of_the_stages_in_cpp(self) -> None:
        record = self.folder / "answers.lcm"
        run("sprout-pipeline", "--log-level", "error", "--replay", SAMPLE, "--record", record)
        expected = list(sprout.Log(record).frames())
        for frame, whole in zip(self.replay("my_stages.py", "refine")[0], expected):
            self.assertTrue(same(frame.seeds, whole.seeds))
            self.assertEqual(len(frame.left_seeds), 0)
        for frame, whole in zip(self.replay("my_stages.py", "grow")[0], expected):
            self.assertTrue(same(frame.disparity, whole.disparity))
            self.assertTrue(same(frame.confidence, whole.confidence))

    def test_an_exception_costs_its_frame_only_and_is_counted(self) -> None:
        record = self.folder / "answers.lcm"
        code, text = python("my_stages.py", "grow", "--config", "fast", "--replay", SAMPLE, "--record", record)
        self.assertEqual(code, 1, text)
        self.assertEqual(text.count("confidence is not sent: the configuration does not ask for it"), 1, text)
        self.assertRegex(text, r"frame 1: failed: RuntimeError: odd frames are too much at .*my_stages.py\(21\)")
        self.assertRegex(text, r"5 in, 3 out \(0 degenerate\), 2 failed")
        # An answer that later stages would refuse fails as well.
        code, text = python("my_stages.py", "refine", "--config", "fast", "--replay", SAMPLE, "--record", record)
        self.assertEqual(code, 1, text)
        self.assertRegex(text, "seeds: seed 3: position not finite")
        self.assertRegex(text, r"5 in, 3 out \(0 degenerate\), 2 failed")

    def test_a_text_in_place_of_an_answer_is_a_frame_without_a_result_also_an_empty_one(self) -> None:
        script = self.folder / "nothing.py"
        script.write_text('import sprout\n@sprout.stage("grow")\ndef nothing(frame, config):\n    return ""\n'
                          'sprout.run()\n')
        code, text = python(script, "--replay", SAMPLE, "--record", self.folder / "answers.lcm")
        self.assertEqual(code, 1, text)
        self.assertRegex(text, r"5 in, 5 out \(5 degenerate\)")
        self.assertIn("the stage's function gives no reason", text)

    def answer(self, stage: str, expression: str) -> Tuple[int, str]:
        """Of a stage that gives an expression of `ones`, of the size of the image, or 9 `seeds`."""
        script = self.folder / "gives.py"
        script.write_text("import numpy, sprout\n"
                          f"@sprout.stage({stage!r})\n"
                          "def gives(frame, config):\n"
                          "    ones = numpy.ones(frame.left.shape[:2], numpy.float32)\n"
                          "    seeds = numpy.zeros(9, sprout.SEED)\n"
                          "    seeds['u'], seeds['v'], seeds['u_right'], seeds['sigma_px'] = 20, 5, 10, 1\n"
                          "    seeds['tof_u'] = seeds['tof_v'] = -1\n"
                          f"    return {expression}\n"
                          "sprout.run()\n")
        return python(script, "--replay", SAMPLE, "--record", self.folder / "answers.lcm")

    def test_answers_that_no_stage_may_give_are_refused(self) -> None:
        for stage, expression, said in (
                ("prior", "sprout.PriorMap(-7 * ones, 1)", "prior: disparity -7 px at (0, 0); allowed is -3 to 127"),
                ("grow", "-2 * ones", "disparity: disparity -2 px at (0, 0); allowed is -1 to 127"),
                ("grow", "128 * ones", "disparity: disparity 128 px at (0, 0); allowed is -1 to 127"),
                ("refine", "(seeds.__setitem__('u_right', 30), seeds)[1]",
                 "seeds: seed 0 is (u 20, v 5, u_right 30); allowed are places in both images (128x96)"),
                ("refine", "numpy.ma.array(seeds)", "seeds: expected an array of sprout.SEED without a mask")):
            code, text = self.answer(stage, expression)
            self.assertEqual(code, 1, text)
            self.assertIn("frame 0: failed: " + said, text)
            self.assertIn("5 in, 0 out (0 degenerate), 5 failed", text)
        for stage, expression in (("prior", "sprout.PriorMap(127 * ones, 1)"), ("grow", "0 * ones"), ("refine", "seeds"),
                                  ("prior", "sprout.PriorMap(-2 * ones, 1)")):  # near infinity: cx_right - cx is 1.28
            code, text = self.answer(stage, expression)
            self.assertEqual(code, 0, text)

    def test_answers_without_anything_in_them_are_no_results(self) -> None:
        for stage, expression, said in (
                ("prior", "sprout.PriorMap(numpy.nan * ones, 1)", "gives a map without any disparity"),
                ("grow", "numpy.nan * ones", "gives a map without any disparity"),
                ("refine", "seeds[:0]", "gives no seeds"),
                ("refine", "'dark;\\n  nothing'", "dark;; nothing")):
            code, text = self.answer(stage, expression)
            self.assertEqual(code, 1, text)
            self.assertIn("5 in, 5 out (5 degenerate)", text)
            self.assertIn(said + "\n", text)

    def test_has_the_flags_of_every_stage_and_its_own_words(self) -> None:
        code, text = python(PRIOR, "--help")
        self.assertEqual(code, 0)
        for said in ("--replay", "--channel-prefix", "--config", "The mean disparity of the seeds"):
            self.assertIn(said, text)
        self.assertEqual(python(PRIOR, "--config", "no_such")[0], 2)
        self.assertEqual(python(PRIOR, "--version"), (0, f"mean_prior.py on sprout {sprout.__version__}\n"))

    def test_logs_and_records_its_own_name(self) -> None:
        record = self.folder / "answers.lcm"
        _, text = python(PRIOR, "--replay", SAMPLE, "--record", record)
        self.assertIn(f"mean_prior.py on sprout {sprout.__version__}, configuration ", text)
        self.assertNotIn("sprout-prior", text)
        self.assertIn(f"mean_prior.py on sprout {sprout.__version__}", run("sprout-log", "info", record))

    def test_says_which_stage_is_not_known(self) -> None:
        with self.assertRaisesRegex(ValueError, "expected refine, prior or grow, given 'priors'"):
            sprout.stage("priors")
        with self.assertRaisesRegex(ValueError, r"\(none\), given None"):
            sprout.run()

    def test_ends_on_a_signal_also_when_a_library_has_threads(self) -> None:
        program = ("import threading, time, runpy, sys\n"
                   "for _ in range(8): threading.Thread(target=time.sleep, args=(600,), daemon=True).start()\n"
                   f"sys.argv = ['my_prior.py', '--channel-prefix', 'E_']\n"
                   f"runpy.run_path({str(PRIOR)!r}, run_name='__main__')\n")
        isolate = SOURCE / "tests" / "system" / "in_private_network"
        for ending in (signal.SIGTERM, signal.SIGINT):
            with subprocess.Popen([isolate, sys.executable, "-c", program], stderr=subprocess.PIPE,
                                  text=True) as process:
                first = process.stderr.readline()
                if " on sprout" not in first:
                    self.skipTest("no private network here: " + first)
                time.sleep(0.5)
                process.send_signal(ending)
                rest = process.stderr.read()
                self.assertEqual(process.wait(20), 0, rest)
                self.assertIn(f"{ending.name}: stopping", rest)

    def test_stands_in_for_the_prior(self) -> None:
        done = subprocess.run([SOURCE / "scripts" / "check_stage", "--bin", BIN, "prior", "--", sys.executable,
                               PRIOR], capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("ok     one answer a frame", done.stdout)


if __name__ == "__main__":
    unittest.main()
