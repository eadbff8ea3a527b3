"""The ledger of what tests and build may cost, tests/budget.txt: each program has its line, and all of them with what is
reserved for later issues stay below what a run may cost as a whole."""

import pathlib
import re
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from changed_programs import reach_of_tree  # noqa: E402
from test_costs import MOST_SECONDS, read_ledger, whole_of  # noqa: E402

LEDGER = ROOT / "tests" / "budget.txt"


class Ledger(unittest.TestCase):
    def test_each_program_has_its_line_and_no_other_has_one(self):
        reach = reach_of_tree()
        programs = {*reach.of_ctest(reach.entries), "build"}
        self.assertEqual({*read_ledger(LEDGER)[1]} ^ programs, set(), "run PHOTOND_NEW_BUDGET=FILE tests/run")

    def test_the_whole_with_all_reserves_is_within_its_limit(self):
        _, programs, reserves = read_ledger(LEDGER)
        whole = whole_of(programs, reserves)
        self.assertLessEqual(whole, MOST_SECONDS,
                             "take what is new from its issue's reserve, or say in the commit what you take out instead")
        self.assertTrue(all(re.fullmatch(r"\d+", issue) for issue in reserves), "a reserve names its issue's number")

    def test_what_is_no_line_of_a_ledger_is_refused(self):
        good = "calibration 0.1\nreserved 7 20\nbuild 100\nunit.core 1.5\n"
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "budget.txt"
            file.write_text("# a remark\n\n" + good)
            _, programs, reserves = read_ledger(file)
            self.assertEqual(whole_of(programs, reserves), 121.5)
            for line in ("unit.core 2", "unit.film", "unit.film one", "reserved 7 5", "reserved 8", "unit.film 1 2"):
                file.write_text(good + line + "\n")
                with self.assertRaises(ValueError, msg=line):
                    read_ledger(file)


if __name__ == "__main__":
    unittest.main()
