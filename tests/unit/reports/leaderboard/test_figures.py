import numpy as np
import pytest

from plant_bench.reports.leaderboard.figures import board_figure, write_figures

HOSTILE = r"$\frac{a}$ 😀 \名 " + "x" * 10_000


def test_each_plant_bench_board_has_a_figure(tmp_path, write_run, leaderboard):
    runs = [
        write_run(tmp_path / "a", "a", worse=1),
        write_run(tmp_path / "b", HOSTILE),
        write_run(tmp_path / "c", "c", protocol="longest6-sumo-v0"),
    ]
    made = leaderboard(runs, paper=True)
    names = [path.name for path in write_figures(made, tmp_path / "out")]
    assert names == [
        "leaderboard.svg",
        "leaderboard.png",
        "leaderboard-2.svg",
        "leaderboard-2.png",
    ]
    assert (tmp_path / "out" / "leaderboard.png").read_bytes().startswith(b"\x89PNG")


def test_figure_shows_scores_and_differences_from_the_first(tmp_path, write_run, leaderboard):
    runs = [
        write_run(tmp_path / name, name, worse=worse, routes=12)
        for name, worse in (("a", 1), ("b", 40))
    ]
    scores, differences = board_figure(leaderboard(runs).boards[0]).axes
    assert [text.get_text() for text in scores.get_yticklabels()] == ["b", "a"]
    dots = [
        float(np.ravel(line.get_xdata())[0]) for line in scores.lines if line.get_marker() == "o"
    ]
    assert dots == pytest.approx([98.3, 60.0], abs=0.05)
    (dot,) = [line for line in differences.lines if line.get_marker() == "o"]
    assert float(np.ravel(dot.get_xdata())[0]) == pytest.approx(-38.3, abs=0.05)
    assert dot.get_markerfacecolor() == dot.get_color()
