"""What script/bench --peers measures with: its captures, and loops that find the same points."""
import pathlib
import struct
import subprocess
import sys

import conftest
import pytest

BENCH = pathlib.Path(__file__).resolve().parents[1] / "bench"
sys.path.insert(0, str(BENCH))

import peer_captures  # noqa: E402
import peer_loop  # noqa: E402


def test_tiny_frames_are_frames(tmp_path):
    peer_captures.make_tiny(tmp_path / "tiny.pcap", 20)
    assert peer_loop.lumsdk(str(tmp_path / "tiny.pcap")) == 200
    assert peer_loop.memory(str(tmp_path / "tiny.pcap"))[2] == 20


def test_the_loop_in_c_finds_the_same_points(capture):
    reader = conftest.BIN.parent / "bench" / "bench_read"
    if not reader.is_file():
        pytest.skip("the build has no benches")
    said = subprocess.run([reader], input=f"frames {capture}\nread {capture}\n", capture_output=True, text=True, check=True)
    points, size = (int(line.split()[2]) for line in said.stdout.splitlines())
    assert points == peer_loop.lumsdk(str(capture))
    assert size == capture.stat().st_size


def test_packets_of_the_vlp16_are_as_its_data_sheet_says(tmp_path):
    peer_captures.make_velodyne(tmp_path / "v.pcap", 100)
    data = (tmp_path / "v.pcap").read_bytes()
    assert len(data) == 24 + 100 * (16 + 42 + 1206)
    seconds, micros, kept, length = struct.unpack_from("<IIII", data, 24 + 99 * 1264)
    assert (seconds, kept, length) == (1_700_000_000, 1248, 1248) and micros == round(99 * 12 * 110.592)
    payload = data[24 + 16 + 42:][:1206]
    assert payload[:2] == b"\xff\xee" and payload[100:102] == b"\xff\xee"
    assert struct.unpack_from("<H", payload, 100 + 2)[0] == 40  # hundredths of a degree
    assert payload[1204:] == b"\x37\x22"


def test_a_worker_answers_each_line(capture):
    worker = subprocess.run([sys.executable, "-B", BENCH / "peer_loop.py", "lumsdk", capture], input="again\nagain\n",
                            capture_output=True, text=True, check=True)
    answers = [line.split() for line in worker.stdout.splitlines()]
    assert len(answers) == 2 and answers[0][2] == answers[1][2] and float(answers[0][0]) > 0
