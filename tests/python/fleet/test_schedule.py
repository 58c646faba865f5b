"""Which worker gets what, with a Ray that is only a list of answers."""
import tracemalloc
import types

import pytest
import support  # noqa: F401  the package's place

from lumsdk.fleet._cluster import Cluster
from lumsdk.fleet._errors import FleetError
from lumsdk.fleet._job import Job
from lumsdk.fleet._ledger import Task
from lumsdk.fleet._schedule import Schedule

JOB = Job(run="r", out="/o", endpoint=None, format="ply", arguments=(), keywords={}, files={}, options="{}", version="1", lumdump="")


class RayError(Exception):
    pass


class RayTaskError(RayError):
    cause = None


class FakeRay:
    """Actors answer at once, except those that `dies` names; the latest answers come first."""

    exceptions = types.SimpleNamespace(RayError=RayError, RayTaskError=RayTaskError)

    def __init__(self, dies=lambda actor, task: False, ready=None, lost=lambda task, tries: ""):
        self.dies, self.ready, self.lost = dies, ready or {"version": "1"}, lost
        self.waiting = {}
        self.most = self.actors = 0
        self.tries = {}
        self.dead = set()

    def remote(self, **_):
        def of_class(_):
            return types.SimpleNamespace(remote=self.actor)
        return of_class

    def actor(self, _):
        self.actors += 1
        number = self.actors
        ask = lambda make: types.SimpleNamespace(remote=lambda *a: self.ask(number, make, *a))  # noqa: E731
        return types.SimpleNamespace(number=number, ready=ask(lambda: self.ready), close=ask(lambda: None), convert=ask(self.convert))

    def ask(self, number, make, *arguments):
        ref = object()
        self.waiting[ref] = (number, make, arguments)
        self.most = max(self.most, len(self.waiting))
        return ref

    def convert(self, task, attempt):
        self.tries[task.output] = self.tries.get(task.output, 0) + 1
        row = {"output": task.output, "status": "done", "message": ""}
        why = self.lost(task, self.tries[task.output])
        return {**row, "status": "failed", "lost": why} if why else row

    def wait(self, refs, num_returns=1, timeout=0):
        done = refs[-num_returns:]
        return done, [ref for ref in refs if ref not in done]

    def get(self, ref):
        number, make, arguments = self.waiting.pop(ref)
        if number in self.dead or arguments and self.dies(number, arguments[0]):
            self.dead.add(number)
            raise RayError("died")
        return make(*arguments)

    def kill(self, actor):
        self.dead.add(actor.number)


def run(ray, count, jobs=4, retries=4, stop=lambda: False):
    said = []
    schedule = Schedule(Cluster(ray), JOB, jobs, retries, said.append)
    tasks = (Task(f"/in/{n}", 1, "", f"{n}.ply", "") for n in range(count))
    return schedule, said, schedule.run(tasks, stop, lambda: None)


def test_all_are_converted_once():
    ray = FakeRay()
    _, said, rows = run(ray, 500)
    assert sorted(int(row["output"][:-4]) for row in rows) == list(range(500))
    assert set(ray.tries.values()) == {1} and ray.actors == 4 and said == []


def test_memory_does_not_grow_with_the_captures():
    """Two tasks of each worker are under way, however many there are."""
    ray = FakeRay()
    ray.convert = lambda task, attempt: {"output": task.output, "status": "done"}
    _, _, rows = run(ray, 20_000)
    seen = 0
    tracemalloc.start()
    for row in rows:
        seen += 1
        if seen == 2000:
            early = tracemalloc.get_traced_memory()[0]
    late = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert seen == 20_000 and ray.most <= 2 * 4 and late - early < 20_000


def test_workers_that_die_are_replaced_and_their_captures_done():
    deaths = {("3.ply", 1), ("9.ply", 2), ("9.ply", 3)}
    count = {}

    def dies(actor, task):
        count[task.output] = count.get(task.output, 0) + 1
        return (task.output, count[task.output]) in deaths
    ray = FakeRay(dies)
    schedule, said, rows = run(ray, 50)
    rows = list(rows)
    assert sorted(int(row["output"][:-4]) for row in rows) == list(range(50)) and all(row["status"] == "done" for row in rows)
    assert 1 <= schedule.lost == len(said) and ray.actors > 4


def test_a_capture_that_kills_its_workers_fails_alone():
    ray = FakeRay(lambda actor, task: task.output == "7.ply")
    _, _, rows = run(ray, 40, retries=2)
    got = {row["output"]: row for row in rows}
    assert len(got) == 40 and [o for o, row in got.items() if row["status"] == "failed"] == ["7.ply"]
    assert "its worker or its machine died, 3 times" in got["7.ply"]["message"]


@pytest.mark.parametrize("tries, status", [(4, "done"), (5, "failed")])
def test_an_attempt_that_a_store_failed_is_made_again(tries, status):
    ray = FakeRay(lost=lambda task, n: "the store is gone" if task.output == "1.ply" and n <= tries else "")
    _, said, rows = run(ray, 3)
    got = {row["output"]: row for row in rows}
    assert got["1.ply"]["status"] == status and len(said) == 4
    assert "lost" not in got["1.ply"] and (status == "done" or got["1.ply"]["message"] == "the store is gone, 5 times")


def test_workers_that_cannot_be_started_end_the_run():
    ray = FakeRay()
    ray.get = lambda ref: (_ for _ in ()).throw(RayError("no module named lumsdk"))
    _, _, rows = run(ray, 3)
    with pytest.raises(FleetError, match="workers cannot be started: no module named lumsdk"):
        list(rows)


@pytest.mark.parametrize("ready, sentence", [({"version": "2"}, "has lumsdk 2, this one 1"), ({"error": "does not see /o"}, "not see")])
def test_machines_that_do_not_fit_end_the_run(ready, sentence):
    _, _, rows = run(FakeRay(ready=ready), 3)
    with pytest.raises(FleetError, match=sentence):
        list(rows)


def test_nothing_is_begun_once_it_is_stopped():
    ray, seen = FakeRay(), []
    schedule, _, rows = run(ray, 100, stop=lambda: len(seen) > 9)
    for row in rows:
        seen.append(row)
    assert 10 <= len(seen) < 20
    schedule.close()
    assert len(ray.dead) == 4
