import inspect
import pathlib
import pydoc
import re
import subprocess
import unittest

import sprout
from frames import SAMPLE, compute, run, synthetic


class ModuleTest(unittest.TestCase):
    def test_has_the_version_of_the_programs(self) -> None:
        # In a tree that is half built the revisions may differ.
        self.assertEqual(run("sprout-grow", "--version").split()[1], sprout.__version__.split()[0])
        self.assertRegex(sprout.__version__, r"^\d+\.\d+\.\d+ \(\w+")

    def test_documents_everything_that_it_shows(self) -> None:
        undocumented = []
        for name in sprout.__all__:
            thing = getattr(sprout, name)
            if name in ("SEED", "__version__"):
                continue
            if not thing.__doc__:
                undocumented.append(name)
            members = inspect.getmembers(thing) if inspect.isclass(thing) else []
            undocumented += [f"{name}.{member}" for member, value in members
                             if not member.startswith("_") and not value.__doc__]
        self.assertEqual(undocumented, [])
        text = pydoc.render_doc(sprout, renderer=pydoc.plaintext)
        for said in ("pipeline = sprout.Pipeline", "compute(self, left: numpy.ndarray", "float32, z, m; NaN: none"):
            self.assertIn(said, text)
        # No text may have types that only C++ knows.
        self.assertNotRegex(text, r"sprout::|cv::|std::")

    def test_shows_what_everything_is(self) -> None:
        scene = synthetic()
        frame = compute(sprout.Pipeline("fast"), scene)
        log = sprout.Log(SAMPLE)
        shown = {
            "Config": sprout.Config("fast"), "Dataset": sprout.Dataset("synthetic:64x48"), "Frame": frame,
            "Evaluation": sprout.evaluate(frame.disparity, scene.truth), "Log": log, "LogFrames": log.frames(),
            "Pipeline": sprout.Pipeline("fast"), "PriorMap": frame.prior, "Rig": scene.rig, "Tof": scene.tof,
            "TofCamera": scene.rig.tof,
        }
        for name, thing in shown.items():
            self.assertIsInstance(thing, getattr(sprout, name))
            self.assertIn(name, repr(thing))
            self.assertNotIn(" object at 0x", repr(thing))
        self.assertIn("disparity", repr(frame))
        self.assertIn("correct_le1=", repr(shown["Evaluation"]))

    def test_is_typed(self) -> None:
        folder = pathlib.Path(sprout.__file__).parent
        self.assertTrue((folder / "py.typed").exists())
        self.assertTrue((folder / "_sprout.pyi").exists())

    def test_has_the_message_types(self) -> None:
        header = sprout.header_t()
        header.utime, header.seq, header.rig_id = 5, 7, "rig"
        image = sprout.image_t()
        image.header, image.data = header, b""
        read = sprout.image_t.decode(image.encode())
        self.assertEqual((read.header.utime, read.header.seq, read.header.rig_id), (5, 7, "rig"))
        with self.assertRaises(AttributeError):
            sprout.no_such_t

    def test_shows_nothing_of_what_it_is_made_of(self) -> None:
        module = next(pathlib.Path(sprout.__file__).parent.glob("_sprout.*.so"))
        symbols = subprocess.run(["nm", "-D", "--defined-only", module], capture_output=True, text=True, check=True)
        self.assertEqual(re.findall(r" [TBDR] (\S+)", symbols.stdout), ["PyInit__sprout"])


if __name__ == "__main__":
    unittest.main()
