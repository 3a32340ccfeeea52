import base64
import hashlib
import json
import re

import pytest

from plant_bench.reports.leaderboard.exports import without_nan
from plant_bench.reports.leaderboard.leaderboard_page import page_html, write_page
from plant_bench.text_escaping import script_json

HOSTILE = "</script><script>alert(1)</script><!-- \u2028 & 😀 @@DATA@@"


@pytest.fixture
def page(tmp_path, write_run, leaderboard):
    path = write_run(tmp_path / "a", HOSTILE, reason=HOSTILE, recorded=True)
    return page_html(leaderboard([path]), replays=True)


def data_of(page):
    return json.loads(re.findall(r'id="data">(.*?)</script>', page, re.DOTALL)[0])


def test_untrusted_text_cannot_end_the_script(page):
    assert data_of(page)["boards"][0]["lines"][0]["planner"] == HOSTILE
    assert page.count("alert(1)") == page.count("\\u003cscript\\u003ealert(1)") > 0
    assert "\u2028" not in page


def test_content_security_policy_allows_only_own_scripts(page):
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    digests = {
        base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in scripts
    }
    assert set(re.findall(r"'sha256-([^']*)'", policy)) == digests
    assert policy.startswith("default-src 'none';")
    assert "unsafe-eval" not in policy
    assert "'unsafe-inline'" not in policy.partition("script-src")[2].partition(";")[0]


def test_page_loads_nothing_from_the_network(page):
    assert not re.search(r'<(script|link|img|iframe)[^>]*(src|href)="', page)
    assert "fetch(" not in page


def test_only_recorded_episodes_link_to_a_replay(page, tmp_path, write_run, leaderboard):
    assert all(item[9] for item in data_of(page)["boards"][0]["episodes"][0])
    made = leaderboard([write_run(tmp_path / "b", recorded=True)])
    without = data_of(page_html(made, replays=False))
    assert not any(item[9] for item in without["boards"][0]["episodes"][0])


def test_page_is_written_atomically(tmp_path, write_run, leaderboard):
    path = write_page(leaderboard([write_run(tmp_path / "a")]), tmp_path / "out", replays=False)
    assert path.read_text(encoding="utf-8").endswith("</html>\n")
    assert [item.name for item in path.parent.iterdir()] == ["leaderboard.html"]


def test_values_that_are_not_numbers_become_null():
    assert (
        script_json(without_nan([float("nan"), float("inf"), 1.5, "<"]))
        == '[null,null,1.5,"\\u003c"]'
    )
