"""Workers on a cluster, by Ray."""
from __future__ import annotations

import argparse
import logging
import os
import socket
from contextlib import suppress
from typing import Any

from .._target import is_url
from .._errors import install
from ._errors import FleetError, Usage, WorkerDied
from ._job import Job
from ._work import Converter

CONNECT_S = 10.0

QUIET = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_DEDUP_LOGS": "0", "RAY_SCHEDULER_EVENTS": "0",
         "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0", "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0"}


def connect(options: argparse.Namespace) -> tuple[Cluster, int]:
    """The cluster's workers, and the number of captures at a time."""
    _check_address(options.address)
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    try:
        import ray as module
    except ImportError as error:
        raise FleetError(f"Ray is not installed: {install('fleet')}") from error
    ray: Any = module
    _name_ourselves(ray)
    try:
        ray.init(address=options.address, logging_level=logging.ERROR, log_to_driver=False, configure_logging=False)
        return Cluster(ray), int(options.jobs or ray.cluster_resources().get("CPU", 0) or 1)
    except (ConnectionError, RuntimeError, ValueError, OSError, TimeoutError) as error:
        ray.shutdown()
        raise FleetError(f"the cluster {options.address} cannot be reached:"
                         f" {str(error).strip().splitlines()[0] if str(error) else error!r}") from error


class Cluster:
    """A pool of Ray's actors."""

    def __init__(self, ray: Any) -> None:
        self._ray = ray
        self._actor: Any = ray.remote(num_cpus=1, max_restarts=0, max_task_retries=0)(Converter)

    def start(self, job: Job) -> Any:
        return self._actor.remote(job)

    def ask(self, worker: Any, method: str, *arguments: Any) -> Any:
        return getattr(worker, method).remote(*arguments)

    def wait(self, answers: list[Any], seconds: float) -> list[Any]:
        done, rest = self._ray.wait(answers, timeout=seconds)
        if done and rest:
            done += self._ray.wait(rest, num_returns=len(rest), timeout=0)[0]
        return list(done)

    def take(self, answer: Any) -> Any:
        try:
            return self._ray.get(answer)
        except self._ray.exceptions.RayTaskError as error:
            raise FleetError(f"a worker failed: {error.cause if error.cause is not None else error}") from error
        except self._ray.exceptions.RayError as error:
            raise WorkerDied(str(error)) from error

    def end(self, worker: Any) -> None:
        with suppress(Exception):  # it is gone
            self._ray.kill(worker)

    def leave(self) -> None:
        self._ray.shutdown()


def _name_ourselves(ray: Any) -> None:
    """Ray notes the command line, and does not begin if a name in it is no text."""
    utils: Any = getattr(getattr(ray, "_private", None), "utils", None)
    if hasattr(utils, "get_entrypoint_name"):
        utils.get_entrypoint_name = lambda: "lumfleet"


def _check_address(address: str) -> None:
    """Ray itself takes minutes to find that nobody answers."""
    if is_url(address):
        raise Usage(f"--address: '{address}' is not HOST:PORT of a cluster's first machine, such as ray-head:6379, and not"
                         " auto; run lumfleet on a machine of the cluster")
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdigit():
        if address != "auto":
            raise Usage(f"--address: '{address}' is not HOST:PORT, such as ray-head:6379, and not auto")
        return
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=CONNECT_S).close()
    except OSError as error:
        raise FleetError(f"the cluster {address} cannot be reached: {error.strerror or error}") from error
