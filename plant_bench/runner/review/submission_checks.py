"""Checks of a submitted run against installed routes, towns and rules, without the simulator."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pydantic import BaseModel

from plant_bench.errors import InputError, in_one_line
from plant_bench.runner.episode.jobs import Job, episode_name, repetition_seed
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance, installed_versions
from plant_bench.runner.run.summary_files import summary_texts
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeHeader, EpisodeResult
from plant_bench.untrusted_files import read_text
from plant_bench.world.route import Route

_CHECKED_ELSEWHERE = {"format", "inputs"}  # of a header: what driving again will tell
_SHOWN = 5  # names in a list
_REPETITIONS = 3  # of each route, as scores of the benchmark are made


@dataclass(frozen=True)
class Finding:
    """Something that is not as it should be.

    Attributes:
        place: The file it is in, below the run's folder.
        what: The field.
        found: Its value.
        wanted: What it should be.
    """

    place: str
    what: str
    found: str
    wanted: str


class _Told(BaseModel):
    """What of a summary does not follow from the records."""

    penalties: PenaltyScheme
    expected: int


def episode_of(provenance: Provenance, route: Route, repetition: int) -> Job:
    """Return the episode that a run should have driven on a route."""
    return Job(
        agent=provenance.agent,
        agent_checksum=provenance.agent_checksum,
        route=route,
        repetition=repetition,
        seed=repetition_seed(provenance.seed, route.id, repetition),
        density=provenance.density,
        hazards=provenance.hazards,
    )


def record_findings(
    name: str, result: EpisodeResult, provenance: Provenance, routes: Mapping[str, Route]
) -> Iterator[Finding]:
    """Give what of a record's header is not what the run and the suite here say."""
    place = f"episodes/{name}.json"
    if result.route not in routes:
        yield Finding(place, "route", result.route, "a route of the suite")
        return
    route = routes[result.route]
    header = episode_of(provenance, route, result.repetition).header(frozenset())
    for field in EpisodeHeader.model_fields:
        found, wanted = getattr(result, field), getattr(header, field)
        if field not in _CHECKED_ELSEWHERE and found != wanted:
            yield Finding(place, field, str(found), str(wanted))
    if result.route_length != route.length:
        yield Finding(place, "route_length", str(result.route_length), str(route.length))


def run_findings(provenance: Provenance, routes: Mapping[str, Route]) -> Iterator[Finding]:
    """Give what of `run.json` does not fit the routes and towns here."""
    jobs = [episode_of(provenance, route, 0) for route in routes.values()]
    headers = {job.route.id: job.header(frozenset()) for job in jobs}
    towns = {header.town: header.town_checksum for header in headers.values()}
    told = {"towns": provenance.towns, "routes": provenance.routes}
    here = {"towns": towns, "routes": {name: item.route_checksum for name, item in headers.items()}}
    for part, checksums in here.items():
        for name, checksum in checksums.items():
            found = told[part].get(name, "none")
            if found != checksum:
                yield Finding("run.json", f"{part}.{name}", found, checksum)
    protocol = jobs[0].scenario.protocol
    if provenance.protocol != protocol:
        yield Finding("run.json", "protocol", provenance.protocol, protocol)


def inputs_findings(records: Mapping[str, EpisodeResult]) -> Iterator[Finding]:
    """Give the records of a planner that was given something else than in most of the others."""
    counts = Counter(item.inputs for item in records.values())
    usual = max(counts, key=lambda inputs: (counts[inputs], inputs), default=())
    for name, item in records.items():
        if item.inputs != usual:
            found, wanted = (", ".join(inputs) or "nothing" for inputs in (item.inputs, usual))
            yield Finding(f"episodes/{name}.json", "inputs", found, wanted)


def choices_of(folder: RunFolder, provenance: Provenance, repetitions: int) -> list[str]:
    """Return in words what of a submitter's choices is not as the benchmark's scores are made."""
    try:
        penalties = _Told.model_validate_json(read_text(folder.path / "summary.json")).penalties
    except (OSError, ValueError):
        penalties = PenaltyScheme.LB1_0  # that it cannot be read is a finding
    usual = {
        "base seed": 0,
        "density": "dense",
        "hazards": True,
        "penalties": PenaltyScheme.LB1_0.value,
    }
    told = {
        "base seed": provenance.seed,
        "density": provenance.density,
        "hazards": provenance.hazards,
        "penalties": penalties.value,
    }
    other = [f"{name} {told[name]}" for name in usual if told[name] != usual[name]]
    other += [f"{repetitions} of 3 repetitions"] if repetitions < _REPETITIONS else []
    return [f"Not as scores of the benchmark are made: {', '.join(other)}."] if other else []


def count_findings(
    records: Iterable[EpisodeResult], wanted: Sequence[Route], repetitions: int
) -> Iterator[Finding]:
    """Give the episodes that are missing or there more than once."""
    counts = Counter((item.route, item.repetition) for item in records)
    for (route, number), count in sorted(counts.items()):
        if count > 1:
            yield Finding("episodes", f"{route}, repetition {number}", f"{count} records", "one")
    missing = [
        f"{route.id} r{number}"
        for route in wanted
        for number in range(repetitions)
        if (route.id, number) not in counts
    ]
    if missing:
        more = f" and {len(missing) - _SHOWN} more" if len(missing) > _SHOWN else ""
        found = f"{len(missing)} missing: {', '.join(missing[:_SHOWN])}{more}"
        yield Finding("episodes", "records", found, f"{len(wanted)} routes x {repetitions}")


def summary_findings(folder: RunFolder, results: Sequence[EpisodeResult]) -> Iterator[Finding]:
    """Give what of the summary does not follow from the records."""
    try:
        told = _Told.model_validate_json(read_text(folder.path / "summary.json"))
        texts = summary_texts(
            results, missing=told.expected - len(results), penalties=told.penalties
        )
    except (InputError, OSError, ValueError) as error:
        yield Finding("summary.json", "summary", in_one_line(error), "a summary of these records")
        return
    for name, text in texts.items():
        try:
            found = read_text(folder.path / name)
        except (OSError, ValueError) as error:
            yield Finding(name, "file", str(error), "one that follows from the records")
            continue
        if found != text:
            lines = zip(found.splitlines(), text.splitlines(), strict=False)
            one, other = next(((a, b) for a, b in lines if a != b), ("its length", "another"))
            yield Finding(name, "line", one.strip(), other.strip())


def check_names(
    records: Mapping[str, EpisodeResult], provenance: Provenance, routes: Mapping[str, Route]
) -> tuple[list[Finding], list[str]]:
    """Return what is wrong with names, and what they tell of the rules.

    A name's key covers the code of the rules. Where every key is another, the rules are; where some
    are, those names are wrong.
    """
    right = {
        name: episode_name(episode_of(provenance, routes[result.route], result.repetition))
        for name, result in records.items()
    }
    wrong = {name: wanted for name, wanted in right.items() if name != wanted}
    other_route = [
        name for name in wrong if name.rpartition("_")[0] != wrong[name].rpartition("_")[0]
    ]
    if len(wrong) < len(right) or other_route:
        return [
            Finding(f"episodes/{name}.json", "name", name, wanted) for name, wanted in wrong.items()
        ], []
    told, here = provenance.versions, installed_versions()
    names = ("plant-bench", "libsumo")
    versions = [f"{name} {told.get(name, '?')} there, {here[name]} here" for name in names]
    note = (
        f"The code of the rules here is not the one the run was made with ({'; '.join(versions)}): "
        "all names carry another key. Whether that changes anything, the episodes below tell."
    )
    return [], [note]
