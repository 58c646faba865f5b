// Pause, step, scrub, loop and speed of a capture. Of a live sensor the
// picture alone can be held.
import { makeMarks } from "./marks.js";

export function makePlayer(send, held) {
    const at = (id) => document.getElementById(id);
    const [play, scrub, out, loop, speed] = ["play", "scrub", "scrub-out", "loop", "speed"].map(at);
    const marks = makeMarks(at("marks"));
    let status = null;
    let isHeld = false;
    let scrubbing = 0; // until then the slider is the user's

    const plays = () => status !== null && (status.state === "playing" || status.state === "waiting");

    function showLabel() {
        const text = status?.live ? (isHeld ? "Go on" : "Hold") : plays() ? "Pause" : "Play";
        play.textContent = text;
        play.title = status?.live ? "Hold the picture, or go on (space)" : `${text} (space)`;
    }

    function showSpeed(value) {
        const text = String(value);
        if (![...speed.options].some((option) => option.value === text)) {
            speed.add(new Option(`${text}×`, text));
        }
        speed.value = text;
    }

    function showRange({ first_frame: first, last_frame: last, frame, scanned }) {
        scrub.disabled = first === null || last === null;
        const read = scanned > 0 ? `, ${Math.floor(100 * scanned)} % read` : "";
        out.textContent = last === null ? `frame ${frame}${read}` : `${frame} / ${last}`;
        if (scrub.disabled || performance.now() < scrubbing) {
            return;
        }
        scrub.min = first;
        scrub.max = last;
        scrub.value = frame;
        const mark = marks.at(frame);
        scrub.setAttribute("aria-valuetext", `frame ${frame} of ${last}${mark && `, ${mark}`}`);
        scrub.title = mark;
    }

    function showLive(isLive) {
        for (const id of ["first", "back", "forth", "scrub-out"]) {
            at(id).hidden = isLive;
        }
        [scrub, loop, speed].forEach((control) => {
            control.closest("label").hidden = isLive;
        });
    }

    // Of a mark, where there is one.
    function toMark(frame) {
        if (frame !== null && !status.live) {
            send(`seek ${frame}`);
        }
    }

    const self = {
        // Another source.
        clear: marks.clear,
        get held() {
            return isHeld;
        },
        show(next) {
            if (status?.live !== next.live) {
                showLive(next.live);
            }
            status = next;
            showLabel();
            if (!next.live) {
                marks.show(next);
                showRange(next);
                showSpeed(next.speed);
                loop.checked = next.loop;
            }
        },
        toggle() {
            if (!status?.live) {
                send(plays() ? "pause" : "play");
                return;
            }
            isHeld = !isHeld;
            showLabel();
            held(isHeld);
        },
        step: (frames) => status?.live || send(`step ${frames}`),
        toFirst: () => scrub.disabled || status?.live || send(`seek ${status.first_frame}`),
        toLast: () => scrub.disabled || status?.live || send(`seek ${status.last_frame}`),
        toNextMark: () => status && toMark(marks.after(status.frame)),
        toPreviousMark: () => status && toMark(marks.before(status.frame)),
        toggleLoop: () => status?.live || send(`loop ${status?.loop ? "off" : "on"}`),
        changeSpeed(by) {
            const values = [...speed.options].map((option) => Number(option.value)).sort((a, b) => a - b);
            const next = values[values.indexOf(Number(speed.value)) + by];
            if (next && !status?.live) {
                send(`speed ${next}`);
            }
        },
    };

    play.addEventListener("click", self.toggle);
    at("first").addEventListener("click", self.toFirst);
    at("back").addEventListener("click", () => self.step(-1));
    at("forth").addEventListener("click", () => self.step(1));
    loop.addEventListener("change", () => send(`loop ${loop.checked ? "on" : "off"}`));
    speed.addEventListener("change", () => send(`speed ${speed.value}`));
    scrub.addEventListener("input", () => {
        scrubbing = performance.now() + 700;
        out.textContent = `${scrub.value} / ${scrub.max}`;
        send(`seek ${scrub.value}`);
    });
    return self;
}
