# SPDX-License-Identifier: Apache-2.0
"""The report says what its parts measured, and the README what the report says: report_test.py Analysis, Readme, or Page,
which ends with 77 where gnuplot is missing."""

import datetime
import html.parser
import itertools
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data" / "report"
PROGRAM = ROOT / "bench" / "report" / "report.py"
sys.dont_write_bytecode = True
sys.path.insert(0, str(PROGRAM.parent))

import analysis  # noqa: E402
import documents  # noqa: E402
import headlines  # noqa: E402


DATES = datetime.date(2026, 1, 2), datetime.date(2026, 1, 3)


def point(method, error, us, **flags):
    return {"method": method, "setting": "", "error": error, "us": us, **flags}


def work(*cases, choice="a choice"):
    return {"kind": "work_precision", "choice": choice,
            "cases": [{"name": str(i), "points": list(points)} for i, points in enumerate(cases)]}


class Analysis(unittest.TestCase):
    def test_the_front_is_what_no_other_point_beats(self):
        dice = random.Random(1)
        for _ in range(100):
            # Few values, so that there are ties.
            points = [point("m", dice.randint(0, 5), dice.randint(1, 6)) for _ in range(12)]
            front = analysis.front(points)
            for p in points:
                place = p["us"], p["error"]
                others = [(q["us"], q["error"]) for q in points if (q["us"], q["error"]) != place]
                beaten = any(us <= p["us"] and error <= p["error"] for us, error in others)
                self.assertEqual(not beaten, any((f["us"], f["error"]) == place for f in front))
            self.assertEqual(front, sorted(front, key=lambda p: p["us"]))

    def test_what_has_no_number_is_on_no_front(self):
        self.assertEqual(analysis.front([point("no error", None, 1.0), point("no time", 0.0, None)]), [])

    def test_a_default_is_held_against_ours_that_are_as_accurate(self):
        figure = work([point("default", 1e-6, 3.0, default=True), point("as accurate", 1e-6, 2.0),
                       point("more accurate", 1e-9, 2.5), point("less accurate", 2e-6, 0.5),
                       point("a peer", 1e-9, 0.1, peer=True), point("published", 1e-9, 0.2, published=True),
                       point("without an error", None, 0.1)])
        (case, _, ratio, best), = analysis.default_ratios(figure)
        self.assertEqual((case, ratio, best["method"]), ("0", 1.5, "as accurate"))

    def test_a_default_alone_is_on_its_front(self):
        for flags in ({}, {"published": True}):
            (_, _, ratio, _), = analysis.default_ratios(work([point("default", 0.0, 3.0, default=True, **flags)]))
            self.assertEqual(ratio, 1.0)

    def test_errors_of_rounding_are_alike(self):
        points = [point("fast", 9e-13, 1.0), point("slow", 1e-16, 9.0), point("coarse", 1.1e-12, 0.9)]
        self.assertEqual([p["method"] for p in analysis.front(points)], ["coarse", "fast"])
        self.assertEqual(analysis.ratio_to_front(points[1], points)[0], 9.0)

    def test_needed_is_what_nothing_else_comes_near_in_some_case_or_what_is_near_in_three(self):
        def one(mine, other=(1e-6, 1.0)):
            return [point("mine", *mine), point("other", *other)]

        for mine in ((1e-6, 0.89), (0.8e-6, 1.0)):  # Faster, or more accurate, by more than 10 %.
            self.assertEqual(analysis.not_needed([work(one(mine)), work(one((1e-6, 9.0)))]), [])
        # Nearly as fast and as accurate as the other on so many scenes, and beaten by it on the others.
        for near, unneeded in ((2, ["mine"]), (3, [])):
            figure = work(*[one((1e-6, 1.09))] * near, one((1e-6, 1.2), (1e-6, 0.5)))
            self.assertEqual(analysis.not_needed([figure]), unneeded)
        for mine in ((1e-6, 0.95), (0.95e-6, 1.0)):  # Better, by less than 10 %.
            self.assertEqual(analysis.not_needed([work(one(mine), one((1e-3, 9.0)))]), ["mine"])

    def test_needed_is_asked_neither_of_the_published_model_nor_of_what_is_not_ours(self):
        figure = work([point("best", 1e-6, 1.0), point("paper", 1e-3, 9.0, published=True),
                       point("peer", 1e-9, 0.1, peer=True), point("no answer", None, 0.1)])
        self.assertEqual(analysis.not_needed([figure]), ["no answer"])

    def test_fewer_than_three_scenes_are_a_verdict_of_their_own(self):
        def ratios(*values):
            return [("a case", {}, value, {}) for value in values]

        for values, kind in (((1.0, 1.0), "few"), ((1.0, 9.0, 1.0, 1.1), "good"), ((1.0, 1.0, 1.2), "bad")):
            self.assertEqual(analysis.verdict(ratios(*values))[0], kind)

    def test_headlines_are_taken_from_the_figures_that_have_them(self):
        def part(name, *figures):
            return {"part": name, "figures": [{"kind": "table", "id": "", **figure} for figure in figures]}

        parts = [
            part("published", {"columns": ["computation", "published [us]", "here, median [us]", "times as fast",
                                           "left when the hardware is taken out", "accuracy here"],
                               "rows": [["contact computation, 15 contacts", 6000, 30.0, 200.0, "15 to 110", "1e-7"],
                                        ["contact computation, 60 contacts", 20000, 77.24, 259.0, "19 to 147",
                                         "force: Hertz 0.8 %, solver 2e-06; residual 8e-7, worst 1e-6"],
                                        ["muscle forces", "-", 1.0, "-", "-", "KKT 3e-15"]]}),
            part("stability", {"columns": ["setting", "way", "ratio held", "what becomes of it"],
                               "rows": [["step", "down", "1", "refused: too short"],
                                        ["gain", "up", "3.95", "unstable: chatter; and more"],
                                        ["friction", "down", "1.58", "slipping: by 1 mm; so"],
                                        ["mass", "down", "1.2", "holds to the end"]]}),
            part("stiffness", {"columns": ["grasp", "their effort, times the least", "runs off the stiffness [%]",
                                           "and off its least effort [%]"],
                               "rows": [["box", 1.53, 1.2, 0.1], ["handle", 2.06, 0.8, 0.4], ["plate", None, 3.0, 9.0]]}),
            part("model", {"columns": ["scene", "left out", "times as fast"],
                           "rows": [["a", "x", "1.8"], ["b", "", "15.6"]]}),
            part("growth", {"kind": "curves", "id": "growth_computation", "panels": [{"curves": [
                {"name": "in all", "exponent": 1.4}, {"name": "find", "exponent": 9}]}]}),
            part("contact_families", {"columns": ["family", "solver", "said solved", "said none", "no answer"],
                                      "rows": [["easy", "sweeps", 10, 0, 0], ["peg", "sweeps", 3, 1, 6]]}),
        ]
        self.assertEqual(headlines.headlines(parts), [
            "Contact computation, 60 contacts: 77.2 µs (published 20 ms), forces 0.8 % off Hertz, solved to 2e-06.",
            "Nearest edge of the reference scene: friction may go down 1.58 times, no further (slipping: by 1 mm).",
            "A stiffness that is chosen: runs of 2 grasps have it within 1.2 %, at an effort within 0.4 % of the least; "
            "all muscles raised alike take up to 2.06 times as much.",
            "`model: auto` makes 2 scenes 1.8 to 15.6 times as fast, within their tolerance.",
            "Growth: the contact computation over contacts n^1.40."])
        self.assertEqual(len(headlines.published(parts)), 2)
        self.assertEqual(headlines.unanswered(parts), ["sweeps: 6 of 20 (peg 6)"])
        self.assertEqual(headlines.headlines([]) + headlines.published([]) + headlines.unanswered([]), [])

    def test_scenes_have_the_first_sentence_of_their_file(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "a.yaml").write_text("# A plate of 1.5 mm\n# is held. It slips.\nname: a\n")
            (Path(folder) / "hand.yaml").write_text("# A hand.\n")
            self.assertEqual(analysis.scenes(folder), [("a", "A plate of 1.5 mm is held.")])

    def test_reasons_count_as_one_whose_first_clause_differs_in_numbers_alone(self):
        def unstable(reason):
            return {"outcome": "unstable", "reason": reason}

        panel = {"cells": [[{"outcome": "held", "reason": ""}, unstable("30 mm off at 1e-3 s; so")],
                           [{"outcome": "free", "reason": ""}, {"outcome": "two points", "reason": ""}],
                           [unstable("-3.5 mm off at 2 s"), unstable(None)]]}
        self.assertEqual([(outcome, count) for outcome, count, _ in analysis.failures(panel)],
                         [("unstable", 2), ("unstable", 1)])
        self.assertEqual(analysis.outcome_counts(panel), {"held": 1, "free": 1, "two points": 1, "unstable": 3})

    def test_sections_have_every_figure_once_and_name_what_is_missing(self):
        parts = analysis.read_parts(DATA)
        layout = analysis.sections(parts)
        ids = [figure["id"] for _, groups, _ in layout for _, figures in groups for figure in figures]
        self.assertEqual(sorted(ids), sorted(figure["id"] for part in parts for figure in part["figures"]))
        self.assertEqual([title for title, groups, _ in layout if any("growth_contacts" == figure["id"]
                          for _, figures in groups for figure in figures)], ["Growth"])
        self.assertEqual(layout[-1][0], "Others")
        self.assertEqual([name for _, _, missing in layout for name in missing],
                         ["limits", "truth", "grasp_force", "muscle", "finding", "pulp", "rate", "motion", "curved_surface", "edges",
                          "contact_families",
                          "partial_slip", "reflex", "felt_margin", "pose_loop", "stiffness", "untuned_stiffness", "task",
                          "insertion", "model",
                          "grasp_finding",
                          "environment", "growth", "contact_growth", "compression"])

    def test_numbers_are_short(self):
        for value, shown in ((0, "0"), (0.0, "0"), (None, "–"), (1.0, "1"), (0.00123456, "0.00123"), (99999.0, "1e5"),
                             (63.04, "63"), (1234.5, "1230"), (2e-15, "2e-15"), (-0.5, "-0.5"), (36000, "36\u202f000")):
            self.assertEqual(analysis.number(value), shown)

    def test_a_broken_part_is_one_error_that_names_file_and_key(self):
        part = json.loads((DATA / "contact.json").read_text())
        breaks = {
            "lacks 'title'": lambda: part.pop("title"),
            "figure 'contact_residual': lacks 'cases'": lambda: part["figures"][0].pop("cases"),
            "no kind is named 'pie'": lambda: part["figures"][0].update(kind="pie"),
        }
        for message, break_it in breaks.items():
            part = json.loads((DATA / "contact.json").read_text())
            break_it()
            self.refused(json.dumps(part), message)
        self.refused('{"part": ', "part.json")
        self.refused('{"benchmarks": []}', "no part")

    def test_documents_have_every_table_of_the_report_and_say_what_it_was_measured_on(self):
        parts = analysis.read_parts(DATA)
        page = documents.measured(parts, DATES)
        for text in ("a processor, 2 hardware threads, GNU 12.2.0, `-O3 -march=x86-64-v3`, Thenar 0.6.0, a quick "
                     "measurement, 2026-01-02 to 2026-01-03", "| grasp forces | 40 | 0.4 | 0.9 | 100 | 7 to 60 | KKT error 1e-15 |",
                     "What published shows, & more: `a_key` \\<b\\>.", "two: 1.50 times the time of exact",
                     "Not measured: `grasp_force`, `muscle`"):
            self.assertIn(text, page)
        for figure in (figure for part in parts for figure in part["figures"] if figure["kind"] == "table"):
            for row in figure["rows"]:
                self.assertIn(documents.table(figure["columns"], figure["rows"]), page)
        # Every row of a table has as many cells as its head.
        for block in re.findall(r"(?:^\|.*\n)+", page, re.MULTILINE):
            self.assertEqual(len({len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()}), 1, block)
        self.assertEqual(page, documents.measured(parts, DATES))

    def test_text_of_a_part_is_no_markup(self):
        for value, shown in (("a|b", "a\\|b"), ("`a|b` c_d _e_", "`a\\|b` c_d \\_e\\_"), ("two\nlines", "two lines"),
                             ("3 * 4 [x](y)", "3 \\* 4 [x]\\(y)"), ("f_{ij} `", "f\\_{ij} \\`")):
            self.assertEqual(documents.text(value), shown)

    def test_a_case_shows_its_default_and_the_best_of_each_other_method(self):
        figure = {**work([point("ours", 1e-6, 3.0, default=True), point("ours", 1e-9, 9.0),
                          point("peer", 1e-7, 8.0, peer=True), point("peer", 1e-6, 7.0, peer=True),
                          point("coarse", 1e-2, 0.1), point("coarse", 1e-3, 0.2), point("broken", None, 0.1)]),
                  "error": "error", "time": "time"}
        rows = documents._work_precision(figure).splitlines()[2:]
        self.assertEqual([[cell.strip() for cell in row.split("|")[2:5]] for row in rows],
                         [["ours", "1e-6", "3"], ["peer", "1e-6", "7"], ["coarse", "0.001", "0.2"]])

    def test_the_readme_keeps_all_but_what_is_between_the_markers(self):
        with tempfile.TemporaryDirectory() as root:
            readme, page = Path(root) / "README.md", Path(root) / "docs" / "measured.md"
            page.parent.mkdir()
            before, after = "# A\n\n", "\n\nthe rest\n"
            readme.write_text(f"{before}{documents.BEGIN}\nold\n{documents.END}{after}")
            parts = analysis.read_parts(DATA)
            for _ in range(2):  # Once more changes nothing.
                documents.write(Path(root), parts, DATES)
                table = documents.readme_table(parts, DATES)
                self.assertEqual(readme.read_text(), f"{before}{documents.BEGIN}\n{table}\n{documents.END}{after}")
            self.assertIn("| grasp forces | 40 µs | 0.4 µs | 0.9 µs | KKT error 1e-15 |", table)
            self.assertIn("| display |  | 13 µs | 21 µs | exact |", table)
            self.assertIn("# Measured", page.read_text())

    def test_the_readme_has_each_computation_once(self):
        rows = [["grasp forces", 40, 0.3, 0.6, "KKT 3e-16"], ["grasp forces, cones active", 40, 1.8, 2.0, "KKT 1e-12"],
                ["contact computation, 60 contacts", 20000, 118.0, 12345.6, "residual 1e-7"],
                ["muscle forces", "-", 1.5, 2.7, "KKT 3e-15"]]
        part = {"part": "published", "measured": {"machine": "a machine"}, "figures": [
            {"kind": "table", "columns": ["computation", "published", "median", "p99", "accuracy"], "rows": rows}]}
        self.assertEqual(documents.readme_table([part], DATES[:1] * 2).splitlines()[2:], [
            "| grasp forces | 40 µs | 0.3 µs | 0.6 µs | KKT 3e-16 |",
            "| contact computation, 60 contacts | 20 ms | 118 µs | 12.3 ms | residual 1e-7 |",
            "| muscle forces |  | 1.5 µs | 2.7 µs | KKT 3e-15 |", "",
            "Measured on a machine, Thenar, 2026-01-02. [All tables](docs/measured.md)."])

    def test_documents_are_left_alone_where_something_is_missing(self):
        parts = analysis.read_parts(DATA)
        without = [part for part in parts if part["part"] != "published"]
        good = f"{documents.BEGIN}\nold\n{documents.END}\n"
        for text, measured in (("no markers\n", parts), (good + good, parts), (good, without),
                               (f"{documents.BEGIN}\n{good}", parts), (f"{good}{documents.END}\n", parts),
                               (f"{documents.END}\n{documents.BEGIN}\n", parts)):
            with tempfile.TemporaryDirectory() as root:
                (Path(root) / "docs").mkdir()
                (Path(root) / "README.md").write_text(text)
                with self.assertRaises(analysis.ReportError):
                    documents.write(Path(root), measured, DATES)
                self.assertEqual((Path(root) / "README.md").read_text(), text)
                self.assertEqual(list((Path(root) / "docs").iterdir()), [])

    def refused(self, content, message):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "part.json").write_text(content)
            run = subprocess.run([sys.executable, "-B", PROGRAM, folder], capture_output=True, text=True)
            self.assertEqual(run.returncode, 3)
            self.assertIn(message, run.stderr)
            self.assertEqual(len(run.stderr.splitlines()), 1)


class Readme(unittest.TestCase):
    """What the README says of itself and of MuJoCo on the same bodies is what docs/measured.md has."""

    def measured(self, title):
        """{(engine, setting): {column: cell}} of a table of docs/measured.md."""
        lines = (ROOT / "docs" / "measured.md").read_text(encoding="utf-8").split(f"### {title}\n")[1].strip().splitlines()
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in itertools.takewhile(len, lines)]
        return {(row[0], row[1]): dict(zip(rows[0], row)) for row in rows[2:]}

    def row(self, name):
        """Thenar's and MuJoCo's cells of a row of the README's comparison."""
        lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
        return next(line for line in lines if line.startswith(f"| {name} |")).split("|")[2:4]

    def test_the_comparison_has_the_measured_creep(self):
        creep = {key: row["M 1.5"] for key, row in self.measured("Hold creep, box").items()}
        ours, theirs = self.row("the box creeps, µm/s")
        self.assertIn(f"{creep['Thenar', 'rigid tips']};", ours)
        self.assertIn(f"pulps {creep['Thenar', 'pulps']}", ours)
        self.assertIn("default: " + creep["MuJoCo now, WebAssembly", "default"].replace("lost", "lost after"), theirs)
        self.assertIn(f"advice: {creep['MuJoCo now, WebAssembly', 'manual: elliptic, impratio 10']};", theirs)
        self.assertIn(f"noslip: {creep['MuJoCo now, WebAssembly', 'manual, and noslip 3']};", theirs)
        self.assertLess(float(creep["MuJoCo now, WebAssembly", "to the last digit"]), 1e-9)  # It says 0.

    def test_the_comparison_has_the_measured_friction(self):
        friction = self.measured("Least friction that holds")
        for key in (("Thenar", "rigid tips"), ("MuJoCo now, WebAssembly", "manual, and noslip 3")):
            self.assertEqual([friction[key][f"box {angle} deg"] for angle in ("0", "22.5", "45")], ["0", "0", "0"])

    def test_the_comparison_has_the_measured_times(self):
        time = {key: row["us"] for key, row in self.measured("Speed").items()}
        ours, theirs = self.row("a step of it")
        self.assertIn(f"{time['Thenar', 'rigid tips']} µs; pulps {time['Thenar', 'pulps']} µs", ours)
        self.assertIn(f"{time['MuJoCo', 'default']} µs; six settings: {time['MuJoCo', 'to the last digit']} µs", theirs)


class Reader(html.parser.HTMLParser):
    """Checks that elements close in order; keeps texts, identifiers and references."""

    VOID = {"meta", "br"}

    def __init__(self, page):
        super().__init__()
        self.open, self.ids, self.references, self.words, self.captions = [], [], [], [], []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name in ("src", "href", "xlink:href", "srcset", "data", "action"):
                self.references.append(value)
            self.references += re.findall(r"url\(([^)]*)\)", value or "")
        if tag == "figcaption":
            self.captions.append("")

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes nothing at {self.getpos()}"

    def handle_data(self, data):
        self.words.append(data)
        if "figcaption" in self.open:
            self.captions[-1] += data


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.pages = [cls.draw(seed) for seed in ("1", "2")]
        cls.page = cls.pages[0].decode()
        cls.read = Reader(cls.page)

    @classmethod
    def draw(cls, hash_seed):
        with tempfile.TemporaryDirectory() as out:
            folder, faults = Path(out) / "bench", Path(out) / "faults"
            folder.mkdir()
            faults.mkdir()
            for file in DATA.glob("*.json"):
                (folder / file.name).write_bytes(file.read_bytes())
            (faults / "faults.json").write_text(json.dumps({"first_seed": 7, "seconds": 600, "exit_codes": {"0": 2},
                                                            "trials": {"twice": 1, "limited": 2}, "findings": ["<a>"]}))
            subprocess.run([sys.executable, "-B", PROGRAM, folder], check=True, capture_output=True,
                           env={**os.environ, "PYTHONHASHSEED": hash_seed})
            return (folder / "report.html").read_bytes()

    def test_faults_stand_in_it_where_they_were_tried(self):
        words = "".join(self.read.words)
        self.assertIn("10 min, seeds from 7 on", words)
        self.assertIn("3 trials of every command: 2 limited, 1 twice", words)
        self.assertIn("<a>", words, "a finding is told, and is no element")
        self.assertNotIn("soak", words)

    def test_the_same_parts_give_the_same_bytes(self):
        self.assertEqual(self.pages[0], self.pages[1])

    def test_every_element_is_closed_and_every_reference_is_within_the_page(self):
        self.assertEqual(self.read.open, [])
        self.assertEqual(len(self.read.ids), len(set(self.read.ids)))
        self.assertEqual([r for r in self.read.references if not (r.startswith("#") and r[1:] in self.read.ids)], [])
        for word in ("http", "src=", "@import", "<script"):
            self.assertNotIn(word, self.page)

    def test_every_figure_has_its_caption_runs_and_number(self):
        figures = [figure for part in analysis.read_parts(DATA) for figure in part["figures"]]
        self.assertEqual(len(self.read.captions), len(figures))
        for figure in figures:
            caption = figure["caption"].replace("`", "")
            self.assertTrue(any(c.startswith(caption) and figure["runs"] in c for c in self.read.captions), caption)
        self.assertEqual(len(re.findall(r"<h4>Figure \d+\. ", self.page)), len(figures))

    def test_what_is_missing_is_named(self):
        said = re.findall("Not measured: (.*?)\\. ", "".join(self.read.words))
        self.assertEqual(said, ["limits", "truth", "grasp_force, muscle, finding, pulp, rate", "motion, curved_surface, edges",
                                "contact_families",
                                "partial_slip, reflex, felt_margin, pose_loop", "stiffness, untuned_stiffness",
                                "task, insertion", "model",
                                "grasp_finding",
                                "environment", "growth, contact_growth, compression"])

    def test_the_summary_tells_defaults_failures_and_candidates_for_deletion(self):
        words = "".join(self.read.words)
        for text in ("fewer than three scenes: on 1 of 2", "two: 1.50 times the time of exact",
                     "contact solver: slow, broken, unmeasured", "3 of 6", "2 unstable: 31 mm off",
                     "Defaults on their front, or within 10 % of it: 1 of 2",
                     "grasp forces: 0.4 µs for 40 µs, 100 times as fast (7 to 60 without the hardware's share); "
                     "KKT error 1e-15",
                     "box_pushThe held box is pushed sideways and comes back.",
                     "1 solver failed: no reason given, which is a defect"):
            self.assertIn(text, words)

    def test_a_verdict_on_single_runs_says_so(self):
        import page

        for runs, once in (("medians of 5 runs", False), ("in 1 rounds", True), ("a single run of each", True),
                           ("medians of 101 rounds", False)):
            figure = {**work([point("m", 1.0, 1.0, default=True)]), "runs": runs}
            html = page.defaults([{"figures": [figure]}], {id(figure): 1})
            self.assertEqual("(one run)" in html, once, runs)

    def test_an_exponent_stays_with_its_curve(self):
        self.assertIn("<span>fast: n<sup>2.00</sup></span></span>", self.page)

    def test_a_law_is_a_black_line_and_scatter_is_a_band(self):
        import drawing

        figure = json.loads((DATA / "contact.json").read_text())["figures"][1]
        (svg,), look = drawing.curves(drawing.Page(), figure)
        self.assertEqual({name: style["color"] == "#000000" for name, style in look.items()},
                         {"fast": False, "other": False, "noisy": False, "law": True})
        self.assertNotIn("marker", look["law"])
        self.assertEqual(len(re.findall(r'<polygon [^>]*fill-opacity = "0.2', svg)), 1)

    def test_panels_are_pictures_with_names(self):
        # Two cases with points, one panel of curves, two of a map.
        panels = re.findall(r'<div class="panel"><svg viewBox="[\d. ]+" role="img" aria-label="[^"]+"', self.page)
        self.assertEqual(len(panels), 5)


if __name__ == "__main__":
    if "Page" in sys.argv and not shutil.which("gnuplot"):
        sys.exit(77)
    unittest.main()
