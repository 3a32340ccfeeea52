import pytest

from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import make_jobs, repetition_seed, select_routes


@pytest.fixture
def routes(route):
    return [route(f"town0{town}-{number}") for town in (1, 2) for number in (0, 1, 2)]


@pytest.mark.parametrize(
    ("selection", "ids"),
    [
        ("0", ["town01-0"]),
        ("4,0", ["town01-0", "town02-1"]),
        ("1-3", ["town01-1", "town01-2", "town02-0"]),
        ("town02-1, 0-1,1", ["town01-0", "town01-1", "town02-1"]),
    ],
)
def test_a_selection_names_routes_by_number_range_and_id(routes, selection, ids):
    assert [route.id for route in select_routes(routes, selection)] == ids


@pytest.mark.parametrize("selection", ["6", "2-6", "3-1", "", "0,", "-1", "1-", "nine"])
def test_selection_of_no_route_is_refused(routes, selection):
    with pytest.raises(InputError, match="numbers from 0 to 5"):
        select_routes(routes, selection)


def test_misspelt_route_gives_a_suggestion(routes):
    with pytest.raises(InputError, match="Did you mean town02-1"):
        select_routes(routes, "twon02-1")


def test_seeds_do_not_depend_on_the_agent_or_on_the_other_routes(routes):
    mine = make_jobs("a", "1", routes, repetitions=2, seed=7, density="dense")
    yours = make_jobs("b", "2", routes[3:], repetitions=3, seed=7, density="dense")

    seeds = {(job.route.id, job.repetition): job.seed for job in mine}
    shared = [(job.route.id, job.repetition) for job in yours if job.repetition < 2]
    assert [seeds[pair] for pair in shared] == [job.seed for job in yours if job.repetition < 2]
    assert len(set(seeds.values())) == len(seeds)


def test_seeds_are_in_the_range_of_sumo():
    assert all(0 <= repetition_seed(0, f"r{n}", 0) < 2**31 for n in range(200))


def test_key_depends_on_everything_that_affects_the_result(routes):
    def key(**changes):
        given = {"repetitions": 1, "seed": 0, "density": "dense"} | changes
        agent = given.pop("agent", "a")
        checksum = given.pop("checksum", "1")
        return make_jobs(agent, checksum, routes[:1], **given)[0].key

    assert key() == key()
    changed = [key(agent="b"), key(checksum="2"), key(seed=1), key(density="light")]
    assert len({key(), *changed}) == 5
