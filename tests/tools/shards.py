"""A test file in several processes: LUM_SHARD=K/N runs every N-th test of it, from the K-th on. Without it, all."""
import os
import unittest


def index():
    """Which shard this is, from 0; for addresses that no other has."""
    return int(os.environ.get("LUM_SHARD", "0/1").split("/")[0])


def _tests(suite):
    for item in suite:
        if isinstance(item, unittest.TestSuite):
            yield from _tests(item)
        else:
            yield item


class _Loader(unittest.TestLoader):
    def loadTestsFromModule(self, module, *arguments, **options):  # noqa: N802, a name of unittest
        shard, shards = map(int, os.environ.get("LUM_SHARD", "0/1").split("/"))
        tests = list(_tests(super().loadTestsFromModule(module, *arguments, **options)))
        return self.suiteClass(tests[shard::shards])


def main():
    unittest.main("__main__", testLoader=_Loader())
