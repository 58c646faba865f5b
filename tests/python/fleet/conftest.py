"""Fixtures of all tests of lumfleet. They take minutes and need Ray, so they run only when this folder is named."""
import pathlib
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))


def pytest_ignore_collect(collection_path, config):
    here = pathlib.Path(__file__).parent
    named = [pathlib.Path(str(name).split("::")[0]).resolve() for name in config.args]
    return None if any(here == path or here in path.parents for path in named) else True


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """A few small captures."""
    import support

    return support.make_captures(tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="session")
def nodes():
    """Four nodes; a test that kills one adds another."""
    import support

    cluster = support.Nodes(4)
    yield cluster
    cluster.close()
