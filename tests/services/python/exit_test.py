"""How a program ends, and objects that never began."""
import copy
import pickle
import subprocess
import sys
import textwrap
import unittest

import sprout
from frames import SAMPLE, FolderTest, compute, synthetic

# Calls in which a daemon thread is while the program ends; each waits without the interpreter's lock.
WORK = {
    "compute": """
        scene = sprout.Dataset("synthetic:160x120?tof=grid")[0]
        def work():
            pipeline = sprout.Pipeline("fast")
            while True:
                pipeline.compute(scene.left, scene.right, scene.tof, scene.rig)
                begun.set()
        """,
    "listen": """
        def work():
            begun.set()
            for frame in sprout.listen(url="udpm://239.255.76.67:17667?ttl=0"):
                pass
        """,
    "log": f"""
        def work():
            while True:
                for frame in sprout.Log({str(SAMPLE)!r}).frames():
                    frame.points()
                    begun.set()
                len(sprout.Log({str(SAMPLE)!r}))
        """,
    "dataset": """
        def work():
            for frame in sprout.Dataset("synthetic:64x48"):
                begun.set()
        """,
}


def end_of(program: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)


class ExitTest(FolderTest):
    def test_daemon_threads_may_be_at_work(self) -> None:
        for name, work in WORK.items():
            program = ("import atexit, sys, threading, sprout\nbegun = threading.Event()\n" + textwrap.dedent(work) +
                       "for _ in range(3): threading.Thread(target=work, daemon=True).start()\n"
                       "begun.wait(30)\nsys.exit(7)\n")
            for _ in range(4):
                done = end_of(program)
                self.assertEqual((done.returncode, done.stdout), (7, ""), name + done.stderr)
                self.assertNotIn("terminate", done.stderr)

    def test_what_ends_the_program_may_use_it(self) -> None:
        # Handlers run in the reverse order: one before, one after the module's.
        for order in ("atexit.register(last); import sprout", "import sprout; atexit.register(last)"):
            done = end_of("import atexit, sys\n"
                          "def last(): print(sprout.Dataset('synthetic:64x48')[0].left.shape)\n"
                          f"{order}; sys.exit(3)\n")
            self.assertEqual((done.returncode, done.stdout), (3, "(48, 64, 3)\n"), order + done.stderr)

    def test_a_stage_ends_where_its_function_says_so(self) -> None:
        program = ("import sys, sprout\n"
                   "calls = []\n"
                   "@sprout.stage('prior')\n"
                   "def prior(frame, config):\n"
                   "    calls.append(frame.seq)\n"
                   "    if len(calls) == 2: sys.exit(5)\n"
                   "    return 'nothing'\n"
                   "try:\n"
                   "    sprout.run(arguments=sys.argv[1:])\n"
                   "finally:\n"
                   "    print(calls)\n")
        record = self.folder / "answers.lcm"
        done = subprocess.run([sys.executable, "-c", program, "--replay", SAMPLE, "--record", record],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 5, done.stderr)
        self.assertRegex(done.stdout, r"(?m)^\[\d+, \d+\]$")

    def test_classes_give_no_object_without_a_value(self) -> None:
        for name in sprout.__all__:
            kind = getattr(sprout, name)
            if not isinstance(kind, type):
                continue
            with self.subTest(name):
                with self.assertRaises(TypeError):
                    kind.__new__(kind)
                with self.assertRaises(TypeError):
                    object.__new__(kind)
        with self.assertRaises(TypeError):
            copy.copy(compute(sprout.Pipeline("fast"), synthetic()))

    def test_what_has_a_value_can_be_copied(self) -> None:
        rig = synthetic().rig
        for thing in (rig, rig.tof, sprout.Config("fast"), sprout.Config()):
            for made in (copy.copy(thing), copy.deepcopy(thing), pickle.loads(pickle.dumps(thing))):
                self.assertEqual(repr(made), repr(thing))

        class Mine(sprout.Config):
            pass

        self.assertEqual(Mine("fast"), sprout.Config("fast"))

    def test_threads_have_a_range(self) -> None:
        for count in (-1, 1025, 10**5):
            with self.assertRaisesRegex(ValueError, f"count: expected 0 to 1024, given {count}"):
                sprout.set_threads(count)
        sprout.set_threads(0)


if __name__ == "__main__":
    unittest.main()
