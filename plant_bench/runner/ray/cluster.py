"""Connects to an existing Ray cluster."""

import logging
import os
import socket
import uuid
from collections.abc import Iterator
from contextlib import contextmanager

from plant_bench.errors import InputError

CONNECT_TIMEOUT = 10.0  # s


@contextmanager
def connection_to(address: str) -> Iterator[None]:
    """Connect this process to a cluster; nested contexts reuse the connection.

    Args:
        address: See `RayExecutor`.

    Raises:
        InputError: The cluster does not respond.
    """
    _check_reachable(address)
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # avoids a warning on each use
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
            "Start one with `ray start --head`, or pass its --address: auto or HOST:6379 on a "
            "machine of the cluster, ray://HOST:10001 from other machines."
        )
        raise InputError(message) from error
    try:
        yield
    finally:
        ray.shutdown()


def _check_reachable(address: str) -> None:
    """Reject an address without a server at once; Ray itself would retry for minutes."""
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if not colon:
        return
    try:
        with socket.create_connection((host, int(port)), timeout=CONNECT_TIMEOUT):
            return
    except (OSError, ValueError) as error:
        message = f"No response at the --address '{address}' ({error})."
        raise InputError(message) from error
