// Frames that are in the page: a player of them that answers as lumview does.

// In the head of a message (lum/frame/packed.h).
const NUMBER_AT = 8;
const UTC_AT = 24;
const POINTS_AT = 32;
const SHOWN_AT = 52; // the count of frames shown so far
const BYTES_AT = 80;
const PIECE_AT = 84;
const USUAL_S = 0.1; // from one frame to the next where they do not tell
const LOSSES = ["wire_words", "wire_lines", "joined_words", "joined_lines", "pauses", "kernel", "ring", "refused"];
const LOST_AT = { wire_words: 1, pauses: 2, wire_lines: 3 }; // in a mark (marks.js)
const STATUS_MS = 500;

// Messages that may follow each other in one buffer, as the frames that they are the pieces of.
function framesOf(buffers) {
    const frames = [];
    for (const buffer of buffers) {
        for (let at = 0; at < buffer.byteLength;) {
            const head = new DataView(buffer, at);
            const end = at + head.getUint32(BYTES_AT, true);
            if (end <= at || end > buffer.byteLength) {
                throw new Error("a frame is cut short");
            }
            if (head.getUint32(PIECE_AT, true) === 0) {
                frames.push([]);
            }
            frames.at(-1).push(buffer.slice(at, end));
            at = end;
        }
    }
    return frames;
}

// on: that of makeSource(); buffers: messages in their order
export function makeReel(on, hello, buffers) {
    const frames = framesOf(buffers);
    const heads = frames.map(([first]) => new DataView(first));
    const numbers = heads.map((head) => head.getFloat64(NUMBER_AT, true));
    const marks = hello.marks ?? [];
    const lost = (name) => marks.reduce((sum, mark) => sum + (mark[LOST_AT[name]] ?? 0), 0);
    const losses = Object.fromEntries(LOSSES.map((name) => [name, lost(name)]));
    const state = { at: 0, plays: frames.length > 1, speed: 1, loop: true, shown: 0, timer: 0 };

    // What the frame after this one waits for.
    function gap() {
        const [here, next] = [heads[state.at], heads[state.at + 1]].map((head) => head?.getFloat64(UTC_AT, true) ?? 0);
        return (next > here && here > 0 ? Math.min(next - here, 1) : USUAL_S) / state.speed;
    }

    const isAtEnd = () => state.at + 1 >= frames.length;

    function tell() {
        const stateName = state.plays ? "playing" : isAtEnd() ? "ended" : "paused";
        on.text({
            type: "status",
            state: stateName,
            live: false,
            message: "",
            frame: numbers[state.at],
            first_frame: numbers[0],
            last_frame: numbers.at(-1),
            speed: state.speed,
            loop: state.loop,
            packets: 0,
            packets_joined: 0,
            bytes: 0,
            points: heads.reduce((sum, head) => sum + head.getUint32(POINTS_AT, true), 0),
            frames: frames.length,
            points_per_second: 0,
            frames_per_second: 0,
            bytes_per_second: 0,
            losses,
            mark_frames: 1,
            marks,
            laser: null,
            browsers: 1,
            skipped: 0,
        });
    }

    // Copies, as the page keeps what it is given.
    function give(i, shown) {
        for (const piece of frames[i]) {
            const copy = piece.slice(0);
            new DataView(copy).setUint32(SHOWN_AT, shown >>> 0, true);
            on.binary(copy);
        }
    }

    function plan() {
        clearTimeout(state.timer);
        if (state.plays) {
            state.timer = setTimeout(next, gap() * 1000);
        }
    }

    function show(i) {
        state.at = Math.max(0, Math.min(frames.length - 1, i));
        give(state.at, ++state.shown);
        plan();
        tell();
    }

    function next() {
        if (!isAtEnd() || state.loop) {
            show(isAtEnd() ? 0 : state.at + 1);
            return;
        }
        state.plays = false;
        tell();
    }

    function setPlaying(plays) {
        state.plays = plays;
        plan();
        tell();
    }

    // Of those before a frame the wanted ones: 1 is the one just before it, 2 the one before that, 4, and so on, added.
    function givePasts(number, wanted) {
        for (let i = 0; 2 ** i <= wanted; i++) {
            const at = numbers.indexOf(number - 1 - i);
            if (Math.floor(wanted / 2 ** i) % 2 === 1 && at >= 0) {
                give(at, state.shown - 1 - i);
            }
        }
    }

    const nearest = (number) => numbers.reduce((best, n, i) => (Math.abs(n - number) < Math.abs(numbers[best] - number) ? i : best), 0);

    const commands = {
        play: () => (isAtEnd() ? show((state.plays = true, 0)) : setPlaying(true)),
        pause: () => setPlaying(false),
        step(by) {
            state.plays = false;
            show(state.at + Number(by));
        },
        seek: (number) => show(nearest(Number(number))),
        speed(value) {
            state.speed = Number(value);
            plan();
            tell();
        },
        loop(value) {
            state.loop = value === "on";
            tell();
        },
        past: (number, wanted) => givePasts(Number(number), Number(wanted)),
        view: () => {}, // the frames are what they are
        frames: () => {},
    };

    setTimeout(() => {
        on.up();
        on.text(hello);
        if (frames.length > 0) {
            show(0);
        }
    }, 0);
    setInterval(() => frames.length > 0 && tell(), STATUS_MS);
    return {
        connected: true,
        send(text) {
            const [name, ...rest] = text.split(" ");
            commands[name]?.(...rest);
        },
    };
}
