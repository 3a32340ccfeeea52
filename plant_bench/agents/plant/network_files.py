"""Saves and loads a trained PlanT network; see `plant_bench.model_folder`."""

from dataclasses import asdict
from pathlib import Path

from plant_bench.agents.plant.config import NETWORK, load_config
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.model_folder import load_weights, save_model


def save_network(network: PlanTNetwork, folder: Path) -> None:
    """Write a network's weights and config, each file atomically."""
    save_model(NETWORK, asdict(network.config), network.state_dict(), folder)


def load_network(folder: Path) -> PlanTNetwork:
    """Return a saved network in evaluation mode, float32.

    Raises:
        InputError: Files are missing or broken, or the weights do not fit the config.
    """
    network = PlanTNetwork(load_config(folder))
    load_weights(network, folder)
    return network.eval()
