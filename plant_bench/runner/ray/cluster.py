"""Connects to an existing Ray cluster."""

import logging
import os
import socket
import uuid
from collections.abc import Iterator
from contextlib import contextmanager

from plant_bench.errors import InputError

REACH = 10.0  # s in which the cluster must answer


@contextmanager
def connection_to(address: str) -> Iterator[None]:
    """Be a driver of a cluster; within another such context nothing is done.

    Args:
        address: As of `RayExecutor`.

    Raises:
        InputError: It does not answer.
    """
    _check_answers(address)
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # else a warning on each use
    import ray

    if ray.is_initialized():
        yield
        return
    try:
        ray.init(
            address,
            namespace=f"plant-bench-{uuid.uuid4().hex}",
            logging_level=logging.ERROR,
            log_to_driver=False,
        )
    except Exception as error:
        message = (
            f"There is no Ray cluster at '{address}' ({' '.join(str(error).split())[:200]}). "
            "Start one with `ray start --head`, or give its --address: auto, HOST:6379 on a "
            "machine of the cluster, ray://HOST:10001 from elsewhere."
        )
        raise InputError(message) from error
    try:
        yield
    finally:
        ray.shutdown()


def _check_answers(address: str) -> None:
    """Refuse an address at which nobody listens: Ray itself would try for minutes."""
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not colon:
        return
    try:
        with socket.create_connection((host, int(port)), timeout=REACH):
            return
    except (OSError, ValueError) as error:
        message = f"No response at the --address '{address}' ({error})."
        raise InputError(message) from error
