#!/usr/bin/python3
"""Plants faults in a copy of the sources, one at a time; check.py must see each, and none before."""
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]

# file, what is appended to it, what check.py must say
FAULTS = {
    "upward": ("renderer/math/ray.h", '#include "voxels/trace.h"',
               '"voxels/trace.h": math may not include voxels'),
    "sideways": ("renderer/image/image.h", '#include "error/error_table.h"',
                 "image may not include error"),
    "upward in the server": ("server/engine/bake_run.h", '#include "commands/commands.h"',
                             "engine may not include commands"),
    "angle brackets": ("renderer/io/file.cpp", "#include <bake/plan.h>", "io may not include bake"),
    "indented": ("renderer/io/file.cpp", '#  include "bake/plan.h"', "io may not include bake"),
    "undeclared folder": ("renderer/bake/plan.cpp", '#include "tests/support/data.h"',
                          "tests is not in layers.txt"),
    "relative path": ("renderer/math/ray.h", '#include "../voxels/trace.h"',
                      ".. is not in layers.txt"),
    "beside the folders": ("server/http/query.h", '#include "service.h"',
                           "http may not include service"),
    "no folder": ("renderer/math/ray.h", '#include "vec.h"', "vec is not in layers.txt"),
    "new folder": ("renderer/planted/planted.h", "#pragma once",
                   "planted is not in layers.txt"),
    "no pragma once": ("tests/planted.h", "int planted();", "no #pragma once"),
    "tab": ("server/main.cpp", "\t", "a tab"),
    "unfinished": ("scripts/build", "# TO" "DO", "a mark of unfinished work"),
    "long file": ("tests/planted.cpp", "\n" * 500, "501 lines; at most 500"),
}


def check(root):
    return subprocess.run([sys.executable, HERE / "check.py", root], capture_output=True, text=True)


class CheckTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.copy = Path(directory.name)
        for top in ("renderer", "server", "tests", "scripts", ".ci"):
            shutil.copytree(ROOT / top, self.copy / top)

    def test_sees_every_fault(self):
        before = check(self.copy).stdout
        for name, (file, text, message) in FAULTS.items():
            with self.subTest(name):
                self.assertNotIn(message, before)
                path = self.copy / file
                original = path.read_text() if path.exists() else None
                path.parent.mkdir(exist_ok=True)
                path.write_text((original or "") + text + "\n")
                result = check(self.copy)
                self.assertEqual(result.returncode, 1)
                self.assertIn(f"{file}:", result.stdout)
                self.assertIn(message, result.stdout)
                if original is None:
                    path.unlink()
                else:
                    path.write_text(original)

    def test_an_empty_tree_is_no_success(self):
        with tempfile.TemporaryDirectory() as empty:
            self.assertNotEqual(check(empty).returncode, 0)


if __name__ == "__main__":
    unittest.main()
