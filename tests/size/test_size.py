"""What script/size says of figures; what it reads it wrote."""

import contextlib
import io
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import size  # noqa: E402


def table(value, is_better_higher=False):
    out = size.Table("Things", "thing", ["one", "two"], decimals=1, is_better_higher=is_better_higher)
    out.put("**a thing**", "one", value)
    out.put("**a thing**", "two", 1234.5)
    return out


def faults(old, new, is_better_higher=False):
    tables = [table(new, is_better_higher)]
    return size.grown(tables, size.parse(table(old).render()), size.parse(tables[0].render()))


class Figures(unittest.TestCase):
    def test_what_is_written_is_read(self):
        self.assertEqual(size.parse(table(7).render()), {("Things", "**a thing**", "one"): 7.0,
                                                         ("Things", "**a thing**", "two"): 1234.5})

    def test_two_percent_may_be_added_and_no_more(self):
        self.assertEqual(faults(1000, 1020), [])
        self.assertEqual(len(faults(1000, 1020.1)), 1)
        self.assertEqual(faults(1000, 10), [])

    def test_a_rate_may_fall_by_two_percent_and_no_more(self):
        self.assertEqual(faults(1000, 980, True), [])
        self.assertEqual(len(faults(1000, 979.9, True)), 1)
        self.assertEqual(faults(1000, 5000, True), [])

    def test_figures_that_come_and_go_are_named(self):
        one, two = {("a", "b", "c"): 1.0}, {("a", "b", "d"): 1.0}
        self.assertEqual(len(size.grown([], one, two)), 2)

    def test_a_bar_holds_whatever_the_table_says(self):
        figures = {tuple(key): bar for *key, bar in size.BARS}
        self.assertEqual(size.over_bars(figures), [])
        figures["Stack, bytes", "**the core**", "M4F -O2"] = 257
        self.assertEqual(size.over_bars(figures), ["Stack, bytes, the core, M4F -O2: 257 is over the bar of 160"])

    def test_growth_is_a_failing_status(self):
        tables = [table(size.BARS[0][-1])]
        new = {**{tuple(key): bar for *key, bar in size.BARS}}
        body = "\n".join(t.render() for t in tables)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(size.check(tables, body, new, ""), 1)


class Programs(unittest.TestCase):
    def test_a_file_is_linked_in_place_of_another(self):
        usual, fixed = size.linked(), size.linked(["layout_fixed"])
        self.assertEqual(set(usual) - set(fixed), {"layout_any"})
        self.assertEqual(set(fixed) - set(usual), {"layout_fixed"})

    def test_readings_of_the_clock_are_not_counted(self):
        output = "loop 810 1 1000\nnothing 100 10 10\nwhat was found\na_packet 1640 4 10\n"
        self.assertEqual(size.instructions(output), {"a_packet": 200.0})


class Stacks(unittest.TestCase):
    frames = {"lum_a": 8, "b": 16, "c": 4, "memcpy": 24}
    calls = {"lum_a": {"b", "c"}, "b": {"memcpy"}, "c": set(), "memcpy": set()}

    def test_the_deepest_way_counts(self):
        self.assertEqual(size.deepest("lum_a", self.frames, self.calls, {}, []), (48, ["lum_a", "b", "memcpy"]))

    def test_recursion_is_refused(self):
        with self.assertRaisesRegex(size.Failure, "recursion: lum_a -> b -> lum_a"):
            size.deepest("lum_a", self.frames, {**self.calls, "b": {"lum_a"}}, {}, [])

    def test_a_call_to_what_nobody_knows_is_refused(self):
        with self.assertRaisesRegex(size.Failure, "a pointer"):
            size.deepest("lum_a", self.frames, {**self.calls, "c": {"__indirect_call"}}, {}, [])
        with self.assertRaisesRegex(size.Failure, "not known"):
            size.deepest("lum_a", self.frames, {**self.calls, "c": {"puts"}}, {}, [])

    def test_registers_of_a_push_are_counted(self):
        self.assertEqual(len(size.expand("r4, r5, lr")), 3)
        self.assertEqual(len(size.expand("r4-r7, lr")), 5)


if __name__ == "__main__":
    unittest.main()
