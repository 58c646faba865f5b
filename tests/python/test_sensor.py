"""A live sensor: its laser goes off on every way out, its frames are whole, and what goes wrong is said."""
import functools
import gc
import itertools
import multiprocessing
import os
import pathlib
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest
from conftest import PATIENCE_S

import lumsdk
from lumsdk import _commands, _laser, _session

# Addresses of this file: one for each sensor, so that no test waits for another's port.
_numbers = itertools.count(1)


def address():
    return f"127.93.{os.getpid() % 100}.{next(_numbers)}"


class Simulated(lumsdk.SimulatedSensor):
    """Waited for as long as it takes on a busy machine."""

    def wait_for(self, condition, seconds=PATIENCE_S):
        return super().wait_for(condition, max(seconds, PATIENCE_S))


# One frame is soon rendered, and played again and again.
start = functools.partial(Simulated, frames=1)


@pytest.fixture(scope="module")
def simulated():
    """A sensor that several tests use, one after the other."""
    with start(address()) as sim:
        yield sim


@pytest.fixture(scope="module")
def silent():
    """A sensor that does not answer."""
    with start(address(), fault="silence@0") as sim:
        sim.wait_for(lambda: sim.events("fault"))
        yield sim


class Fake:
    """A sensor whose answers have a status, or none to `d`. It notes what it is asked: u, d, or a point for a status. Where it
    falls, other commands bring an alert of a hazard in place of an answer."""

    def __init__(self):
        self.host, self.asked, self.status, self.hides, self.falls = address(), "", 0x0200, False, False
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((self.host, 5517))
        self.thread = threading.Thread(target=self.serve)

    def serve(self):
        while True:
            packet, client = self.socket.recvfrom(2048)
            if packet == b"end":
                return
            if len(packet) >= 16 and packet[8] == 7:
                asked = packet[20:21].decode() or "."
                self.asked += asked
                if self.falls and asked not in "ud.":
                    self.socket.sendto(packet[:12] + struct.pack("<IHHH", 1 << 31, 2, 2, 0x0840), client)
                    continue
                self.status = 0x0800 if asked == "u" else 0x0200 if asked == "d" and not self.hides else self.status
                status = b"" if asked == "d" and self.hides else struct.pack("<HHH", 2, 2, self.status)
                self.socket.sendto(packet[:16] + status, client)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.socket.sendto(b"end", (self.host, 5517))
        self.thread.join()
        self.socket.close()


def downs(sim):
    """How often its laser went down, and whether a command did it each time."""
    statuses = sim.events("status")
    ends = [e["t"] for e in sim.events("laser") if not e["up"]]
    by_command = []
    for end in ends:
        bits = [s["bits"] for s in statuses if s["t"] <= end + 1e-5][-1]
        by_command.append("TLV_CMD_OFF" in bits and "HEARTBEAT_TIMEOUT" not in bits)
    return by_command


def went_down(sim, count):
    """Wait for the laser to go down again: whether a command did it."""
    return sim.wait_for(lambda: downs(sim)[count:])[0]


# --- The laser ---


def test_the_laser_is_on_in_its_block_and_off_after_it(simulated):
    before = len(downs(simulated))
    with lumsdk.Sensor(simulated.host) as sensor:
        assert not sensor.status().laser_on
        with sensor.laser() as status:
            assert status.laser_on
            assert status.bits == ("TLV_CMD_ON",)
            assert "laser on" in repr(sensor)
            assert simulated.wait_for(lambda: simulated.laser_on)
        assert went_down(simulated, before)
        assert not sensor.status().laser_on
        assert sensor.status().laser_down
        assert "laser" not in repr(sensor)


def test_a_laser_that_no_bit_shows_down_may_be_up():
    with start(address(), boot_status=0) as sim, lumsdk.Sensor(sim.host) as sensor:
        status = sensor.status()
        assert (status.value, status.laser_on, status.laser_down, str(status)) == (0, False, False, "laser may be up: no bit set")
    with pytest.raises(lumsdk.OptionError, match="without the bit 0x0800"):
        start(address(), boot_status=0x800)


def test_the_laser_is_off_after_an_exception(simulated):
    before = len(downs(simulated))
    with pytest.raises(ZeroDivisionError), lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
        for _ in sensor.frames():
            raise ZeroDivisionError
    assert went_down(simulated, before)


def test_the_laser_is_off_when_a_generator_is_closed(simulated):
    before = len(downs(simulated))

    def points():
        with lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
            for frame in sensor.frames():
                yield frame.xyz

    made = points()
    assert next(made).shape[1] == 3
    made.close()
    assert went_down(simulated, before)


def test_closing_switches_off_what_was_switched_on(simulated):
    before = len(downs(simulated))
    sensor = lumsdk.Sensor(simulated.host)
    assert sensor.laser_on().laser_on
    sensor.close()
    assert went_down(simulated, before)
    sensor.close()
    with pytest.raises(lumsdk.ClosedError, match="open it again"):
        sensor.status()
    with pytest.raises(lumsdk.ClosedError):
        sensor.laser_off()
    with pytest.raises(lumsdk.ClosedError), sensor:
        pass
    assert sensor.counters["heartbeats"] > 0


def test_a_laser_of_others_is_left_alone(simulated):
    with lumsdk.Sensor(simulated.host) as owner, owner.laser():
        with lumsdk.Sensor(simulated.host, owns=False) as beside:
            assert beside.status().laser_on
        assert owner.status().laser_on


def test_a_session_that_does_not_own_can_switch(simulated):
    with lumsdk.Sensor(simulated.host) as owner, lumsdk.Sensor(simulated.host, owns=False) as beside:
        owner.status()
        assert beside.laser_on().laser_on
        assert not beside.laser_off().laser_on
        with pytest.raises(lumsdk.SensorError, match="without owns=False"):
            beside.frames()


def test_answers_that_are_lost_are_asked_for_again():
    with start(address(), answer_loss=0.3, seed=3) as sim:
        with lumsdk.Sensor(sim.host, timeout=0.05, retries=10) as sensor, sensor.laser():
            assert sim.wait_for(lambda: sim.laser_on)
        assert went_down(sim, 0)


def test_the_collector_switches_the_laser_off_and_complains(simulated):
    before = len(downs(simulated))
    sensor = lumsdk.Sensor(simulated.host)
    sensor.laser_on()
    with pytest.warns(ResourceWarning, match="<Sensor .* was not closed"):
        del sensor
        gc.collect()
    assert went_down(simulated, before)
    lumsdk.Sensor(simulated.host).close()  # the session is free again


def run(simulated, text, **options):
    """A program of its own, with a sensor as sys.argv[1]."""
    code = f"import os, signal, sys, threading\nimport lumsdk, lumsdk._laser\n{text}"
    return subprocess.Popen([sys.executable, "-B", "-c", code, simulated.host], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, **options)


def test_the_end_of_the_interpreter_switches_the_laser_off(simulated):
    before = len(downs(simulated))
    process = run(simulated, "sensor = lumsdk.Sensor(sys.argv[1])\nsensor.laser_on()\nkept = [sensor]")
    out, said = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, out, said) == (0, "", "")
    assert went_down(simulated, before)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_ctrl_c_ends_a_loop_and_switches_the_laser_off(simulated):
    before = len(downs(simulated))
    process = run(simulated, """
with lumsdk.Sensor(sys.argv[1]) as sensor, sensor.laser():
    for frame in sensor.frames():
        print(len(frame), flush=True)
""")
    assert process.stdout.readline() and process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == -signal.SIGINT
    assert said.endswith("KeyboardInterrupt\n")
    assert went_down(simulated, before)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize("wait", [
    "next(sensor.frames(silence=float('inf')))", "sensor.laser_on()", "sensor.status()", "sensor.time()"])
def test_ctrl_c_ends_any_wait_for_a_silent_sensor(silent, wait):
    """With many tries of a minute each, only Ctrl-C ends them in the time of a test."""
    process = run(silent, f"""
put_down = lumsdk._laser.put_down
lumsdk._laser.put_down = lambda *a: put_down(*a[:2], 0.2)
with lumsdk.Sensor(sys.argv[1], timeout=60, retries=20) as sensor:
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    try:
        {wait}
    except KeyboardInterrupt:
        print("interrupted")
    except lumsdk.LaserError as problem:
        print(type(problem.__cause__).__name__, problem)
""")
    out, said = process.communicate(timeout=PATIENCE_S)
    assert said == ""
    if wait == "sensor.laser_on()":
        assert out.startswith("KeyboardInterrupt ") and "laser off was not answered" in out
    else:
        assert out == "interrupted\n"


def test_an_interruption_of_frames_is_raised_once(simulated):
    with lumsdk.Sensor(simulated.host) as sensor:
        frames = sensor.frames()
        next(frames)
        frames._stream.failure = KeyboardInterrupt()
        with pytest.raises(KeyboardInterrupt):
            next(frames)
        with pytest.raises(StopIteration):
            next(frames)


def test_laser_off_that_is_not_answered_is_an_error_and_ends_the_heartbeats(monkeypatch):
    monkeypatch.setattr(_laser, "put_down", functools.partial(_laser.put_down, seconds=0.5))
    with start(address(), fault="silence@USR1") as sim:
        sensor = lumsdk.Sensor(sim.host)
        with pytest.raises(lumsdk.LaserError) as told, sensor.laser():
            sim.cue(1)
            sim.wait_for(lambda: sim.events("fault"))
        assert str(told.value) == (
            f"{sim.host}: laser off was not answered: it MAY BE ON or come on by itself; a working sensor switches it "
            f"off within 3 s, because the heartbeats have ended; make sure by lumctl --host {sim.host} laser off, or cut its power")
        assert told.value.news == "ended-unknown"
        with pytest.raises(lumsdk.ClosedError, match="laser off was not confirmed"):
            sensor.status()
        sensor.close()


def test_a_laser_that_was_not_seen_to_go_off_in_its_block_stays_the_error(monkeypatch):
    monkeypatch.setattr(_laser, "put_down", functools.partial(_laser.put_down, seconds=0.5))
    with start(address(), fault="silence@USR1") as sim:
        sensor = lumsdk.Sensor(sim.host)
        with pytest.raises(lumsdk.LaserError, match="laser off was not answered"), sensor.laser():
            sim.cue(1)
            sim.wait_for(lambda: sim.events("fault"))
            sensor.laser_off()
        sensor.close()


def test_a_closed_sensor_ends_the_block_of_its_laser(simulated):
    with lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
        sensor.close()
    assert not simulated.laser_on


def test_laser_off_is_repeated_with_a_word_and_given_up(silent, monkeypatch):
    monkeypatch.setattr(_laser, "_OFF_ALONE_S", 0.0)
    plan = _session.Plan(silent.host, None, lumsdk.Profile(), 0.4, 4)
    session, laser = plan.open(False), _laser.LaserSession(plan, False)
    with pytest.warns(lumsdk.SensorWarning, match="no answer yet: laser off is repeated for 1 s more; Ctrl-C gives up"):
        off = _laser.put_down(laser, session, 0.3)
    assert off.result == _laser.lib.LUM_LASER_OFF_UNKNOWN
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it must not end the attempt
        assert _laser.put_down(laser, session, 0.3).result == _laser.lib.LUM_LASER_OFF_UNKNOWN
    _laser.lib.lum_sensor_close(session)


# --- Hazards ---


def test_a_hazard_ends_the_frames_and_the_laser_stays_down():
    with start(address(), fault="fan@USR1-USR2") as sim, lumsdk.Sensor(sim.host) as sensor:
        with pytest.raises(lumsdk.HazardError, match=r"went off \(FAN_PWM_BAD\)"), sensor.laser():
            for i, _ in enumerate(itertools.islice(sensor.frames(), 200)):
                if i == 0:
                    sim.cue(1)
                    sim.wait_for(lambda: sim.events("fault"))
        assert sensor.status().hazards == ("FAN_PWM_BAD",)
        with pytest.raises(lumsdk.HazardError, match=r"stays down \(FAN_PWM_BAD"):
            sensor.laser_on()
        sim.cue(2)
        sim.wait_for(lambda: sim.events("fault")[1:])
        assert sensor.status().bits == ("TLV_CMD_OFF",)
        assert sim.wait_for(lambda: not sim.laser_on)


def test_a_laser_that_shows_up_after_an_off_without_a_status_is_switched_off_again():
    with Fake() as fake, lumsdk.Sensor(fake.host, owns=False, retries=0) as sensor:
        assert sensor.laser_on().laser_on
        fake.status, fake.hides = 0x0804, True
        with pytest.warns(lumsdk.SensorWarning, match="went off"), pytest.raises(lumsdk.LaserError) as told:
            sensor.status()
        assert told.value.news == "ended-unseen"
        fake.status, fake.hides = 0x0800, False
        assert not sensor.status().laser_on
        assert fake.asked.startswith("u.d") and fake.asked.count("d") == 2


def test_a_laser_that_fell_between_frames_ends_the_next_ones():
    with Fake() as fake, lumsdk.Sensor(fake.host, retries=0) as sensor:
        sensor.laser_on()
        fake.status = 0x0200
        with pytest.warns(lumsdk.SensorWarning, match="went off") as told:
            assert not sensor.status().laser_on
        assert told[0].message.news == "laser-fell"
        with pytest.raises(lumsdk.LaserError, match="went off"):
            sensor.frames()
        sensor.frames()


def test_a_session_that_owns_nothing_is_told_that_nobody_sends_heartbeats():
    with start(address()) as sim, lumsdk.Sensor(sim.host, owns=False) as sensor:
        with pytest.raises(lumsdk.LaserError, match="nobody sends heartbeats. Open a session that owns") as told:
            sensor.laser_on()
        assert told.value.news == "laser-refused"


def test_the_answer_to_laser_off_is_none_to_a_request():
    with Fake() as fake, lumsdk.Sensor(fake.host) as sensor:
        sensor.laser_on()
        fake.falls = True
        with pytest.raises(lumsdk.SensorError, match="laser off comes first"), pytest.warns(lumsdk.SensorWarning, match="FAN"):
            sensor.power(50)
        assert fake.asked.replace(".", "").startswith("u5d")


def test_a_hazard_of_a_laser_that_we_left_alone_is_a_warning():
    with start(address(), fault="board@0") as sim, lumsdk.Sensor(sim.host) as sensor:
        sim.wait_for(lambda: sim.events("fault"))
        with pytest.warns(lumsdk.SensorWarning, match="reports a hazard: BOARD_OVER_105"):
            assert list(sensor.frames(duration=1.5))


def test_a_laser_that_another_switches_off_is_an_error(simulated):
    with lumsdk.Sensor(simulated.host) as sensor, lumsdk.Sensor(simulated.host, owns=False) as other:
        with pytest.raises(lumsdk.LaserError, match=r"went off \(TLV_CMD_OFF: switched off by another"), sensor.laser():
            for i, _ in enumerate(itertools.islice(sensor.frames(), 200)):
                if i == 0:
                    other.laser_off()


def test_a_program_that_makes_no_call_loses_the_laser_and_is_told_why():
    with start(address()) as sim, lumsdk.Sensor(sim.host) as sensor:
        with pytest.raises(lumsdk.LaserError, match="sent no heartbeats for .* s.*only inside calls"), sensor.laser():
            with warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                for i, _ in enumerate(itertools.islice(sensor.frames(silence=PATIENCE_S), 200)):
                    if i == 0:
                        sim.wait_for(lambda: downs(sim))
        assert downs(sim)[:1] == [False]  # it was the sensor that did it
        assert all("the system dropped" in str(w.message) for w in warned)  # the pause is no silence of the sensor


# --- Frames ---


def test_frames_are_those_of_the_packets(tmp_path):
    """Also with other calls between them. What the system drops on a busy machine is tried again."""
    path = lumsdk.simulate(tmp_path / "street.pcap", frames=6)
    with lumsdk.open(path, columns="all") as source:
        expected = {frame.number: frame for frame in source}
    for _ in range(20):
        with Simulated(address(), replay=path, speed=0.7) as sim, lumsdk.Sensor(sim.host) as sensor:
            got = {}
            for frame in sensor.frames(columns="all", silence=PATIENCE_S):
                got[frame.number] = frame
                assert sensor.status().bits is not None
                if len(got) == 4:
                    break
            if sensor.losses["kernel_drops"]:
                continue
            assert sensor.counters["heartbeats"] >= 2
        for number, frame in got.items():
            assert frame.sensor == sim.address
            for name in set(expected[number].columns) - {"time"}:
                assert frame[name].tobytes() == expected[number][name].tobytes(), (number, name)
        return
    pytest.skip("the system dropped datagrams in each of twenty attempts")


def test_frames_take_the_options_of_open(simulated):
    with lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
        frame = list(itertools.islice(sensor.frames(eye="blue", columns=["range"], range="5:20"), 2))[1]
        assert frame.columns == ("range",)
        assert len(frame) and frame["range"].min() >= 5 and frame["range"].max() <= 20
        kept = frame["range"]
    assert np.isfinite(kept).all()


def test_a_calibration_of_the_sensor_is_that_of_its_frames(simulated):
    with lumsdk.Sensor(simulated.host, set={"eyes.blue.mount.x_m": 100}) as sensor, sensor.laser():
        assert sensor.calibration["eyes.blue.mount.x_m"] == 100
        first, second = itertools.islice(sensor.frames(eye="blue"), 2)
        assert len(second) and second["x"].min() > 50
        near = list(itertools.islice(sensor.frames(eye="blue", set={"eyes.blue.mount.x_m": 0}), 2))[1]
        assert near["x"].min() < 50
        del first


def test_a_duration_ends_the_frames(simulated):
    with lumsdk.Sensor(simulated.host) as sensor:
        frames = list(sensor.frames(duration=1.5))
        assert 2 <= len(frames)
        assert [f.number for f in frames] == list(range(frames[0].number, frames[0].number + len(frames)))
        assert not any(len(f) for f in frames)  # the laser is off


def test_frames_end_where_they_are_closed_or_begun_again(simulated):
    with lumsdk.Sensor(simulated.host) as sensor:
        with sensor.frames() as frames:
            assert next(frames).number == 1
        assert list(frames) == []
        assert "ended" in repr(frames)
        first = sensor.frames()
        next(first)
        second = sensor.frames()
        assert next(second).number == 1
        with pytest.raises(lumsdk.ClosedError, match="called again"):
            next(first)
        kept = next(second)
    with pytest.raises(lumsdk.ClosedError):
        next(second)
    assert kept.sensor == simulated.address


def test_a_cancel_of_another_thread_ends_the_frames():
    with lumsdk.Sensor(address()) as sensor:
        frames = sensor.frames(silence=float("inf"))
        timer = threading.Timer(0.1, sensor.cancel)
        timer.start()
        assert list(frames) == []
        timer.join()


def test_no_sensor_is_told_as_lumdump_tells_it():
    where = address()
    with lumsdk.Sensor(where, timeout=0.05) as sensor:
        with pytest.raises(lumsdk.SensorError) as told:
            next(sensor.frames(silence=0.3))
        assert str(told.value).startswith(f"no data from {where} within ")
        assert str(told.value).endswith("nor any answer; is it on, connected and at this address? It boots at 10.42.0.37; "
                                        f"look with lumctl --host {where} doctor")
        with pytest.raises(lumsdk.SensorError, match=r"does not answer; .* doctor .* \(tried 5 times, 50 ms each\)"):
            sensor.status()


def test_a_sensor_that_restarts_is_told():
    with start(address(), fault="reboot@USR1", clock=100_000_000) as sim, lumsdk.Sensor(sim.host) as sensor:
        frames = sensor.frames(silence=PATIENCE_S)
        next(frames)
        sim.cue(1)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            for _ in itertools.islice(frames, 200):
                if any("its clock began again" in str(w.message) for w in told):
                    break
        assert "restarted" in [getattr(w.message, "news", "") for w in told]


def test_a_sensor_that_vanishes_is_told():
    with start(address()) as sim, lumsdk.Sensor(sim.host) as sensor:
        frames = sensor.frames(silence=PATIENCE_S)
        numbers = [next(frames).number]
        sim.close()
        frames._stream._silence = 0.3
        with pytest.raises(lumsdk.SensorError, match="no data from .* for .*doctor finds out more"):
            numbers += [frame.number for frame in frames]
        assert numbers == list(range(1, len(numbers) + 1))
        assert list(frames) == []


def test_a_sensor_that_answers_and_sends_no_data_is_told(simulated):
    with lumsdk.Sensor(simulated.host, profile={"group.tag": 8}) as sensor:
        assert sensor.status().bits
        with pytest.raises(lumsdk.SensorError, match="none of them fits the layout; is a profile needed"):
            next(sensor.frames(silence=0.3))
        with pytest.raises(lumsdk.SensorError, match="none of them fits the layout; is a profile needed"):
            list(sensor.frames(duration=0.3))


@pytest.mark.filterwarnings("ignore:.*the system dropped")
def test_what_the_system_drops_is_counted_and_told(simulated, monkeypatch):
    monkeypatch.setattr(_session, "RECEIVE_BUFFER", 100_000)
    with lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
        frames = sensor.frames(silence=PATIENCE_S)
        next(frames)
        while not sensor.counters["kernel_drops"]:
            time.sleep(0.01)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            while not told:
                next(frames)
        assert "datagrams so far: its receive buffer was full" in str(told[0].message)
        assert told[0].filename == __file__
        assert sensor.losses["kernel_drops"] > 0
        assert sensor.losses["lost_words"] + sensor.losses["lines_skipped"] + sensor.losses["lines_missing_angles"] > 0


# --- Settings ---


def test_settings_arrive(simulated):
    with lumsdk.Sensor(simulated.host) as sensor:
        answer = sensor.power(50)
        assert answer.tries >= 1 and answer.status is not None
        sensor.threshold("green", 7)
        sensor.threshold("blue", np.int64(8))
        sensor.holdoff(200)
        sensor.offset("blue", 3)
        sensor.offset("green", 4)
        sensor.yscan(15)
        sensor.lines(64)
        sensor.send("100p 0g")
        assert sensor.tlv((1, b"0b")).status is not None
        simulated.wait_for(lambda: simulated.events("tlv")[-1]["note"] == "0b")
        sim_heard = " ".join(str(e.get("note")) for e in simulated.events("tlv"))
        for command in ("50p", "7g", "8b", "200h", "3B", "4G", "15y", "1f", "100p; 0g", "0b"):
            assert command in sim_heard


@pytest.mark.parametrize(("call", "says"), [
    (lambda s: s.power(101), "power: 101 is not a whole number from 0 to 100 percent"),
    (lambda s: s.holdoff(155), "holdoff: 155 is not a whole number from 150 to 250 in steps of 10"),
    (lambda s: s.lines(65), "lines: 65 is not 640 or 64"),
    (lambda s: s.threshold("red", 1), "threshold: 'red' is not an eye"),
    (lambda s: s.send("50q"), "'50q' is not a command"),
    (lambda s: s.send("101p"), "'101p': use 0 to 100"),
    (lambda s: s.send("u"), r"switched by laser_on\(\)"),
    (lambda s: s.tlv((70000, b"")), "a type from 0 to 65535"),
    (lambda s: s.tlv((9, b"x" * 2000)), "do not fit a packet"),
    (lambda s: s.frames(duration=0), "duration is 0; use a number of seconds above 0"),
    (lambda s: s.frames(set={"group.line.at": 15}), "the profile is that of the session|set"),
    (lambda s: s.frames(returns="best"), "returns is 'best'")])
def test_what_is_not_allowed_is_refused(simulated, call, says):
    with lumsdk.Sensor(simulated.host) as sensor, pytest.raises(lumsdk.OptionError, match=says):
        call(sensor)


@pytest.mark.parametrize(("call", "says"), [
    (lambda s: s.power("50"), "power: '50' is not a whole number"),
    (lambda s: s.power(True), "power: True is not a whole number"),
    (lambda s: s.send(b"50p"), "use a text"),
    (lambda s: s.tlv(5), "a TLV is a pair"),
    (lambda s: s.frames(duration="5"), "duration is '5', of type str; use a number of seconds"),
    (lambda s: s.frames(profile="x.yaml"), "the profile is that of the session"),
    (lambda s: s.frames(progress=print), "it is for captures"),
    (lambda s: s.frames(rig="rig.yaml"), r"move xyz by rig\[name\].pose"),
    (lambda s: s.frames(colums=["x"]), "did you mean columns")])
def test_wrong_types_tell_what_would_be_right(simulated, call, says):
    with lumsdk.Sensor(simulated.host) as sensor, pytest.raises(TypeError, match=says):
        call(sensor)


def test_refusals_are_read_as_lumctl_reads_them():
    assert _commands.refusal_of("50p", ["refused 50p: too much"]) == "refused 50p: too much"
    assert _commands.refusal_of("50p", ["50p set"]) is None
    assert _commands.refusal_of("50p", ["50p not set"]) is not None
    assert _commands.refusal_of("50p", ["fan at 20 %"]) is None
    assert _commands.refusal_of("50p", ["command denied"]) is not None
    assert _commands.refusal_of("50p", []) is None


def test_the_clock_is_told(simulated):
    with lumsdk.Sensor(simulated.host) as sensor:
        first = sensor.time()
        assert first.exchanges == 8 and first.error_ns > 0 and first.round_trip > 0
        booted = simulated.events("start")[0]
        assert booted["event"] == "start"
        assert abs(first.offset_ns / 1e9 + first.clock_us / 1e6 - time.time()) < 60
        assert sensor.time().exchanges == 16


# --- Sessions ---


@pytest.mark.parametrize(("host", "kind", "says"), [
    ("", lumsdk.OptionError, "the host is missing"), ("udp://", lumsdk.OptionError, "the host is missing"),
    ("udp://10.42.0.37/x", lumsdk.OptionError, "nothing may follow"),
    ("10.42.0.37:0", lumsdk.OptionError, "the port is not a number from 1 to 65535"),
    ("10.42.0.37:x", lumsdk.OptionError, "the port is not a number from 1 to 65535"),
    ("10.42.0", lumsdk.SensorError, "10.42.0"), ("256.1.1.1", lumsdk.SensorError, "256"),
    ("fe80::1", lumsdk.SensorError, "IPv4"), ("255.255.255.255", lumsdk.OptionError, "no sensor can have this address"),
    ("0.0.0.1", lumsdk.OptionError, "no sensor can have this address"), (37, TypeError, "use HOST or HOST:PORT")])
def test_a_wrong_host_is_told(host, kind, says):
    with pytest.raises(kind, match=says):
        lumsdk.Sensor(host)


def test_a_host_is_named_as_for_lumdump():
    where = address()
    with start(where, port=5600) as sim:
        for host in (f"udp://{where}:5600", f"{where}:5600"):
            with lumsdk.Sensor(host) as sensor:
                assert sensor.address == sim.host
                assert isinstance(sensor.status().value, int)
    with lumsdk.Sensor("localhost:5601") as sensor:
        assert sensor.address == "127.0.0.1:5601"


def test_one_program_owns_a_sensor(simulated):
    with lumsdk.Sensor(simulated.host):
        with pytest.raises(lumsdk.SensorError, match="this program has the session with"):
            lumsdk.Sensor(simulated.host)
        lumsdk.Sensor(simulated.host, owns=False).close()
    lumsdk.Sensor(simulated.host).close()


@pytest.mark.parametrize(("options", "kind"), [
    ({"timeout": 0}, lumsdk.OptionError), ({"timeout": "1"}, TypeError), ({"retries": -1}, lumsdk.OptionError),
    ({"retries": 1.5}, TypeError), ({"owns": 1}, TypeError), ({"interface": 3}, TypeError),
    ({"interface": "nosuch0"}, lumsdk.SensorError), ({"profile": {"no.key": 1}}, lumsdk.OptionError)])
def test_wrong_options_of_a_session_are_refused(options, kind):
    with pytest.raises(kind):
        lumsdk.Sensor(address(), **options)


def test_a_second_thread_is_refused_but_may_switch_off(simulated):
    with lumsdk.Sensor(simulated.host) as sensor, sensor.laser():
        frames = sensor.frames()
        next(frames)
        reading, problems, before = threading.Event(), [], len(downs(simulated))

        def read():
            try:
                for _ in frames:
                    reading.set()
            except lumsdk.Error as problem:
                problems.append(problem)

        thread = threading.Thread(target=read)
        thread.start()
        reading.wait()

        def is_refused():
            try:
                sensor.status()
            except lumsdk.SensorError as problem:
                return "in use by another thread" in str(problem)
            return False

        assert any(is_refused() for _ in range(1000))
        assert not sensor.laser_off().laser_on
        assert went_down(simulated, before)
        sensor.cancel()
        thread.join()
        assert not problems


def test_two_sensors_in_two_threads():
    found = {}

    def read(host):
        with lumsdk.Sensor(host) as sensor, sensor.laser():
            found[host] = [(frame.sensor, len(frame) > 0) for frame in itertools.islice(sensor.frames(), 1, 4)]

    with start(address()) as one, start(address()) as two:
        threads = [threading.Thread(target=read, args=(sim.host,)) for sim in (one, two)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert went_down(one, 0) and went_down(two, 0)
    assert found == {sim.host: [(sim.address, True)] * 3 for sim in (one, two)}


def fork_with_a_session(host):
    ready, told = os.pipe(), os.pipe()
    sensor = lumsdk.Sensor(host)
    sensor.laser_on()
    frames = sensor.frames()
    next(frames)
    child = os.fork()
    if child == 0:
        status = 2
        try:
            frames.close()
            sensor.close()
            sensor.status()
        except lumsdk.ClosedError as problem:
            status = 0 if "belongs to the process" in str(problem) else 1
            del frames, sensor
            gc.collect()
            os.write(told[1], b".")
            os.read(ready[0], 1)
        finally:
            os._exit(status)
    while not select.select([told[0]], [], [], 0)[0]:
        assert sensor.status().laser_on  # calls send the heartbeats, however long the child takes
    assert os.read(told[0], 1) == b"."
    assert len(next(frames)) >= 0
    assert sensor.status().laser_on
    sensor.close()
    lumsdk.Sensor(host).close()  # while the child lives
    os.write(ready[1], b".")
    assert os.waitpid(child, 0)[1] == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_fork_leaves_the_session_to_its_parent(simulated):
    """In a small process: to fork that of all tests, of some GB, can take longer than a heartbeat may be late."""
    process = multiprocessing.get_context("spawn").Process(target=fork_with_a_session, args=(simulated.host,))
    process.start()
    process.join()
    assert process.exitcode == 0


def test_the_readme_loop():
    """As the first lines of docs/python/live.md."""
    page = pathlib.Path(__file__).parents[2] / "docs/python/live.md"
    text = page.read_text(encoding="utf-8")
    code = text.split("```python\n", 1)[1].split("```", 1)[0]
    seen = []
    with start(address()) as sim:
        exec(compile(code.replace("10.42.0.37", sim.host), str(page), "exec"), {"use": seen.append})
    assert seen and all(array.shape[1] == 3 for array in seen)
