import re
import shutil
import subprocess

import pytest

from plant_bench.reports.leaderboard.columns import leaderboard_frame
from plant_bench.reports.leaderboard.latex import latex_escaped, latex_text
from plant_bench.reports.leaderboard.markdown import markdown_escaped, markdown_text

HOSTILE = (
    r"\input{/etc/passwd} $x$ 100% a_b #1 {x} ~^ & <script>|`[a](b)`",
    "😀 名前 \u202eabc\u2028",
    "x" * 10_000,
    "line\nline",
)


@pytest.fixture
def made(tmp_path, write_run, leaderboard):
    runs = [write_run(tmp_path / str(n), name, worse=2 + n) for n, name in enumerate(HOSTILE)]
    return leaderboard(runs, paper=True)


def test_untrusted_names_do_not_break_markdown_tables(made):
    rows = [line for line in markdown_text(made).splitlines() if line.startswith("| ")]
    scores = [row for row in rows if re.search(r"\| (objects|privileged|sensors) \|", row)]
    assert len(scores) == 4 + 9
    assert {len(re.findall(r"(?<!\\)\|", row)) for row in scores} == {12}
    assert "<script" not in markdown_text(made)


def test_long_names_are_truncated(made):
    assert max(map(len, markdown_text(made).splitlines())) < 500
    assert "xxx…" in markdown_text(made)


def test_untrusted_names_cannot_insert_latex_commands(made):
    text = latex_text(made)
    assert r"\input" not in text
    assert "U+1F600" in text
    assert text.isprintable() or all(ord(letter) < 256 for letter in text)


def test_special_characters_are_escaped():
    assert latex_escaped("a_b") == r"a\_b"
    assert markdown_escaped("a*b") == r"a\*b"


def test_best_value_of_a_column_is_bold(tmp_path, write_run, leaderboard):
    runs = [write_run(tmp_path / name, name, worse=worse) for name, worse in (("a", 1), ("b", 3))]
    rows = [line for line in latex_text(leaderboard(runs)).splitlines() if "objects" in line]
    assert [row.split(" & ")[2].startswith(r"\textbf") for row in rows] == [True, False]
    assert [row.split(" & ")[5].startswith(r"\textbf") for row in rows] == [True, False]


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_latex_compiles(made, tmp_path):
    document = tmp_path / "document.tex"
    body = latex_text(made)
    document.write_text(
        "\\documentclass{article}\\usepackage{booktabs}\\usepackage[T1]{fontenc}\n"
        f"\\begin{{document}}\n{body}\n\\end{{document}}\n",
        encoding="utf-8",
    )
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", document.name]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]


def test_caption_says_if_only_some_routes_were_driven(tmp_path, write_run, leaderboard):
    path = write_run(tmp_path / "a", repetitions=1)
    complete = latex_text(leaderboard([path]))
    for record in sorted((path / "episodes").iterdir())[2:]:
        record.unlink()
    made = leaderboard([path])

    assert "over 1 repetition." in complete
    assert "over 1 repetition of 2 of 6 routes." in latex_text(made)
    frame = leaderboard_frame(made)
    assert (frame["routes"][0], frame["suite_routes"][0]) == (2, 6)
