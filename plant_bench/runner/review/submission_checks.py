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

_CHECKED_ELSEWHERE = {"format", "inputs"}  # header fields that are not compared here
_SHOWN = 5  # missing episodes that a finding names
_REPETITIONS = 3  # per route, for standard scores


@dataclass(frozen=True)
class Finding:
    """A value that differs from the expected one; written as JSON.

    Attributes:
        place: Path of the file in the run's folder.
        what: Name of the field.
        found: Its value.
        wanted: The expected value.
    """

    place: str
    what: str
    found: str
    wanted: str


class _SummarySettings(BaseModel):
    """The fields of `summary.json` that do not follow from the records."""

    penalties: PenaltyScheme
    expected: int


def episode_of(provenance: Provenance, route: Route, repetition: int) -> Job:
    """Return the job of a run on a route."""
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
    """Yield differences of a record's header from `run.json` and the installed suite."""
    place = f"episodes/{name}.json"
    if result.route not in routes:
        yield Finding(place, "route", result.route, "a route of the suite")
        return
    route = routes[result.route]
    header = episode_of(provenance, route, result.repetition).header(frozenset())
    for field in EpisodeHeader.model_fields:
        found, expected = getattr(result, field), getattr(header, field)
        if field not in _CHECKED_ELSEWHERE and found != expected:
            yield Finding(place, field, str(found), str(expected))
    if result.route_length != route.length:
        yield Finding(place, "route_length", str(result.route_length), str(route.length))


def run_findings(provenance: Provenance, routes: Mapping[str, Route]) -> Iterator[Finding]:
    """Yield differences of `run.json` from the installed routes and towns."""
    jobs = [episode_of(provenance, route, 0) for route in routes.values()]
    headers = {job.route.id: job.header(frozenset()) for job in jobs}
    towns = {header.town: header.town_checksum for header in headers.values()}
    claimed = {"towns": provenance.towns, "routes": provenance.routes}
    here = {"towns": towns, "routes": {name: item.route_checksum for name, item in headers.items()}}
    for part, checksums in here.items():
        for name, checksum in checksums.items():
            found = claimed[part].get(name, "none")
            if found != checksum:
                yield Finding("run.json", f"{part}.{name}", found, checksum)
    protocol = jobs[0].scenario.protocol
    if provenance.protocol != protocol:
        yield Finding("run.json", "protocol", provenance.protocol, protocol)


def inputs_findings(records: Mapping[str, EpisodeResult]) -> Iterator[Finding]:
    """Yield the records whose planner had other inputs than in most of the records."""
    counts = Counter(item.inputs for item in records.values())
    usual = max(counts, key=lambda inputs: (counts[inputs], inputs), default=())
    for name, item in records.items():
        if item.inputs != usual:
            found, expected = (", ".join(inputs) or "nothing" for inputs in (item.inputs, usual))
            yield Finding(f"episodes/{name}.json", "inputs", found, expected)


def nonstandard_settings(folder: RunFolder, provenance: Provenance, repetitions: int) -> list[str]:
    """Return a note on settings that differ from those of standard scores; empty if none do."""
    try:
        penalties = _SummarySettings.model_validate_json(
            read_text(folder.path / "summary.json")
        ).penalties
    except (OSError, ValueError):
        penalties = PenaltyScheme.LB1_0  # an unreadable summary is reported as a finding
    standard = {
        "base seed": 0,
        "density": "dense",
        "hazards": True,
        "penalties": PenaltyScheme.LB1_0.value,
    }
    used = {
        "base seed": provenance.seed,
        "density": provenance.density,
        "hazards": provenance.hazards,
        "penalties": penalties.value,
    }
    other = [f"{name} {used[name]}" for name in standard if used[name] != standard[name]]
    other += [f"{repetitions} of 3 repetitions"] if repetitions < _REPETITIONS else []
    return [f"Settings that are not standard for scores: {', '.join(other)}."] if other else []


def count_findings(
    records: Iterable[EpisodeResult], expected: Sequence[Route], repetitions: int
) -> Iterator[Finding]:
    """Yield the episodes that are missing or have several records."""
    counts = Counter((item.route, item.repetition) for item in records)
    for (route, number), count in sorted(counts.items()):
        if count > 1:
            yield Finding("episodes", f"{route}, repetition {number}", f"{count} records", "one")
    missing = [
        f"{route.id} r{number}"
        for route in expected
        for number in range(repetitions)
        if (route.id, number) not in counts
    ]
    if missing:
        more = f" and {len(missing) - _SHOWN} more" if len(missing) > _SHOWN else ""
        found = f"{len(missing)} missing: {', '.join(missing[:_SHOWN])}{more}"
        yield Finding("episodes", "records", found, f"{len(expected)} routes x {repetitions}")


def summary_findings(folder: RunFolder, results: Sequence[EpisodeResult]) -> Iterator[Finding]:
    """Yield differences of the summary from one that is computed from the records."""
    try:
        settings = _SummarySettings.model_validate_json(read_text(folder.path / "summary.json"))
        texts = summary_texts(
            results, missing=settings.expected - len(results), penalties=settings.penalties
        )
    except (InputError, OSError, ValueError) as error:
        yield Finding("summary.json", "summary", in_one_line(error), "a summary of the records")
        return
    for name, text in texts.items():
        try:
            found = read_text(folder.path / name)
        except (OSError, ValueError) as error:
            yield Finding(name, "file", str(error), "a summary of the records")
            continue
        if found != text:
            lines = zip(found.splitlines(), text.splitlines(), strict=False)
            one, other = next(((a, b) for a, b in lines if a != b), ("other length", "same length"))
            yield Finding(name, "line", one.strip(), other.strip())


def check_names(
    records: Mapping[str, EpisodeResult], provenance: Provenance, routes: Mapping[str, Route]
) -> tuple[list[Finding], list[str]]:
    """Check the keys in the names of the records.

    A key covers the code of the rules. If all keys differ, the run was made with other rules; if
    some differ, those names are wrong.

    Returns:
        Findings of wrong names, and notes on other rules.
    """
    expected = {
        name: episode_name(episode_of(provenance, routes[result.route], result.repetition))
        for name, result in records.items()
    }
    wrong = {name: other for name, other in expected.items() if name != other}
    other_route = [
        name for name in wrong if name.rpartition("_")[0] != wrong[name].rpartition("_")[0]
    ]
    if len(wrong) < len(expected) or other_route:
        return [
            Finding(f"episodes/{name}.json", "name", name, other) for name, other in wrong.items()
        ], []
    there, here = provenance.versions, installed_versions()
    names = ("plant-bench", "libsumo")
    versions = [f"{name} {there.get(name, '?')} there, {here[name]} here" for name in names]
    note = (
        f"The run was made with another version of the rules' code ({'; '.join(versions)}): "
        "all keys in file names differ. The resimulated episodes show whether results change."
    )
    return [], [note]
