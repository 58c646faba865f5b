"""What mutate says of files whose every mutant is known."""
import contextlib
import io
import pathlib
import tempfile
import types
import unittest

import mutate
import mutants

SOURCE = """#include <stdint.h>
static const int table[3] = {10, 20, 30};
#define LIMIT 3u
int entry(unsigned i)
{
    return i < LIMIT ? table[i] : -1;
}
int sum(const int *values, int n)
{
    int all = 0;
    for (int i = 0; i < n; i++) {
        all += values[i];
    }
    return all;
}
"""

TEST = """#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>
int entry(unsigned i);
int sum(const int *values, int n);
static void entries_are(void **state)
{
    (void)state;
    assert_int_equal(entry(0), 10);
    assert_int_equal(entry(1), 20);
    assert_int_equal(entry(2), 30);
    assert_int_equal(entry(3), -1);
}
static void sums_are(void **state)
{
    int *values = malloc(2 * sizeof *values);
    (void)state;
    values[0] = 4;
    values[1] = 1;
    assert_int_equal(sum(values, 2), 5);
    free(values);
}
int main(void)
{
    const struct CMUnitTest tests[] = {%s};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
"""
BOTH = "cmocka_unit_test(entries_are), cmocka_unit_test(sums_are)"


class Run:
    """One run over SOURCE or the like, with some of the tests."""

    def __init__(self, source=SOURCE, tests=BOTH, listed="", **options):
        with tempfile.TemporaryDirectory() as d:
            d = pathlib.Path(d)
            (d / "thing.c").write_text(source)
            (d / "test_thing.c").write_text(TEST % tests)
            (d / "survivors.txt").write_text(listed)
            house = mutate.House(d, d / "out", [d / "thing.c"],
                                 {"test_thing": d / "test_thing.c"})
            options = types.SimpleNamespace(**{"jobs": 2, "file": [], "sample": 100.0, "seed": "1",
                                               "again": None, "unlisted": False, "verbose": True,
                                               "last": d / "out/last.json", **options})
            text = io.StringIO()
            with contextlib.redirect_stdout(text):
                self.good = mutate.work([(house, [d / "thing.c"])],
                                        mutate.Survivors(d / "survivors.txt"), options)
        self.text = text.getvalue()
        self.last = self.text.splitlines()[-1]

    def fate(self, mutant):
        found = [line for line in self.text.splitlines()
                 if line.startswith("thing.c:") and f"{mutant}: " in line]
        assert len(found) == 1, (mutant, found, self.text)
        return found[0].split(f"{mutant}: ")[1].split()[0]


def find_all(source):
    """The mutants of a function's body."""
    with tempfile.NamedTemporaryFile("w", suffix=".c") as f:
        f.write(source)
        f.flush()
        all_of_them = mutants.Finder(f.name, []).find()
    mutants.label(all_of_them)
    return all_of_them


def found(source):
    """Their names."""
    return [m.name for m in find_all(source)]


class Mutation(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.full = Run()

    def test_what_a_test_notices_is_killed(self):
        before = "entry: return i < LIMIT ? table[i] : -1 => return "
        for mutant in (before + "i <= LIMIT ? table[i] : -1",
                       before + "i < (LIMIT - 1) ? table[i] : -1",
                       "sum: all += values[i] => all -= values[i]",
                       "sum: delete: all += values[i];",
                       "sum: int all = 0 => int all = 1"):
            self.assertEqual(self.full.fate(mutant), "killed", mutant)

    def test_an_entry_of_a_table_is_compiled_by_itself(self):
        before = "table: static const int table[3] = {10, 20, 30} => static const int "
        for after in ("table[3] = {10, 21, 30}", "table[3] = {10, 20, 29}",
                      "table[3 - 1] = {10, 20, 30}"):
            self.assertEqual(self.full.fate(before + after), "killed")

    def test_a_loop_without_end_is_killed(self):
        self.assertEqual(self.full.fate("sum: i++ => i--"), "killed")

    def test_what_no_test_looks_at_survives(self):
        one = Run(tests="cmocka_unit_test(entries_are)")
        self.assertEqual(one.fate("sum: i < n => i >= n"), "unreached")
        self.assertFalse(one.good)

    def test_a_read_past_the_end_is_killed_though_the_sum_is_right(self):
        source = SOURCE.replace("values[i];", "i < 2 ? values[i] : 0 & ((volatile int *)values)[i];")
        self.assertEqual(Run(source=source).fate("sum: i < n => i <= n"), "killed")

    def test_what_compiles_to_the_same_code_does_not_count(self):
        source = SOURCE.replace("return all;", "return n < 0 ? all : all;")
        self.assertEqual(Run(source=source).fate("n < 0 ? all : all => return n <= 0 ? all : all"),
                         "equivalent")

    def test_without_tests_nothing_is_killed(self):
        none = Run(tests="{0}")
        self.assertFalse(none.good)
        self.assertRegex(none.last, r"^FAIL: 0 of \d+ mutants killed, 0\.0 %")

    def test_a_survivor_has_to_be_listed(self):
        source = SOURCE.replace("int all = 0;", "int all = 0;\n    if (n > 1000) {\n"
                                                "        n = 1000;\n    }")
        news = [line for line in Run(source=source).text.splitlines()
                if line.startswith("thing.c:sum: ")]
        self.assertTrue(any("n > 1001" in line for line in news), news)
        listed = "".join(f"{line}\n" for line in news) + "    No test has as many.\n"
        again = Run(source=source, listed=listed)
        self.assertIn(" 0 survivors not listed", again.last)
        self.assertNotIn("to be removed", again.text)

    def test_what_is_listed_and_killed_is_to_be_removed(self):
        run = Run(listed="thing.c:sum: i < n => i >= n\n    It is said.\n"
                         "thing.c:sum: gone => away\n    It was said.\n"
                         "other.c:sum: gone => away\n    It was said.\n")
        self.assertFalse(run.good)
        self.assertIn("thing.c:sum: i < n => i >= n: killed by test_thing", run.text)
        self.assertIn("thing.c:sum: gone => away: no such mutant", run.text)
        self.assertIn("other.c:sum: gone => away: no such file", run.text)

    def test_what_is_listed_counts_as_a_survivor_without_a_try(self):
        name = "thing.c:sum: i < n => i >= n"
        run = Run(listed=f"{name}\n    It is said.\n", unlisted=True)
        self.assertTrue(run.good)
        self.assertEqual(run.fate("sum: i < n => i >= n"), "survived")
        self.assertNotIn("to be removed", run.text)
        gone = Run(listed="thing.c:sum: gone => away\n    It was said.\n", unlisted=True)
        self.assertIn("thing.c:sum: gone => away: no such mutant", gone.text)

    def test_a_listed_survivor_needs_a_reason(self):
        with self.assertRaisesRegex(mutate.Trouble, "has no reason"):
            Run(listed="thing.c:sum: i < n => i >= n\n")

    def test_a_sample_is_the_same_for_the_same_seed(self):
        all_of_them = [types.SimpleNamespace(name=str(i)) for i in range(1000)]
        picked = [mutate.chosen(all_of_them, 10.0, seed) for seed in ("a", "a", "b")]
        self.assertEqual(picked[0], picked[1])
        self.assertNotEqual(picked[0], picked[2])
        self.assertTrue(50 < len(picked[0]) < 150)

    def test_a_test_that_fails_by_itself_is_no_killer(self):
        with self.assertRaisesRegex(mutate.Trouble, "fails as it is"):
            Run(source=SOURCE.replace("20", "21"))


class Finding(unittest.TestCase):
    def test_conditions_without_an_operator_are_negated(self):
        self.assertEqual(
            found("_Bool a(int), b(int);\nint f(int x) { if (a(x) && !b(x)) { x = 2; } return x; }"),
            ["f: delete all of: if (a(x) && !b(x))", "f: a(x) && !b(x) => !(a(x)) && !b(x)", "f: a(x) && !b(x) => a(x) || !b(x)",
             "f: a(x) && !b(x) => a(x) && !!b(x)", "f: delete: x = 2;", "f: x = 2 => x = 1",
             "f: x = 2 => x = 3", "f: return x => return 0"])

    def test_a_macro_is_mutated_where_it_is_used(self):
        self.assertEqual(found("#define N (1 << 4)\nint f(int x) { return x + N; }"),
                         ["f: return x + N => return 0", "f: return x + N => return x - N",
                          "f: return x + N => return x + (N + 1)",
                          "f: return x + N => return x + (N - 1)"])

    def test_cases_and_sizes_are_constants(self):
        names = found("int f(int x) { char c[4]; switch (x) { case 7: c[0] = 1; return c[0]; "
                      "default: return 5; } }")
        self.assertIn("f: 7 => 8", names)
        self.assertIn("f: char c[4] => char c[4 - 1]", names)
        self.assertIn("f: delete: c[0] = 1;", names)
        self.assertIn("f: delete: return c[0];", names)

    def test_what_a_shuffle_takes_is_constant(self):
        those = find_all("typedef int four __attribute__((vector_size(16))); "
                         "four f(four a, four b) { return __builtin_shufflevector(a, b, 0, 4, 1, 5); }")
        self.assertEqual([m.text for m in those if not m.runtime],
                         ["(0 - 1)", "1", "3", "5", "0", "2", "4", "6"])
        self.assertTrue(any(m.runtime for m in those))

    def test_another_variable_of_the_same_type_that_can_be_named(self):
        self.assertCountEqual(
            [n for n in found("int g(int); int f(int a, long b, const int c) { int d; if (a) { int x = 1; "
                              "g(x); } d = a; return d; }") if "=> " in n and "1" not in n],
            ["f: a => !(a)", "f: a => c", "f: g(x) => g(a)", "f: g(x) => g(c)", "f: d = a => a = a",
             "f: d = a => d = c", "f: return d => return 0", "f: return d => return a",
             "f: return d => return c"])

    def test_another_field_of_the_same_struct_and_type(self):
        self.assertCountEqual(
            found("struct s { int a, b; long c; const int *p, *q; };\n"
                  "void f(struct s *x, struct s y) { x->a = y.b; x->c = *y.p; }"),
            ["f: delete: x->a = y.b;", "f: x->a = y.b => x->b = y.b", "f: x->a = y.b => x->a = y.a",
             "f: delete: x->c = *y.p;", "f: x->c = *y.p => x->c = *y.q"])

    def test_the_other_eye_and_one_eye_for_both(self):
        self.assertCountEqual(
            found("struct s { int eye[2]; }; void g(unsigned, int);\n"
                  "void f(struct s *p, unsigned i) { g(0, p->eye[i]); }\n"
                  "void h(unsigned eye) { g(eye, 0); }"),
            ["f: delete: g(0, p->eye[i]);", "f: g(0, p->eye[i]) => g(1, p->eye[i])",
             "f: g(0, p->eye[i]) => g((0 - 1), p->eye[i])",
             "f: g(0, p->eye[i]) => g(0, p->eye[(1 - (i))])", "f: g(0, p->eye[i]) => g(0, p->eye[0])",
             "f: g(0, p->eye[i]) => g(0, p->eye[1])", "h: delete: g(eye, 0);",
             "h: g(eye, 0) => g((1 - (eye)), 0)", "h: g(eye, 0) => g(0, 0)",
             "h: g(eye, 0) => g(1, 0)", "h: g(eye, 0) => g(eye, 1)",
             "h: g(eye, 0) => g(eye, (0 - 1))"])

    def test_a_whole_statement_is_left_out_but_the_last_that_has_the_result(self):
        names = found("int g(int);\nint f(int n) { for (int i = 0; i < n; i++) { g(i); } do { n++; } "
                      "while (n < 3); switch (n) { case 1: return 2; default: return 3; } }")
        self.assertEqual([n for n in names if "delete all of" in n],
                         ["f: delete all of: for (int i = 0; i < n; i++)",
                          "f: delete all of: while (n < 3);"])

    def test_a_real_number_is_doubled_and_nothing(self):
        self.assertCountEqual(found("float f(float x) { return 0.5f * x; }"),
                         ["f: return 0.5f * x => return 0.5f / x",
                          "f: return 0.5f * x => return (0 * 0.5f) * x",
                          "f: return 0.5f * x => return (2 * 0.5f) * x"])


class Rooms(unittest.TestCase):
    def test_every_file_is_in_one_room_and_has_tests(self):
        rooms = mutate.all_rooms(pathlib.Path("out"))
        files = [f.name for _, paths in rooms for f in paths]
        self.assertEqual(len(files), len(set(files)))
        for name in ("assembler.c", "points.c", "normal.c", "gateway.c", "zone.c", "heart.c", "ring.c"):
            self.assertIn(name, files)
        self.assertNotIn("main.c", files)
        self.assertEqual([h.name for h, _ in rooms if not h.tests], [])

    def test_files_and_directories_choose_rooms(self):
        rooms = mutate.all_rooms(pathlib.Path("out"))
        asked = [mutate.ROOT / "src/points", mutate.ROOT / "src/core/words.c"]
        picked = mutate.select(rooms, asked)
        self.assertEqual([h.name for h, _ in picked], ["core", "points"])
        self.assertEqual([p.name for p in picked[0][1]], ["words.c"])
        self.assertIn("smooth.c", [p.name for p in picked[1][1]])
        with self.assertRaisesRegex(mutate.Trouble, "is in no room"):
            mutate.select(rooms, [mutate.ROOT / "script/mutate"])


if __name__ == "__main__":
    unittest.main()
