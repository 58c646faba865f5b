"""lumcal eyes: rooms of a known calibration, what is held, and what is refused. Most rooms are made by rooms.py, in milliseconds."""
import copy
import dataclasses
import functools
import json
import math
import types

import numpy as np
import pytest

pytest.importorskip("scipy")

import lumsdk  # noqa: E402
from scipy import sparse  # noqa: E402
import rooms  # noqa: E402
from lumsdk.calibrate import _cli, _edges, _eyes, _faces, _match, _model, _planes, _solve  # noqa: E402

POSES = ((0, 0, 0), (12, 0, 27), (-12, 0, -27))

TILES_MAX = 800
"""Coarser than usual: a solution takes less time, and is right all the same."""


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    monkeypatch.setattr(_faces, "TILES_MAX", TILES_MAX)


@functools.lru_cache(maxsize=None)
def room(seed=5, count=3, rms=0.0, bias=0.0, sine=0.0):
    """Captures of a room, and the true calibration."""
    rng = np.random.default_rng(seed)
    true = rooms.true_calibration(rng)
    walls, shapes = rooms.Walls(rng, rms, bias), rooms.boxes()
    made = []
    for roll, pitch, yaw in POSES[:count]:
        at = (*rng.uniform(-0.3, 0.3, 2), 1.2)
        made.append(rooms.see((*at, roll, pitch + rng.uniform(-2, 2), yaw + rng.uniform(-3, 3)), true, rng, walls, shapes, sine=sine))
    return made, true


@functools.lru_cache(maxsize=None)
def solution(*choice):
    grids, _ = room(*choice)
    return _eyes.solve_grids(grids, lumsdk.Calibration())


def truth(true):
    made = {}
    for eye, values in true.items():
        mount = dict(zip(("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg"), values["mount"]))
        made.update({f"{eye}.tof_offset_ps": values["offset_m"] * rooms.PICOSECONDS_A_METRE, f"{eye}.azimuth.width_deg": values["width"],
                     f"{eye}.elevation.min_deg": values["low"], f"{eye}.elevation.max_deg": values["high"],
                     **{f"{eye}.mount.{key}": value for key, value in mount.items()}})
    return made


def nested(values):
    """A calibration's eyes as a mapping of mappings."""
    made = {}
    for key, value in values.items():
        *above, name = key.split(".")
        place = made
        for part in above:
            place = place.setdefault(part, {})
        place[name] = float(value)
    return made


def errors(found, true):
    known = truth(true)
    return {p.key: (p.value - known[p.key], p.sigma) for p in found.parameters if p.key in known}


FLAT = {"roll_deg": 0.0003, "pitch_deg": 0.0003, "yaw_deg": 0.0003, "m": 0.003, "ps": 0.004, "width_deg": 0.0002, "min_deg": 0.0012,
        "max_deg": 0.0012}
MILD = {"roll_deg": 0.0006, "pitch_deg": 0.0006, "yaw_deg": 0.0006, "m": 0.006, "ps": 0.01, "width_deg": 0.0005, "min_deg": 0.003,
        "max_deg": 0.003}
"""How far off each may be on flat walls and on wavy ones: radians, metres, shares of width and height of the view."""

UNITS = {"roll_deg": math.radians(1), "pitch_deg": math.radians(1), "yaw_deg": math.radians(1), "m": 1.0,
         "ps": 1 / rooms.PICOSECONDS_A_METRE, "width_deg": 1 / 60, "min_deg": 1 / 20, "max_deg": 1 / 20}

WAVY = 4, 3, 0.0014, 0.002, 0.003
"""The room that MILD is about."""


def beyond(wrong, bars):
    """What is further off than the bars, by the parts of them."""
    parts = {key: abs(error) * UNITS[name] / bars[name] for key, (error, _) in wrong.items() for name in bars if key.endswith(name)}
    assert len(parts) == len(wrong)
    return {key: part for key, part in parts.items() if part > 1}


def test_a_room_tells_the_calibration():
    found, (_, true) = solution(), room()
    wrong = errors(found, true)
    assert not [p.key for p in found.parameters if p.held and not p.key.endswith("center_deg")]
    assert not beyond(wrong, FLAT)
    assert all(abs(error) < 4 * sigma for error, sigma in wrong.values())
    assert sum(abs(error) < 2 * sigma for error, sigma in wrong.values()) >= 11


@pytest.mark.long
def test_standard_deviations_hold_on_wavy_walls(monkeypatch):
    """Over several rooms: neither too small nor so large that they say nothing."""
    monkeypatch.setattr(_faces, "TILES_MAX", 400)
    mild = 3, 0.0014, 0.002, 0.003
    off = []
    for seed in (4, 5, 7):
        grids, true = room(seed, *mild)
        off += [error / sigma for error, sigma in errors(_eyes.solve_grids(grids, lumsdk.Calibration()), true).values()]
    off = np.abs(off)
    assert len(off) == 42 and np.isfinite(off).all()
    assert np.mean(off < 2) > 0.8 and off.max() < 6
    assert 0.5 < np.sqrt(np.mean(off ** 2)) < 2


@pytest.mark.long
def test_wavy_walls_keep_its_bars_and_make_it_less_sure():
    flat, wavy = solution(), solution(*WAVY)
    wrong = errors(wavy, room(*WAVY)[1])
    assert not beyond(wrong, MILD)
    assert sum(abs(error) < 2 * sigma for error, sigma in wrong.values()) >= 12
    assert all(abs(error) < 4 * sigma for error, sigma in wrong.values())
    assert sum(p.sigma > q.sigma for p, q in zip(wavy.parameters[:14], flat.parameters[:14])) >= 12


def test_it_is_better_on_faces_that_it_has_not_seen():
    found = solution()
    assert found.is_better
    assert found.held_out_after_m < 0.001 < 0.003 < found.held_out_before_m
    assert found.rms_after_m < 0.001 < found.rms_before_m


@pytest.mark.long
@pytest.mark.usefixtures("own_signals")
def test_a_solver_that_errs_makes_no_file(monkeypatch, tmp_path, capsys):
    """From the true calibration, with a solver that turns the green eye by half a degree: faces left out of the fit tell."""
    grids, true = room()
    solve = _eyes.solve

    def err(problem, *rest):
        fit = solve(problem, *rest)
        if not problem.held.all():
            fit.state.values[_model.KEYS.index("green.mount.yaw_deg")] += 0.5
        return fit

    monkeypatch.setattr(_faces, "TILES_MAX", 500)
    monkeypatch.setattr(_eyes, "solve", err)
    monkeypatch.setattr(_eyes, "grid", lambda capture, *_, **__: grids["abc".index(capture[0])])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "true.yaml").write_text(lumsdk.Calibration({"eyes": nested(truth(true))}).to_yaml())
    assert _cli.main(["eyes", "a.pcap", "b.pcap", "c.pcap", "--calibration", "true.yaml", "-o", "out.yaml", "--json"]) == 1
    out, err_text = capsys.readouterr()
    told = json.loads(out)
    assert told["is_better"] is False and told["began"] == "true.yaml"
    assert told["held_out_before_m"] < 0.001 < told["allowed_m"] + 0.001 < told["held_out_after_m"]
    assert "the result is worse than its start on faces left out of the fit" in err_text
    assert [path.name for path in tmp_path.iterdir()] == ["true.yaml"]


def test_what_a_floor_alone_does_not_tell_is_held_at_its_value_and_named():
    rng = np.random.default_rng(6)
    shapes = [((0, 0, 50.0), np.array((200.0, 200.0, 50.0)), np.eye(3), True)]
    floor = rooms.see((0, 0, 1.5, 0, 0, 0), room()[1], rng, rooms.Walls(rng), shapes)
    found = _eyes.solve_grids([floor], lumsdk.Calibration())
    held = {p.key: p for p in found.parameters if p.held}
    for key in ("green.mount.yaw_deg", "green.mount.x_m", "green.mount.y_m"):
        assert held[key].value == held[key].before and math.isinf(held[key].sigma)
        assert "add two of the same room" in held[key].held
    assert any("use at least 3" in note for note in found.notes)


@pytest.mark.parametrize("key", _model.KEYS)
def test_each_key_has_the_recording_that_tells_it(key):
    one, more = (_eyes._why_held(key, captures, True) for captures in (1, 2))
    assert "add two of the same room" in one and "add one of the same room that shows" in more
    assert more == _eyes._why_held(key, 3, True) and "{" not in more
    word = {"x_m": "straight ahead", "yaw_deg": "straight ahead", "y_m": "at the side", "z_m": "floor", "roll_deg": "floor", "pitch_deg": "floor",
            "tof_offset_ps": "near and far", "width_deg": "across the whole view", "min_deg": "rolled by", "max_deg": "rolled by"}
    assert word[key.rsplit(".", 1)[-1]] in more


def test_angles_in_degrees_have_no_width():
    """However much is recorded."""
    why = _eyes._why_held("blue.azimuth.width_deg", 3, False)
    assert "angles in degrees" in why and "no recording" in why
    assert "angles in degrees" in _eyes._why_held("green.elevation.max_deg", 1, False)
    for key, is_span in (("green.mount.z_m", False), ("green.mount.x_m", False), ("blue.azimuth.width_deg", True)):
        assert "angles in degrees" not in _eyes._why_held(key, 3, is_span)


def test_what_is_found_besides_is_told():
    found = solution()
    told = _eyes.to_json(found)
    assert set(told["bends_deg"]) == {"blue", "green"} and set(told["bends_deg"]["blue"]["azimuth"]) == {"p2", "p3", "p4"}
    assert told["spread"] and all(value > 0 for value in told["spread"].values())
    assert all(abs(plane["bias_m"]) < 0.02 for plane in told["planes"]) and any(plane["bias_m"] for plane in told["planes"])
    assert told["allowed_m"] == pytest.approx(1.02 * told["held_out_before_m"] + 0.0002) and told["began"] == "typical values"
    assert "mirror readings are bent by up to" in _eyes.to_yaml(found)


def test_a_bent_scan_shows():
    """By as much as it is bent, of the mirror that is."""
    from lumsdk.calibrate import _tell

    found = copy.copy(solution())
    found.bends_deg = np.zeros((2, 2, 3))
    found.bends_deg[1, 0, 0] = -0.05
    assert dict(_tell.bends(found)) == {"blue azimuth": 0.0, "blue elevation": 0.0, "green azimuth": pytest.approx(0.05), "green elevation": 0.0}
    assert "green azimuth 0.050" in _tell.solution_text(found)


@pytest.mark.parametrize("count, told", [(2, "use at least 3"), (3, None), (5, None)])
def test_a_note_says_what_the_number_of_captures_means(count, told):
    notes = list(_eyes._notes([room()[0][0]] * count))
    assert [told in note for note in notes] == [True] if told else not notes


def test_exchanged_eyes_are_told_with_the_values_that_exchange_them():
    grids = room()[0]
    fields = "azimuth", "elevation", "range_m", "sigma_m", "count"
    other = [dataclasses.replace(g, eye_values=(3, 5), **{name: getattr(g, name)[::-1].copy() for name in fields}) for g in grids]
    typical = lumsdk.Calibration()
    assert _eyes._exchanged(grids, typical) == ""
    told = _eyes._exchanged(other, typical, typical)
    assert "only with the eyes exchanged" in told and "--set eye_values.blue=5 --set eye_values.green=3" in told
    mirrored = lumsdk.Calibration({"eyes": {"blue": {"mount": {"yaw_deg": 30}}, "green": {"mount": {"yaw_deg": -30}}}})
    assert _eyes._exchanged(other, typical, mirrored) == "", "a wall goes on by what was found"


@pytest.mark.parametrize("moved, told", [((0, 0, 0, 0), None), ((0.01, 0, 0, 0), "mm within"), ((0, 0.01, 0, 0), "mm within"),
                                         ((0, 0, 0.01, 0), "mm within"), ((0, 0, 0, 0.2), "mm within"), ((0.2, 0, 0, 0), "stand still")])
def test_a_sensor_that_is_moved_half_way_is_told(moved, told, make_capture, tmp_path):
    import calibrations

    usual = "--scene", "room", "--frames", 12, "--lines", 64, "--walls", "rough"
    pose = np.array([0.1, 0.2, 1.2, 0, 5, 10])
    one, other = (make_capture(*usual, "--pose", ",".join(map(str, p))) for p in (pose, pose + [*moved[:3], 0, 0, moved[3]]))
    path = tmp_path / "half.pcap"
    path.write_bytes(one.read_bytes())
    calibrations.move(path, other)
    if told == "stand still":
        with pytest.raises(lumsdk.CaptureError, match=told):
            _planes.grid(path)
    else:
        notes = [note for note in _eyes._notes([_planes.grid(path)] * 3) if "was moved" in note]
        assert [told in note for note in notes] == ([] if told is None else [True] * 3)


@pytest.mark.parametrize("lines", [2, 3, 64])
def test_noise_of_few_cells_is_no_move(lines):
    """Each block by its own cells: of few lines, and where few are calm. A step of 3 cm is told all the same."""
    rng = np.random.default_rng(7)
    is_calm = np.broadcast_to(np.arange(1000) % 10 < 3, (2, lines, 1000))

    def shift(step_m):
        sums, frames = _planes._Sums(), 8
        sums.frames, sums.count = frames, np.full((2, lines, 1000), frames, "i4")
        ranges = rng.normal(5, 0.03, (frames, 2, lines, 1000))
        ranges[frames // 2:] += step_m
        turn = np.arange(frames)[:, None, None, None]
        sums.sums = np.stack([values.sum(0) for values in (ranges, ranges ** 2, ranges, ranges, turn * ranges, turn + 0 * ranges)])
        return _planes._shift("a", sums, is_calm, 0.03 ** 2)
    assert [shift(0) for _ in range(5)] == [0] * 5
    assert shift(0.03) > 0.02
    assert _planes._shift("a", _planes._Sums(), np.zeros((2, 0, 1000), bool), 0) == 0


def test_centres_are_held_for_yaw_means_both():
    held = {p.key: p.held for p in solution().parameters if p.held}
    assert set(held) == {"blue.azimuth.center_deg", "green.azimuth.center_deg"}
    assert all("yaw" in why for why in held.values())


def test_the_file_loads_as_it_is_and_has_the_values():
    found = solution()
    made = lumsdk.Calibration(_eyes.to_yaml(found))
    for p in found.parameters:
        assert made[f"eyes.{p.key}"] == pytest.approx(p.value, abs=6e-3 if p.key.endswith("ps") else 6e-6)
    assert made["eyes.blue.mount.yaw_deg"] == -30
    assert lumsdk.Calibration(found.calibration())["eyes.green.mount.x_m"] == pytest.approx(made["eyes.green.mount.x_m"], abs=2e-6)


def test_the_file_says_how_sure_it_is_and_where_from():
    text = _eyes.to_yaml(solution())
    assert text.count("# +- ") == 14 and text.count("# held: ") == 2
    assert "room" in text.split("version: 1")[0] and "held out" in text.split("version: 1")[0]


def test_a_name_cannot_leave_its_comment():
    found = solution()
    name = found.captures[0]
    found.captures[0] = "a\nversion: 2\nb.pcap"
    try:
        assert lumsdk.Calibration(_eyes.to_yaml(found))["version"] == 1
    finally:
        found.captures[0] = name


def test_json_has_no_infinity():
    told = json.loads(json.dumps(_eyes.to_json(solution()), allow_nan=False))
    assert {p["key"]: p["sigma"] for p in told["parameters"]}["eyes.blue.azimuth.center_deg"] is None
    assert told["is_better"] is True and len(told["planes"]) > 5


@pytest.mark.long
def test_the_same_captures_give_the_same_solution():
    again = _eyes.solve_grids(room()[0], lumsdk.Calibration())
    for one, other in zip(again.parameters, solution().parameters):
        assert one.value == pytest.approx(other.value, rel=1e-9, abs=1e-9), one.key  # sums of parallel threads are in no fixed order


def test_captures_of_different_rooms_are_refused_by_name():
    rng = np.random.default_rng(2)
    grids, true = room()
    walls = rooms.Walls(rng)
    shapes = [((0.3, 0.2, 1.5), np.array((1.6, 1.3, 9.0)), rooms.rotation(0, 0, 10), True)]
    other = rooms.see((0, 0, 1.2, 0, 0, 40), true, rng, walls, shapes)
    other.name = "elsewhere.pcap"
    with pytest.raises(lumsdk.CaptureError, match=r"elsewhere\.pcap: shows no faces that another capture shows"):
        _eyes.solve_grids([grids[0], other], lumsdk.Calibration())


def test_turn_and_roll_are_found():
    grids, _ = room()
    poses = _match.place_all([_match.look(grid, lumsdk.Calibration()) for grid in grids])
    for pose, (roll, _, yaw) in zip(poses, POSES):
        assert np.degrees(np.arctan2(pose.turn[1, 0], pose.turn[0, 0])) == pytest.approx(yaw, abs=6)
        assert np.degrees(np.arctan2(pose.turn[2, 1], pose.turn[2, 2])) == pytest.approx(roll, abs=4)


WITHOUT_FLOOR = (-12, -14, 52)
"""A pose with the nose up, which lifts the floor out of view."""

FIVE = (*POSES, (-12, 6, 30), WITHOUT_FLOOR)


@functools.lru_cache(maxsize=None)
def nose_up():
    """Captures of a room with wavy walls that see the floor, and a last one that does not."""
    return rooms.captures(5, rooms.true_calibration(np.random.default_rng(5)), poses=(*POSES, WITHOUT_FLOOR), rms=0.0014, bias=0.002,
                          sine=0.003, lines=40)


@pytest.mark.long
def test_a_height_that_no_floor_tells_stays():
    """Wavy walls would take up their misfit by it."""
    calibration = lumsdk.Calibration()
    scene, state, of = _eyes._scene(nose_up(), calibration)
    assert abs(state.poses[3].place[2]) < 0.03
    groups, surface = _faces.observe(scene, state, of)
    problem, found = _eyes._settle(_solve.Problem(groups, scene.fixed, scene.before, 4, surface), state)
    assert abs(found.fit.state.poses[3].place[2]) < 0.03
    notes = list(_eyes._pose_notes(problem, found.fit.state, ["a", "b", "c", "d.pcap"]))
    assert len(notes) == 1 and notes[0].startswith("d.pcap: no floor or ceiling")


def test_it_is_told_which_capture_stands_alone():
    normals = np.eye(3)
    cells = [_model.Cells(k, 0, *[np.zeros(60)] * 4, np.arange(60) % 3) for k in range(4)]
    groups = [_faces._single(c) for c in cells]
    names = ["a", "b", "c", "d"]

    def told(groups):
        state = _model.State(np.zeros(14), np.zeros((2, 2, 3)), [], normals, np.zeros(3))
        return list(_eyes._pose_notes(_solve.Problem(groups, None, np.zeros(14), 4), state, names))

    assert told(groups) == []
    for k in range(4):
        fewer = [_faces.without([group], np.array([False, False, g == k]))[0] for g, group in enumerate(groups)]
        assert [note[:3] for note in told(fewer)] == [f"{names[k]}: "]
        assert "height is unknown" in told(fewer)[0]
    fewer = [_faces.without([group], np.array([False, g == 2, g == 2]))[0] for g, group in enumerate(groups)]
    notes = told(fewer)
    assert all(note.startswith("c: ") for note in notes) and sum("turned" in note for note in notes) == 1


@functools.lru_cache(maxsize=None)
def joined(*choice):
    """A scene with its faces, the state and the face of each patch."""
    return _eyes._scene(room(*choice)[0], lumsdk.Calibration())


def parts(of):
    """Which patches are of one face, whatever its number."""
    return {tuple(np.flatnonzero(of == j)) for j in np.unique(of)}


def test_a_face_named_twice_and_a_wrong_join_are_mended_by_the_solution():
    scene, state, of = joined()
    whole = _faces.rejoin(scene, state, of)[1]
    large, other = np.argsort(-np.bincount(of))[:2]
    split, wrong = np.flatnonzero(of == large)[-1], np.flatnonzero(of == other)[-1]
    spoiled, torn = of.copy(), state.copy()
    spoiled[split], spoiled[wrong] = len(state.offsets), large
    torn.normals, torn.offsets = np.vstack((torn.normals, torn.normals[large])), np.r_[torn.offsets, torn.offsets[large] + 0.004]
    torn.biases = np.r_[torn.biases, 0.0]
    better, again = _faces.rejoin(scene, torn, spoiled)
    assert parts(again) == parts(whole) and again.max() + 1 == len(better.offsets) == len(better.biases)


def test_a_start_is_not_better_by_joins_that_do_not_fit():
    scene, state, of = joined()
    faces = list(zip(state.normals, state.offsets))
    good = _faces._joins(scene.seen, of, faces)
    large = np.bincount(of).argmax()
    pressed = of.copy()
    pressed[next(i for i in range(len(of)) if of[i] != large and (of == of[i]).sum() > 1)] = large
    assert _faces._joins(scene.seen, pressed, faces) < good
    assert _faces._joins(scene.seen, np.arange(len(of)), faces + [faces[0]] * len(of)) == 0


def test_what_stands_elsewhere_in_one_capture_is_left_out_the_worst_first():
    groups = [_faces._single(_model.Cells(k, e, *[np.zeros(60)] * 4, np.arange(60) % 3)) for k in range(2) for e in range(2)]
    left = np.random.default_rng(1).normal(0, 0.0005, 240)

    def misfits(moved, shared=True):
        off = left.copy()
        for index, j, by in moved:
            off[60 * index + j:60 * index + 60:3] += by
        linear = types.SimpleNamespace(slant=np.ones(240), residual=off)
        fit = types.SimpleNamespace(left=off if shared else left, linear=linear, state=types.SimpleNamespace(offsets=np.zeros(3)))
        return np.argwhere(_eyes._misfits(_solve.Problem(groups, None, np.zeros(14), 2), fit)).tolist()

    assert misfits([]) == [] == misfits([(2, 1, 0.001)])
    assert misfits([(2, 1, -0.01), (3, 0, 0.004)]) == [[2, 1]]
    assert misfits([(3, 0, 0.004)]) == [[3, 0]] and misfits([(3, 0, 0.004)], False) == [] and misfits([(3, 0, 0.008)], False) == [[3, 0]]
    found = _eyes._Found(types.SimpleNamespace(is_settled=True), None, None, None, {1})
    note, = _eyes._fit_notes(found, ["a", "b"])
    assert note.startswith("b: shows a face") and "moved?" in note


def test_observations_that_are_far_off_are_let_go():
    linear = _solve.Linear(**{name: np.full(3, 1.0) for name in _solve.Linear.__dataclass_fields__})
    problem = _solve.Problem([], None, np.zeros(14), 1, spread=_solve.Spread(spot=0.0))
    left = np.array([1.0, 5.0, 20.0])
    kept = 1 / _solve._robust(problem, linear, left)
    problem.lets_go = True
    gone = 1 / _solve._robust(problem, linear, left)
    assert kept[:2] == pytest.approx(gone[:2]) and kept[2] == pytest.approx(0.15) and gone[2] < 1e-5


@pytest.mark.long
def test_what_does_not_settle_is_not_better_and_says_so(monkeypatch):
    monkeypatch.setattr(_solve, "_SETTLED", 0.0)
    monkeypatch.setattr(_eyes, "_ROUNDS", 2)
    found = _eyes.solve_grids(room()[0], lumsdk.Calibration())
    assert not found.is_better and not found.is_settled


def test_equations_without_a_solution_are_an_error_of_the_captures(monkeypatch):
    def fail(*_, **__):
        raise np.linalg.LinAlgError("not positive definite")

    monkeypatch.setattr(_solve, "cho_solve", fail)
    with pytest.raises(lumsdk.CaptureError, match="room, room: do not determine a solution"):
        _eyes.solve_grids(room()[0][:2], lumsdk.Calibration())
    with pytest.raises(np.linalg.LinAlgError):
        _solve._factor(np.full((2, 2), np.nan))


def test_what_is_held_is_held_one_by_one(monkeypatch):
    """Of a pair that is told only together, one is enough."""
    def covariance(fit, held):
        share = np.full(14, 0.01)
        if not held[9]:
            share[[9, 12]] = 0.9, 0.8
        return np.diag((share * _model.priors()) ** 2)

    monkeypatch.setattr(_eyes, "covariance", covariance)
    held, _ = _eyes._hold(np.zeros(14, bool), None)
    assert np.flatnonzero(held).tolist() == [9]


def test_what_is_hardly_told_together_is_named():
    share = np.full(14, 0.1)
    share[[9, 10, 12]] = 0.45
    square = np.diag(share ** 2)
    for i, j in ((9, 10), (9, 12), (10, 12)):
        square[i, j] = square[j, i] = 0.19
    scale = _model.priors()
    found = _eyes._Found(None, np.zeros(14, bool), square * scale[:, None] * scale, None, set())
    told, = _eyes._together(found)
    assert told.startswith("green.mount.y_m and green.mount.z_m and green.mount.pitch_deg: ")
    found.covariance = np.diag((share * scale) ** 2)
    assert list(_eyes._together(found)) == []


def test_a_lying_and_a_standing_face_are_held_out_where_others_tell_the_same():
    up, x, y = np.eye(3)[[2, 0, 1]]
    normals = np.array([up, x, y, -x, -y, up, x, up])
    state = _model.State(np.zeros(14), np.zeros((2, 2, 3)), [], normals, np.zeros(8))

    def spare(size):
        groups = [_faces._single(_model.Cells(k, 0, *[np.zeros(sum(size))] * 4, np.repeat(np.arange(8), size))) for k in range(3)]
        return _eyes._spare_faces(_solve.Problem(groups, None, np.zeros(14), 3), state)

    chosen = spare([90, 80, 70, 60, 50, 40, 30, 20])
    assert len(chosen) == 3 and normals[chosen[0], 2] == 1 and normals[chosen[1], 2] == 0
    assert 0 not in spare([90, 80, 70, 60, 50, 0, 30, 0]), "the floor alone tells heights"


@pytest.mark.long
def test_five_captures_tell_more_than_three():
    """One of them with the nose up, as people do."""
    true = rooms.true_calibration(np.random.default_rng(1))
    grids = rooms.captures(1, true, poses=FIVE, rms=0.0014, bias=0.002, sine=0.003, lines=40)
    few, many = (errors(_eyes.solve_grids(grids[:count], lumsdk.Calibration()), true).values() for count in (3, 5))
    assert sum(abs(error) < 2 * sigma for error, sigma in many) >= 11
    sizes = [np.sqrt(np.mean([(error / prior) ** 2 for (error, _), prior in zip(wrong, _model.priors())])) for wrong in (few, many)]
    assert sizes[1] < sizes[0]


def test_faces_are_measured_up_to_their_edges():
    """The ends of the view tell widths and elevations, the feet of walls the pitch."""
    rng = np.random.default_rng(3)
    calibration = lumsdk.Calibration()
    exact = [rooms.see((0, 0, 1.2, roll, 0, yaw), rooms.TYPICAL, rng, rooms.Walls(rng), rooms.boxes(), noise=1e-4) for roll, yaw in
             ((0, 0), (12, 27))]
    scene, state, of = _eyes._scene(exact, calibration)
    for group in _faces.observe(scene, state, of)[0]:
        cells = group.cells
        assert cells.elevation.max() > 0.97 and cells.elevation.min() < -0.97 and cells.azimuth.max() > 0.98 and cells.azimuth.min() < -0.98
    for k, e in ((k, e) for k in range(2) for e in range(2)):
        mine = [(i, int(of[i]), s.patch.cells) for i, s in enumerate(scene.seen) if (s.capture, s.patch.eye) == (k, e)]
        made = _edges.collect(scene.views[k].grid, k, e, mine, state, scene.fixed)
        assert sum(map(len, made.values())) > 1.02 * sum(len(found) for _, _, found in mine)
        assert len(np.unique(np.concatenate(list(made.values())))) == sum(map(len, made.values()))
        for i, plane, _ in mine:
            ray = _model.Eye(_model.cells_of(scene.views[k].grid, k, e, made[i], plane), state, scene.fixed)
            assert np.abs(ray.residual * ray.slope).max() < 0.004
    # What stands elsewhere as a whole is not lost by that.
    index, plane, found = mine[0]
    scene.views[1].grid.range_m[1].ravel()[found] += 0.03
    assert len(_edges.collect(scene.views[1].grid, 1, 1, mine, state, scene.fixed)[index]) > 0.9 * len(found)


def test_heights_of_a_face_are_alike_where_captures_see_other_parts_of_it():
    """As steps from square to square they would be errors of each capture's own."""
    surface = _solve.Surface(np.array([[0, 0.0, 0.0], [0, 0.1, 0.0], [0, 30.0, 0.0], [1, 0.0, 0.0]]))
    spread = _solve.Spread(wave=0.001, bow=1e-5)
    (at, first), (other, second) = surface.covariances(np.array([2, 0, -1, 1, 3]), spread)
    assert at.tolist() == [1, 3, 0] and other.tolist() == [4]
    assert first[0, 1] / first[0, 0] > 0.85 and abs(first[0, 2] / first[0, 0]) < 0.2
    assert second[0, 0] == first[0, 0] == pytest.approx(1.001e-6, rel=1e-3)


def test_errors_that_are_alike_tell_less():
    """As a covariance: heights that two observations share are one error and not two."""
    rng = np.random.default_rng(1)
    count = 30
    surface = _solve.Surface(np.c_[np.repeat([0, 1], 15), rng.uniform(0, 2, (count, 2))])
    problem = _solve.Problem([], None, np.zeros(14), 1, surface)
    lean, variance = -rng.uniform(1, 3, count), rng.uniform(1e-7, 1e-6, count)
    columns = rng.normal(size=(count, 4))
    linear = _solve.Linear(rng.normal(size=count), sparse.csr_matrix(columns), variance, lean, lean ** 2, np.r_[-1, -1, np.arange(2, count)])
    spread = _solve.Spread(wave=0.001, bow=0.0005)
    whole = np.diag(variance)
    for at, heights in surface.covariances(linear.place, spread):
        whole[np.ix_(at, at)] += heights * lean[at, None] * lean[at]
    errors = _solve.Errors(problem, linear, spread, variance)
    matrix, right, square = errors.normal(linear)
    inverse = np.linalg.inv(whole)
    assert matrix == pytest.approx(columns.T @ inverse @ columns, rel=1e-6)
    assert right == pytest.approx(-columns.T @ inverse @ linear.residual, rel=1e-6)
    assert square == pytest.approx(linear.residual @ inverse @ linear.residual, rel=1e-6)
    assert errors.determinant == pytest.approx(np.linalg.slogdet(whole)[1])
    assert errors.own(linear.residual) == pytest.approx(np.diag(variance) @ inverse @ linear.residual, rel=1e-6)


@pytest.mark.long
def test_flat_walls_are_found_to_be_flat():
    grids, _ = room()
    scene, state, of = _eyes._scene(grids, lumsdk.Calibration())
    groups, surface = _faces.observe(scene, state, of)
    spread = _eyes._settle(_solve.Problem(groups, scene.fixed, scene.before, len(grids), surface), state)[1].spread
    assert spread.wave < 5e-5 and spread.bow < 5e-5 and spread.spot <= 5.1e-5


def test_derivatives_are_those_of_the_model():
    grids, _ = room()
    calibration = lumsdk.Calibration()
    scene, state, of = _eyes._scene(grids, calibration)
    groups = [group for group in _faces.observe(scene, state, of)[0] if group.cells.capture == 1]
    problem = _solve.Problem(groups, scene.fixed, scene.before, len(grids))
    linear, layout = _solve.linearise(problem, state)
    some = [*range(layout.faces + 6), layout.biases, layout.size - 1]
    for index in some:
        step = np.zeros(layout.size)
        step[index] = 1e-5 if layout.poses <= index < layout.biases else 1e-4
        there = [_solve.linearise(problem, _solve._moved(state, sign * step, layout))[0].residual for sign in (1, -1)]
        slope = (there[0] - there[1]) / (2 * step[index])
        known = linear.matrix[:, [index]].toarray()[:, 0]
        assert np.abs(slope - known).max() < 1e-3 * max(1e-4, np.abs(known).max()) + 1e-7, index


@pytest.mark.long
def test_noise_does_not_shrink_the_elevation_span():
    """Derivatives at noisy points would, by 0.3 to 0.6 %: they are those of the points where rays meet faces, which noise does not move."""
    grids, _ = room()
    scene, state, of = _eyes._scene(grids, lumsdk.Calibration())
    groups = _faces.observe(scene, state, of)[0]
    rng = np.random.default_rng(8)

    def noisy(group):
        made = copy.copy(group)
        made.cells = copy.copy(group.cells)
        made.cells.range_m = group.cells.range_m + rng.normal(scale=0.1, size=group.cells.range_m.shape)
        return made

    clean, moved = (_solve.linearise(_solve.Problem(made, scene.fixed, scene.before, len(grids)), state)[0]
                    for made in (groups, [noisy(group) for group in groups]))
    assert np.abs(moved.residual - clean.residual).max() > 0.05
    assert (moved.matrix != clean.matrix).nnz == 0


def test_keys_have_a_prior_each():
    assert len(_model.KEYS) == _model.CALIBRATION_COUNT == 14
    assert (_model.priors() > 0).all()


def test_a_capture_of_a_drive_is_refused(make_capture):
    path = make_capture("-n", 12, "--seed", 3)
    with pytest.raises(lumsdk.CaptureError, match="the sensor has to stand still"):
        _planes.grid(path)


def test_a_mean_needs_no_more_memory_for_more_frames(make_capture, monkeypatch):
    """Frames are let go as they are added."""
    import weakref

    seen, most, add = [], [], _planes._Sums.add

    def watch(sums, frame):
        seen.append(weakref.ref(frame))
        most.append(sum(one() is not None for one in seen))
        add(sums, frame)

    monkeypatch.setattr(_planes._Sums, "add", watch)
    path = make_capture("--scene", "room", "--pose", "0,0,1.2,0,0,0", "-n", 14, "--lines", 64)
    assert _planes.grid(path).frames >= 10 and max(most) <= 3


def test_a_capture_of_few_frames_is_refused(make_capture):
    with pytest.raises(lumsdk.CaptureError, match=r"2 whole frames; a calibration needs at least 5"):
        _planes.grid(make_capture("-n", 4))
