"""Names that users write in their own files and shells; to take one away is a breaking change."""

import importlib

import pytest

PUBLIC = {
    "plant_bench": ["__version__"],
    "plant_bench.agent": [
        "Agent",
        "Control",
        "Input",
        "NextLight",
        "Observation",
        "Plan",
        "Privileged",
        "Ranker",
        "RouteAhead",
        "check_agent",
    ],
    "plant_bench.agents.loading.registry": ["AGENTS", "agent_checksum", "load_agent"],
    "plant_bench.data.recording": ["Recording"],
    "plant_bench.errors": ["AgentError", "InputError", "PlantBenchError", "SimulationError"],
    "plant_bench.features.raster": ["ROACH", "Rasteriser", "RasterSpec"],
    "plant_bench.features.raster_layers": ["Layer"],
    "plant_bench.gym": ["ENV_ID"],
    "plant_bench.gym.encoders": ["Encoder", "RasterEncoder"],
    "plant_bench.gym.environment": ["PlantBenchEnv"],
    "plant_bench.gym.rewards": ["ProgressReward"],
    "plant_bench.gym.roach": ["RoachReward"],
    "plant_bench.gym.token_encoder": ["TokenEncoder"],
    "plant_bench.gym.transition": ["Reward", "Transition"],
    "plant_bench.runner.episode.loop": ["run_episode"],
    "plant_bench.runner.episode.jobs": ["Job"],
    "plant_bench.runner.run.score_run": ["ScoreRequest", "open_run"],
    "plant_bench.runner.run.suite": ["run_suite"],
    "plant_bench.scoring.comparison": ["detectable_difference", "paired_difference"],
    "plant_bench.scoring.laws": ["Law", "law_of"],
    "plant_bench.scoring.measures": ["Measures"],
    "plant_bench.scoring.metrics": ["Summary", "summarise", "summary_frame"],
    "plant_bench.scoring.normalised": ["normalised_score"],
    "plant_bench.scoring.rescore": ["rescore"],
    "plant_bench.scoring.results": ["EpisodeResult"],
    "plant_bench.world.route": ["PROTOCOL", "Route", "Scenario", "load_suite", "suite_names"],
    "plant_bench.world.scene": ["ActorKind", "Actors", "EgoState", "Light", "Scene"],
    "plant_bench.world.town": ["Town", "load_town"],
}


@pytest.mark.parametrize("module", PUBLIC)
def test_public_names_are_there(module):
    found = importlib.import_module(module)

    assert [name for name in PUBLIC[module] if not hasattr(found, name)] == []
