// What the decoder asks of a system, for files that lie in one folder and are only read. A file is
// { size, read(offset, length) }, where read gives a Uint8Array of at most that length.

const OK = 0;
const BAD_FILE = 8;
const BROKEN = 29; // an error of input or output
const NOT_THERE = 44;
const NOT_SUPPORTED = 58;
const FOLDER = 3; // its descriptor; 0 to 2 are the standard ones
const IS_FOLDER = 3;
const IS_FILE = 4;
const ALL_RIGHTS = 0xffffffffffffffffn;
const FROM_HERE = 1;
const FROM_END = 2;

export class Ended extends Error {}

// files: a Map by name. log: gets what is written to the standard outputs, in pieces.
export function makeWasi(files, log) {
    const open = new Map(); // by descriptor: { file, inode, at }
    const inodes = new Map([...files.keys()].map((name, i) => [name, i + 1]));
    let memory = null;

    const view = () => new DataView(memory.buffer);
    const bytes = (at, length) => new Uint8Array(memory.buffer, at, length);
    const nameAt = (at, length) => new TextDecoder().decode(bytes(at, length)).replace(/^(\.?\/)+/, "");

    // Fills the buffers that a call names, until one is filled only in part.
    function fill(vectors, count, read) {
        let total = 0;
        for (let i = 0; i < count; i++) {
            const at = view().getUint32(vectors + 8 * i, true);
            const length = view().getUint32(vectors + 8 * i + 4, true);
            const got = read(total, length);
            bytes(at, got.length).set(got);
            total += got.length;
            if (got.length < length) {
                break;
            }
        }
        return total;
    }

    function readAt(one, from, vectors, count, out) {
        const total = fill(vectors, count, (done, length) => {
            const left = Math.max(0, one.file.size - from - done);
            return one.file.read(from + done, Math.min(length, left));
        });
        view().setUint32(out, total, true);
        return total;
    }

    function writeStat(at, inode, type, size) {
        bytes(at, 64).fill(0);
        view().setBigUint64(at + 8, BigInt(inode), true);
        view().setUint8(at + 16, type);
        view().setBigUint64(at + 24, 1n, true);
        view().setBigUint64(at + 32, BigInt(size), true);
    }

    function stat(name, out) {
        if (name === "" || name === ".") {
            writeStat(out, 0, IS_FOLDER, 0);
            return OK;
        }
        if (!files.has(name)) {
            return NOT_THERE;
        }
        writeStat(out, inodes.get(name), IS_FILE, files.get(name).size);
        return OK;
    }

    function openFile(name, out) {
        if (!files.has(name)) {
            return NOT_THERE;
        }
        let fd = FOLDER + 1;
        while (open.has(fd)) {
            fd++;
        }
        open.set(fd, { file: files.get(name), inode: inodes.get(name), at: 0 });
        view().setUint32(out, fd, true);
        return OK;
    }

    function seek(one, offset, whence, out) {
        const bases = { [FROM_HERE]: one.at, [FROM_END]: one.file.size };
        one.at = (bases[whence] ?? 0) + Number(offset);
        view().setBigUint64(out, BigInt(one.at), true);
        return OK;
    }

    function describe(fd, out) {
        if (fd > FOLDER && !open.has(fd)) {
            return BAD_FILE;
        }
        bytes(out, 24).fill(0);
        view().setUint8(out, fd === FOLDER ? IS_FOLDER : fd < FOLDER ? 2 : IS_FILE);
        view().setBigUint64(out + 8, ALL_RIGHTS, true);
        view().setBigUint64(out + 16, ALL_RIGHTS, true);
        return OK;
    }

    function write(vectors, count, out) {
        let total = 0;
        for (let i = 0; i < count; i++) {
            const length = view().getUint32(vectors + 8 * i + 4, true);
            log?.(new TextDecoder().decode(bytes(view().getUint32(vectors + 8 * i, true), length)));
            total += length;
        }
        view().setUint32(out, total, true);
        return OK;
    }

    function now(clock, out) {
        const ms = clock === 0 ? Date.now() : performance.now();
        view().setBigUint64(out, BigInt(Math.round(ms * 1e6)), true);
        return OK;
    }

    // A file can change or go while it is read.
    function withFile(fd, act) {
        if (!open.has(fd)) {
            return BAD_FILE;
        }
        try {
            return act(open.get(fd)) ?? OK;
        } catch (error) {
            log?.(error.message);
            return BROKEN;
        }
    }

    const calls = {
        clock_time_get: (clock, _precision, out) => now(clock, out),
        fd_close: (fd) => (open.delete(fd) ? OK : BAD_FILE),
        fd_fdstat_get: describe,
        fd_fdstat_set_flags: () => OK,
        fd_filestat_get: (fd, out) => withFile(fd, (one) => writeStat(out, one.inode, IS_FILE, one.file.size)),
        fd_pread: (fd, vectors, count, offset, out) =>
            withFile(fd, (one) => void readAt(one, Number(offset), vectors, count, out)),
        fd_prestat_get: (fd, out) => {
            if (fd !== FOLDER) {
                return BAD_FILE;
            }
            view().setUint32(out, 0, true);
            view().setUint32(out + 4, 1, true);
            return OK;
        },
        fd_prestat_dir_name: (_fd, at) => (bytes(at, 1).set([0x2f]), OK),
        fd_read: (fd, vectors, count, out) =>
            withFile(fd, (one) => void (one.at += readAt(one, one.at, vectors, count, out))),
        fd_seek: (fd, offset, whence, out) => withFile(fd, (one) => seek(one, offset, whence, out)),
        fd_write: (_fd, vectors, count, out) => write(vectors, count, out),
        path_filestat_get: (_fd, _flags, at, length, out) => stat(nameAt(at, length), out),
        path_open: (_fd, _look, at, length, _flags, _base, _inheriting, _fdFlags, out) =>
            openFile(nameAt(at, length), out),
        proc_exit: (code) => {
            throw new Ended(`the decoder ended with ${code}`);
        },
    };

    return {
        // For a module: what it does not use is not there, and what it uses beside that is refused.
        imports(module) {
            const named = WebAssembly.Module.imports(module).map(({ name }) => [name, calls[name] ?? (() => NOT_SUPPORTED)]);
            return { wasi_snapshot_preview1: Object.fromEntries(named) };
        },
        start(instance) {
            memory = instance.exports.memory;
            instance.exports._initialize();
        },
    };
}
