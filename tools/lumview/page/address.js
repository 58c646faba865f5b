// The state of the page in its address, behind the #: the settings that differ from their defaults, the camera, and the frame
// where a capture stands still. So a view can be shared, and is there after a reload. What an address has wrong is left out.
import { DEFAULTS, isFit, withoutBadPairs } from "./settings.js";

const WRITE_MS = 400; // browsers refuse an address that changes more often
const MOST_FRAME = 2 ** 53;
const SWITCH = { on: true, off: false };

const asNumber = (text) => (text.trim() === "" ? NaN : Number(text));
const textOf = (value) => (typeof value === "boolean" ? (value ? "on" : "off") : String(value));

// The value that a setting can have; undefined: none.
function valueOf(key, text) {
    const number = asNumber(text);
    return [text, SWITCH[text], ...(Number.isFinite(number) ? [number] : [])].find((value) => value !== undefined && isFit(key, value));
}

function frameOf(text) {
    const number = asNumber(text ?? "");
    return Number.isInteger(number) && Math.abs(number) <= MOST_FRAME ? number : null;
}

// { values, camera, frame }: the text of the camera and the frame's number are null where there are none; null: the address
// says nothing.
export function parseAddress(hash) {
    const fields = new URLSearchParams(hash.replace(/^#/, ""));
    const given = Object.keys(DEFAULTS).filter((key) => fields.has(key));
    const values = Object.fromEntries(given.map((key) => [key, valueOf(key, fields.get(key))]).filter(([, value]) => value !== undefined));
    const camera = fields.get("camera");
    const frame = frameOf(fields.get("frame"));
    const isEmpty = given.length === 0 && camera === null && frame === null;
    return isEmpty ? null : { values: withoutBadPairs(values), camera, frame };
}

export function formatAddress({ values, camera, frame }) {
    const fields = new URLSearchParams();
    for (const key of Object.keys(DEFAULTS).filter((name) => values[name] !== DEFAULTS[name] && values[name] !== null)) {
        fields.set(key, textOf(values[key]));
    }
    if (camera !== null) {
        fields.set("camera", camera);
    }
    if (frame !== null) {
        fields.set("frame", String(frame));
    }
    const text = fields.toString().replaceAll("%2C", ",");
    return text === "" ? "" : `#${text}`;
}

// describe(): the state to write; take(state): an address was typed or pasted.
export function makeAddress(describe, take) {
    let timer = 0;

    function write() {
        timer = 0;
        const hash = formatAddress(describe());
        if (hash !== location.hash && location.protocol !== "about:") { // a page in a cell of a notebook has no address
            history.replaceState(history.state, "", location.pathname + location.search + hash);
        }
    }

    window.addEventListener("hashchange", () => {
        const state = parseAddress(location.hash);
        if (state) {
            take(state);
        }
    });
    return {
        changed() {
            timer ||= setTimeout(write, WRITE_MS);
        },
    };
}
