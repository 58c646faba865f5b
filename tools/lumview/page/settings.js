// What the user has chosen. One flat set of values; whoever depends on one
// hears of its change. The address keeps them: address.js.

export const DEFAULTS = Object.freeze({
    return: "all", // all, 1, 2, 3, last, strongest
    edges: "rising", // rising, falling, both: made by the server
    smooth: 0, // window of the angle smoothing: made by the server
    blue: true,
    green: true,
    colour: "range",
    map: "viridis",
    from: null, // ends of the colours; null: from the points
    to: null,
    size: 2, // pixels of the page, of a point that is neither near nor far
    edl: "auto", // eye-dome lighting: on, off; auto: not while a slow machine moves the picture
    accumulate: 1, // frames
    rangeMin: null,
    rangeMax: null,
    heightMin: null,
    heightMax: null,
    flat: false, // parallel projection
    theme: "system", // dark, light
    grid: true,
    rings: true,
    ground: null, // height of the grid, metres; null: from the points
    world: true, // frames stand where they were taken, where there are poses
    truth: true, // points that are true, where there are any
    panel: null, // parts that are shown; null: where there is room
    stats: null,
    legend: null,
    strip: null,
});

export const SMOOTHINGS = [5, 7, 9, 11, 15, 21, 31, 41, 63]; // windows, pixels; 0: none

const isNumber = (value) => value === null || Number.isFinite(value);
const isSame = (other) => (value) => typeof value === typeof other;
const isSwitch = (value) => value === null || typeof value === "boolean";
const isBetween = (least, most) => (value) => Number.isFinite(value) && value >= least && value <= most;
const isWhole = (least, most) => (value) => Number.isInteger(value) && isBetween(least, most)(value);
const isOf = (...choices) => (value) => choices.includes(value);

// What a value of the address must be.
const FITS = {
    ...Object.fromEntries(Object.keys(DEFAULTS).map((key) => [key, DEFAULTS[key] === null ? isNumber : isSame(DEFAULTS[key])])),
    return: isOf("all", "1", "2", "3", "last", "strongest"),
    edges: isOf("rising", "falling", "both"),
    smooth: isOf(0, ...SMOOTHINGS),
    colour: isOf("range", "height", "pulse", "return", "line", "eye", "sensor", "label"),
    map: isOf("viridis", "cividis"),
    size: isBetween(1, 10),
    edl: isOf("auto", "on", "off"),
    theme: isOf("system", "dark", "light"),
    accumulate: isWhole(1, 50),
    panel: isSwitch,
    stats: isSwitch,
    legend: isSwitch,
    strip: isSwitch,
};

// Two ends, of which the first is not above the second.
const PAIRS = [["from", "to"], ["rangeMin", "rangeMax"], ["heightMin", "heightMax"]];

export const isFit = (key, value) => Object.hasOwn(FITS, key) && FITS[key](value);

export function withoutBadPairs(values) {
    const bad = new Set(PAIRS.filter(([low, high]) => values[low] > values[high]).flat());
    return Object.fromEntries(Object.entries(values).filter(([key]) => !bad.has(key)));
}

// given: those of the address; undefined: it has none.
export function makeSettings(given) {
    const values = { ...DEFAULTS, ...given };
    const listeners = [];
    const resets = [];

    const tell = (keys) => listeners.forEach((hear) => hear(new Set(keys)));

    function set(changes) {
        const changed = Object.keys(changes).filter((key) => values[key] !== changes[key]);
        Object.assign(values, changes);
        if (changed.length > 0) {
            tell(changed);
        }
    }

    return {
        values,
        set,
        // All others get their defaults.
        replace: (given) => set({ ...DEFAULTS, ...given }),
        // What was typed and refused goes too, so all hear of it.
        reset() {
            Object.assign(values, DEFAULTS);
            tell(Object.keys(DEFAULTS));
            resets.forEach((hear) => hear());
        },
        onReset: (hear) => resets.push(hear),
        onChange: (hear) => listeners.push(hear),
    };
}
