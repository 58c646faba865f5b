"""Ray: on this machine for this run alone, or a cluster that is there."""
from __future__ import annotations

import argparse
import logging
import os
import secrets
import shutil
import socket
import tempfile
from typing import Any, Optional

from .._target import is_url
from .._errors import install
from ._errors import FleetError

# Ray makes sockets below its folder; the system takes 107 bytes of name, Ray needs 70 of them.
LONGEST_FOLDER = 35
CONNECT_S = 10.0
_folder: Optional[str] = None

QUIET = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_DEDUP_LOGS": "0", "RAY_SCHEDULER_EVENTS": "0",
         "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0", "RAY_ENABLE_UV_RUN_RUNTIME_ENV": "0"}


def connect(options: argparse.Namespace, work: str, object_store: int, jobs: int) -> int:
    """The number of captures at a time."""
    if options.address:
        _check_address(options.address)
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    if not options.address:
        # A secret of this run alone, instead of a file in the user's home.
        os.environ.setdefault("RAY_AUTH_MODE", "token")
        os.environ.setdefault("RAY_AUTH_TOKEN", secrets.token_hex(32))
    try:
        import ray as module
    except ImportError as error:
        raise FleetError(f"Ray is not installed: {install('fleet')}") from error
    ray: Any = module
    _name_ourselves(ray)
    try:
        if options.address:
            ray.init(address=options.address, logging_level=logging.ERROR, log_to_driver=False, configure_logging=False)
            return int(options.jobs or ray.cluster_resources().get("CPU", 0) or 1)
        ray.init(address="local", num_cpus=jobs, num_gpus=0, object_store_memory=object_store, include_dashboard=False,
                 logging_level=logging.ERROR, log_to_driver=False, configure_logging=False, _temp_dir=_ray_folder(work))
        return jobs
    except (ConnectionError, RuntimeError, ValueError, OSError, TimeoutError) as error:
        leave()
        where = f"the cluster {options.address}" if options.address else "Ray on this machine"
        raise FleetError(f"{where} cannot be reached: {str(error).strip().splitlines()[0] if str(error) else error!r}") from error


def _name_ourselves(ray: Any) -> None:
    """Ray notes the command line, and does not begin if a name in it is no text."""
    utils: Any = getattr(getattr(ray, "_private", None), "utils", None)
    if hasattr(utils, "get_entrypoint_name"):
        utils.get_entrypoint_name = lambda: "lumfleet"


def _check_address(address: str) -> None:
    """Ray itself takes minutes to find that nobody answers."""
    if is_url(address):
        raise FleetError(f"--address: '{address}' is not HOST:PORT of a cluster's first machine, such as ray-head:6379, and not"
                         " auto; run lumfleet on a machine of the cluster", 2)
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdigit():
        if address != "auto":
            raise FleetError(f"--address: '{address}' is not HOST:PORT, such as ray-head:6379, and not auto", 2)
        return
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=CONNECT_S).close()
    except OSError as error:
        raise FleetError(f"the cluster {address} cannot be reached: {error.strerror or error}") from error


def _ray_folder(work: str) -> str:
    """For its logs and sockets."""
    global _folder
    if len(work) <= LONGEST_FOLDER:
        return os.path.join(work, "ray")
    _folder = tempfile.mkdtemp(prefix="lf-", dir="/tmp")
    return _folder


def leave() -> None:
    """Ends Ray, if it is of this run."""
    global _folder
    import ray

    ray.shutdown()
    if _folder is not None:
        shutil.rmtree(_folder, ignore_errors=True)
        _folder = None
