"""simulate() and SimulatedSensor: what lumsim makes, with its options by name and its sentences."""
import itertools
import os
import subprocess

import conftest
import pytest

import lumsdk

# Addresses of this file: one for each sensor, so that no test waits for another's port.
_numbers = itertools.count(1)


def address():
    return f"127.93.{os.getpid() % 100 + 100}.{next(_numbers)}"


def said_by_lumsim(*arguments):
    done = subprocess.run([str(conftest.BIN / "lumsim"), *arguments], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    return done.stderr.splitlines()[0].replace("lumsim: ", "", 1)


def test_bytes_are_those_that_lumsim_writes():
    expected = conftest.run("lumsim", "-q", "-o", "-", "-n", "2", "--seed", "5", "--loss", "0.01")
    assert lumsdk.simulate(frames=2, seed=5, loss=0.01) == expected


def test_a_path_gets_the_capture_and_is_returned(tmp_path):
    path = tmp_path / "street.pcap"
    assert lumsdk.simulate(path, frames=1) == str(path)
    assert path.read_bytes() == lumsdk.simulate(frames=1)
    assert os.listdir(tmp_path) == ["street.pcap"]


def test_single_keys_are_set_as_for_a_source():
    expected = lumsdk.simulate(frames=1, set=["eyes.blue.mount.x_m=1.5"])
    assert lumsdk.simulate(frames=1, set={"eyes.blue.mount.x_m": 1.5}) == expected
    assert lumsdk.simulate(frames=1, set={"eyes": {"blue": {"mount": {"x_m": 1.5}}}}) == expected
    assert lumsdk.simulate(frames=1, set="eyes.blue.mount.x_m=1.5") == expected != lumsdk.simulate(frames=1)


@pytest.mark.skipif(os.name == "nt", reason="needs signals of POSIX")
def test_control_c_at_a_terminal_ends_lumsim_once(tmp_path):
    assert conftest.interrupts_at_a_terminal(tmp_path, "lumsdk.simulate('a.pcap')") == "one"


def test_a_path_may_look_like_an_option(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert lumsdk.simulate("-x.pcap", frames=1) == "-x.pcap"
    assert os.path.exists("-x.pcap")


def test_every_way_to_give_a_calibration_is_the_same(tmp_path):
    values = {"eyes.blue.mount.yaw_deg": -31}
    file = tmp_path / "mine.yaml"
    file.write_text(lumsdk.Calibration(values).to_yaml())
    made = [lumsdk.simulate(frames=1, **given) for given in (
        {"calibration": values}, {"calibration": lumsdk.Calibration(values)}, {"calibration": file}, {"set": values},
        {"set": ["eyes.blue.mount.yaw_deg=-31"]})]
    assert all(one == made[0] for one in made)
    assert made[0] != lumsdk.simulate(frames=1)


def test_frames_of_a_simulation_are_read(tmp_path):
    truth = tmp_path / "truth.csv"
    with lumsdk.open(lumsdk.simulate(frames=2, truth=truth)) as source:
        points = sum(len(frame) for frame in source)
    assert points == len(truth.read_text().splitlines()) - 1


def test_a_room_is_simulated_with_its_true_calibration(tmp_path):
    truth, points = tmp_path / "true.yaml", tmp_path / "points.csv"
    made = lumsdk.simulate(frames=1, scene="room", pose=(0, 0.1, 1.25, 0, 0, -20), walls="mild", noise=[0.01, 0.03],
                           truth=[truth, points], set={"eyes.blue.mount.x_m": 0.05})
    assert made == conftest.run("lumsim", "-q", "-o", "-", "-n", "1", "--scene", "room", "--pose", "0,0.1,1.25,0,0,-20",
                                "--walls", "mild", "--noise", "0.01,0.03", "--set", "eyes.blue.mount.x_m=0.05")
    assert lumsdk.Calibration(truth)["eyes.blue.mount.x_m"] == 0.05
    with lumsdk.open(made, calibration=truth) as source:
        assert sum(len(frame) for frame in source) == len(points.read_text().splitlines()) - 1


def test_a_rig_is_simulated(tmp_path):
    rig = lumsdk.Rig([{"name": "a", "address": "10.42.0.37", "interface": "eth0", "pose": {"z_m": 1.8}},
                      {"name": "b", "address": "10.42.0.37%eth1", "calibration": {"tof_lsb_ps": 12.5}, "pose": {"x_m": -1, "z_m": 1.8}}])
    made = lumsdk.simulate(tmp_path / "a.pcapng", frames=1, rig=rig, truth=tmp_path / "%s.csv")
    with lumsdk.open(made) as source:
        points = [len(frame) for frame in source]
    assert sum(points) == sum(len((tmp_path / f"{name}.csv").read_text().splitlines()) - 1 for name in "ab")
    rig.save(tmp_path / "rig.yaml")
    lumsdk.simulate(tmp_path / "b.pcapng", frames=1, rig=tmp_path / "rig.yaml")
    assert (tmp_path / "b.pcapng").read_bytes() == (tmp_path / "a.pcapng").read_bytes()
    with pytest.raises(TypeError, match="a rig is a path, a text of YAML, a mapping"):
        lumsdk.simulate(frames=1, rig=5)
    with pytest.raises(lumsdk.OptionError, match=r"'a' has an interface, and a pcap file .*; use"):
        lumsdk.simulate(frames=1, rig=rig)


def test_noise_is_one_number_or_several():
    assert lumsdk.simulate(frames=1, noise=0.01) == lumsdk.simulate(frames=1, noise=[0.01, 0.01])
    assert lumsdk.simulate(frames=1, noise=0.02) == lumsdk.simulate(frames=1) != lumsdk.simulate(frames=1, noise=0)


def test_a_sensor_stands_in_a_room():
    with lumsdk.SimulatedSensor(address(), scene="room", pose="0,0,1.2,0,0,25", walls="rough", noise=0.03, frames=1) as simulated:
        with lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
            frame = next(f for f in sensor.frames() if len(f) > 100_000)
    assert float(frame.xyz[:, 2].min()) > -1.4
    assert float(frame["range"].max()) < 6.5


@pytest.mark.parametrize(("options", "arguments"), [
    ({"scene": "room", "pose": [9, 0, 1, 0, 0, 0]}, ["--scene", "room", "--pose", "9,0,1,0,0,0"]),
    ({"noise": [2]}, ["--noise", "2"]), ({"walls": "mild"}, ["--walls", "mild"]),
    ({"frames": 0}, ["-n", "0"]), ({"lines": 65}, ["--lines", "65"]), ({"loss": 2}, ["--loss", "2"]),
    ({"time": "utc"}, ["--time", "utc"]), ({"set": ["a=b"]}, ["--set", "a=b"])])
def test_what_lumsim_refuses_raises_its_sentence(options, arguments):
    with pytest.raises(lumsdk.OptionError) as refused:
        lumsdk.simulate(**options)
    assert str(refused.value) == said_by_lumsim("-q", "-o", "-", *arguments)


def test_a_capture_that_cannot_be_written_raises(tmp_path):
    with pytest.raises(lumsdk.Error, match="cannot create it: the directory does not exist"):
        lumsdk.simulate(tmp_path / "nowhere" / "street.pcap", frames=1)


def test_wrong_types_tell_what_would_be_right():
    with pytest.raises(TypeError, match="use a path, or None for bytes"):
        lumsdk.simulate(3)
    with pytest.raises(TypeError, match="rate is .*, of type list"):
        lumsdk.simulate(rate=[10])
    with pytest.raises(TypeError, match="frmaes"):
        lumsdk.simulate(frmaes=3)
    with pytest.raises(TypeError, match="the address is 3"):
        lumsdk.SimulatedSensor(3)


def test_a_sensor_is_there_for_its_block():
    where = address()
    with lumsdk.SimulatedSensor(where, seed=0, frames=1) as sim:
        assert where in sim.events("start")[0]["address"]
        assert not sim.laser_on
        assert repr(sim) == f"<SimulatedSensor {where}: laser off>"
        conftest.run("lumctl", "--host", where, "status")
        sim.wait_for(lambda: sim.events("tlv"))
        with pytest.raises(lumsdk.SensorError, match="is taken by lumsim"):
            lumsdk.SimulatedSensor(where, frames=1)
    assert sim.events("stop")
    assert "ended" in repr(sim)
    with pytest.raises(lumsdk.SensorError, match="has ended"):
        sim.wait_for(lambda: False)
    sim.close()


def test_a_sensor_replays_a_capture(tmp_path):
    path = lumsdk.simulate(tmp_path / "street.pcap", frames=1)
    with lumsdk.SimulatedSensor(address(), replay=path, loop=True, port=5518) as sim:
        assert sim.events("start")[0]["replay"] == path
        assert sim.host.endswith(":5518")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs POSIX signals")
def test_a_fault_happens_when_it_is_asked_for():
    with lumsdk.SimulatedSensor(address(), frames=1, fault=["fan@USR1-USR2"]) as sim:
        sim.cue(1)
        sim.wait_for(lambda: sim.events("fault"))
        sim.cue(2)
        assert sim.wait_for(lambda: sim.events("fault")[1:])[0]["ends"]
        with pytest.raises(lumsdk.OptionError, match="use 1 or 2"):
            sim.cue(3)
    with pytest.raises(lumsdk.ClosedError):
        sim.cue(1)


def test_what_a_sensor_refuses_raises_its_sentence():
    with pytest.raises(lumsdk.OptionError) as refused:
        lumsdk.SimulatedSensor("127.93.0.1", fault="fan")
    assert str(refused.value) == said_by_lumsim("--fault", "fan")
    with pytest.raises(lumsdk.SensorError, match="not an address of this host|cannot"):
        lumsdk.SimulatedSensor("192.0.2.1")


def test_a_sensor_that_is_forgotten_ends():
    where = address()
    sim = lumsdk.SimulatedSensor(where, frames=1)
    del sim
    lumsdk.SimulatedSensor(where, frames=1).close()


def test_options_that_are_not_there_say_what_is(tmp_path):
    for options, said in (({"path": "circle"}, "path is given twice: .*motion="), ({"rigs": 1}, "no option rigs; did you mean rig?"),
                          ({"zzzz": 1}, "no option zzzz; there are path, frames")):
        with pytest.raises(TypeError, match=said):
            lumsdk.simulate(tmp_path / "a.pcap", **options)
    assert not list(tmp_path.iterdir())
