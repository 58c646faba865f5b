"""lumdump as a child, and what comes from it: an MCAP stream with messages of ROS 2 (docs/formats.md)."""
import contextlib
import ctypes
import fcntl
import functools
import os
import re
import signal
import struct
import subprocess
import threading

PR_SET_PDEATHSIG = 1
F_SETPIPE_SZ = 1031  # fcntl has it since Python 3.10
PIPE_BYTES = 1 << 20  # the most without privileges
LIBC = ctypes.CDLL(None)

# Options of lumdump by other names than the node's parameters.
PARAMETERS = {"smooth": "smoothing", "range": "range_min, ~range_max"}
OPTION = re.compile(r"--(calibration|profile|edge|return|range|smooth|sensor|port|interface|laser|lines)\b")
KERNEL_DROPS = re.compile(r"the system dropped (?:at least )?(\d+) datagrams so far")
NO_SOURCE = re.compile(r"^(standard input|-): ")


def die_with_parent(parent):
    """In the child: SIGTERM when the thread that started it is gone, also by SIGKILL."""
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:  # it has gone already
        os.kill(os.getpid(), signal.SIGTERM)


class Lumdump:
    """A run of lumdump. The thread that starts it has to outlive it. What it says goes to say(level, text)."""

    def __init__(self, arguments, say, stdin=subprocess.DEVNULL, files=(), source="-"):
        self.say, self.source = say, source
        self.kernel_drops = 0
        try:
            self.process = subprocess.Popen(
                ["lumdump", *arguments, "-o", "-", "--format", "mcap", "--compression", "none"], stdin=stdin,
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=1 << 20, pass_fds=files, start_new_session=True,
                preexec_fn=functools.partial(die_with_parent, os.getpid()))
        except OSError as error:
            raise RuntimeError(f"lumdump cannot be started: {error.strerror}; it belongs to lumsdk and has to be in the "
                               "PATH") from error
        with contextlib.suppress(OSError):
            fcntl.fcntl(self.process.stdout, F_SETPIPE_SZ, PIPE_BYTES)
        self.listener = threading.Thread(target=self.relay)
        self.listener.start()

    def relay(self):
        for line in self.process.stderr:
            self.hear(line.decode(errors="replace").rstrip())

    def hear(self, line):
        """Its warnings and errors, by the names of the node's parameters; the summary is for information."""
        head, command, copied = line.partition("lumctl ")  # what is to be copied stays
        text = OPTION.sub(lambda m: "~" + PARAMETERS.get(m[1], m[1]), head) + command + copied
        drops = KERNEL_DROPS.search(text)
        self.kernel_drops = int(drops[1]) if drops else self.kernel_drops
        for prefix, level in ("lumdump: warning: ", "warn"), ("lumdump: ", "error"):
            if text.startswith(prefix):
                text = NO_SOURCE.sub(f"{self.source}: ", text[len(prefix):])
                self.say("info" if text.endswith(": the laser is off") else level, text)
                return
        if text.split() == ["laser", "off"]:
            text = "the laser is off"
        self.say("info", text)

    def signal(self, number=signal.SIGTERM):
        """It ends in good order; a second one ends what takes long."""
        if self.process.poll() is None:
            self.process.send_signal(number)

    def wait(self):
        """Its exit status, once all is heard. Its output has been read to the end, or is not wanted."""
        self.process.stdout.close()
        status = self.process.wait()
        self.listener.join()
        return status


# Records of MCAP: an operation, and bytes behind it.
RECORD = struct.Struct("<BQ")
CHANNEL, MESSAGE, CHUNK = 4, 5, 6
MESSAGE_HEAD = struct.Struct("<HIQQ")
CHUNK_HEAD_BYTES = 40  # of one that is not compressed


def _messages(data, topics):
    """Of the records that these bytes have; channels are noted."""
    at = 0
    while at + RECORD.size <= len(data):
        operation, size = RECORD.unpack_from(data, at)
        at += RECORD.size
        if operation == MESSAGE:
            channel, _, time_ns, _ = MESSAGE_HEAD.unpack_from(data, at)
            yield topics[channel], time_ns, data[at + MESSAGE_HEAD.size:at + size]
        elif operation == CHANNEL:
            number, _, length = struct.unpack_from("<HHI", data, at)
            topics[number] = str(data[at + 8:at + 8 + length], "utf-8")
        at += size


def chunks(stream):
    """Of each chunk its messages: topic, log time in ns, CDR."""
    topics = {}
    stream.read(8)  # the magic
    while len(head := stream.read(RECORD.size)) == RECORD.size:
        operation, size = RECORD.unpack(head)
        body = memoryview(stream.read(size))
        if operation == CHUNK and len(body) == size:
            yield _messages(body[CHUNK_HEAD_BYTES:], topics)
        elif operation == CHANNEL:
            list(_messages(memoryview(head + bytes(body)), topics))


class Cdr:
    """A message's fields, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 4

    def number(self, form):
        size = struct.calcsize(form)
        self.at += (4 - self.at) % size
        self.at += size
        return struct.unpack_from("<" + form, self.data, self.at - size)[0]

    def text(self):
        size = self.number("I")
        self.at += size
        return str(self.data[self.at - size:self.at - 1], "utf-8", "replace")

    def time_ns(self):
        return self.number("I") * 1_000_000_000 + self.number("I")


DATAGRAM = struct.Struct("<4xII4sH4sHII")


def datagram_of(data):
    """When it came, source, its port, destination, payload."""
    s, ns, source, port, destination, _, _, size = DATAGRAM.unpack_from(data)
    return s * 1_000_000_000 + ns, source, port, destination, data[DATAGRAM.size:DATAGRAM.size + size]


def cloud_of(data, point_bytes):
    """The stamp, and the points, behind which only is_dense stands."""
    cdr = Cdr(data)
    stamp_ns, _, _, width = cdr.time_ns(), cdr.text(), cdr.number("I"), cdr.number("I")
    return stamp_ns, data[len(data) - 1 - width * point_bytes:len(data) - 1]


def transforms_of(data):
    """Parent, child, x y z, quaternion of each."""
    cdr = Cdr(data)
    for _ in range(cdr.number("I")):
        cdr.time_ns()
        yield cdr.text(), cdr.text(), *(cdr.number("d") for _ in range(7))


def statuses_of(data):
    """Name, level, message, hardware and values of each."""
    cdr = Cdr(data)
    cdr.time_ns(), cdr.text()
    for _ in range(cdr.number("I")):
        level, name, message, hardware = cdr.number("B"), cdr.text(), cdr.text(), cdr.text()
        yield name, level, message, hardware, [(cdr.text(), cdr.text()) for _ in range(cdr.number("I"))]
