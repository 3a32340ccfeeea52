import re

import pytest

from plant_bench.reports.page_scripts import page_script

NAMES = ("theme", "leaderboard", "replay")


@pytest.mark.parametrize("name", NAMES)
def test_a_bundle_may_stand_in_a_script_element(name):
    assert not re.search(r"</script|<!--", page_script(name), re.IGNORECASE)


@pytest.mark.parametrize("name", NAMES)
def test_a_bundle_is_a_classic_script_that_imports_nothing(name):
    code = re.sub(r"^/\*!.*?\*/", "", page_script(name), flags=re.DOTALL)
    assert code.lstrip().startswith(('"use strict";(()=>{', "(()=>{"))
    assert not re.search(r"\b(?:import|require)\s*\(|^(?:import|export)\b", code, re.MULTILINE)
    assert not re.search(r"\beval\(|\bnew Function\b|\bfetch\(|XMLHttpRequest", code)


def test_the_licences_of_bundled_packages_are_kept():
    notices = re.findall(r"/\*!.*?\*/", page_script("leaderboard"), re.DOTALL)[0]
    for text in ("@observablehq/plot 0.6.17", "d3-scale ", "Mike Bostock", "Observable, Inc."):
        assert text in notices
    assert notices.count("THE SOFTWARE IS PROVIDED") >= 2
