"""Fixtures of all tests of lumfleet."""
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import support  # noqa: E402


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """A few small captures."""
    return support.make_captures(tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="session")
def nodes():
    """Four nodes; a test that kills one adds another."""
    cluster = support.Nodes(4)
    yield cluster
    cluster.close()
