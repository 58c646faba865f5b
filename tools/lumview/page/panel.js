// The controls: each shows and changes one setting.
import { COLOURINGS, SMALLEST } from "./colouring.js";
import { DEFAULTS, SMOOTHINGS } from "./settings.js";

const asNumber = (text) => (text.trim() === "" || !Number.isFinite(Number(text)) ? null : Number(text));
const isRefused = (e) => e.getAttribute("aria-invalid") === "true";
const box = { read: (e) => e.checked, show: (e, v) => (e.checked = v) };
const choice = { read: (e) => e.value, show: (e, v) => (e.value = v) };
const choiceOfNumber = { read: (e) => Number(e.value), show: (e, v) => (e.value = String(v)) };
const slider = { read: (e) => Number(e.value), show: (e, v) => (e.value = v), event: "input" };
const number = {
    read: (e) => asNumber(e.value),
    show: (e, v) => {
        if (asNumber(e.value) !== v && !isRefused(e)) {
            e.value = v ?? "";
        }
    },
};

// The elements by how they are read and shown; of each [element, setting, how].
const CONTROLS = [
    [choice, ["return", "edges", "colour", "map", "edl", "theme"]],
    [choiceOfNumber, ["smooth"]],
    [box, ["blue", "green", "flat", "grid", "rings", "truth", "world"]],
    [slider, ["size", "accumulate"]],
    [number, ["from", "to", "range-min", "range-max", "height-min", "height-max", "ground"]],
].flatMap(([kind, ids]) => ids.map((id) => [id, id.replace("-m", "M"), kind]));

const at = (id) => document.getElementById(id);

// Two fields that bound something: the message's element, the fields, and what
// is wrong with their values, if anything is.
const notAbove = ([low, high]) => low !== null && high !== null && low > high && `${low} is above ${high}`;
const PAIRS = [
    ["colour-why", ["from", "to"], ([low, high], values) => {
        const least = COLOURINGS[values.colour].logarithmic ? SMALLEST : -Infinity;
        if ([low, high].some((end) => end !== null && end < least)) {
            return `the scale is logarithmic: at least ${least}`;
        }
        return notAbove([low, high]) || (low !== null && low === high && "both ends are the same");
    }],
    ["range-why", ["range-min", "range-max"], (ends) => (ends.some((end) => end !== null && end < 0) && "no range is below 0") || notAbove(ends)],
    ["height-why", ["height-min", "height-max"], notAbove],
    ["ground-why", ["ground"], () => ""],
];

export function makePanel(settings) {
    const { values } = settings;

    function showAll() {
        CONTROLS.forEach(([id, key, kind]) => kind.show(at(id), values[key]));
        at("size-out").textContent = `${values.size} px`;
        at("accumulate-out").textContent = values.accumulate;
        at("colour-unit").textContent = COLOURINGS[values.colour].unit;
        const fixed = Boolean(COLOURINGS[values.colour].fixed);
        at("from").disabled = fixed;
        at("to").disabled = fixed;
        at("map").disabled = Boolean(COLOURINGS[values.colour].colours);
    }

    const keyOf = Object.fromEntries(CONTROLS.map(([id, key]) => [id, key]));

    function refuse([place, ids], why) {
        at(place).textContent = why || "";
        at(place).hidden = !why;
        ids.forEach((id) => at(id).setAttribute("aria-invalid", String(Boolean(why))));
    }

    // Both fields are taken, or neither: what was so before stays until then.
    function takePair(pair) {
        const [, ids, wrong] = pair;
        const ends = ids.map((id) => number.read(at(id)));
        const why = ids.some((id) => at(id).validity.badInput) ? "not a number" : wrong(ends, values);
        refuse(pair, why);
        if (!why) {
            settings.set(Object.fromEntries(ids.map((id, i) => [keyOf[id], ends[i]])));
        }
    }

    // A way to colour that only some sources have.
    function offerColour(value, text, isThere) {
        const option = at("colour").querySelector(`[value=${value}]`);
        if (isThere && !option) {
            at("colour").append(new Option(text, value));
        } else if (!isThere) {
            option?.remove();
            if (values.colour === value) {
                settings.set({ colour: DEFAULTS.colour });
            }
        }
        showAll();
    }

    for (const [id, key, kind] of CONTROLS.filter((control) => control[2] !== number)) {
        at(id).addEventListener(kind.event ?? "change", () => settings.set({ [key]: kind.read(at(id)) }));
    }
    for (const pair of PAIRS) {
        pair[1].forEach((id) => at(id).addEventListener("input", () => takePair(pair)));
    }
    // The ends belong to what is coloured.
    at("colour").addEventListener("change", () => settings.set({ from: null, to: null }));
    at("controls").addEventListener("submit", (event) => event.preventDefault());
    at("reset").addEventListener("click", settings.reset);
    settings.onChange((changed) => {
        for (const pair of PAIRS) {
            if (pair[1].some((id) => changed.has(keyOf[id])) || changed.has("colour")) {
                refuse(pair, "");
            }
        }
        showAll();
    });
    showAll();
    return {
        // Frames that are in the page are what they are: there is nothing to choose.
        setSmoothings(most) {
            [at("edges").disabled, at("smooth").disabled] = [most === 0, most === 0];
            const windows = SMOOTHINGS.filter((w) => w <= most);
            const options = windows.map((w) => new Option(`over ${w} pixels`, String(w)));
            at("smooth").replaceChildren(new Option("off", "0"), ...options);
            if (!SMOOTHINGS.includes(values.smooth) || values.smooth > most) {
                settings.set({ smooth: 0 });
            }
            showAll();
        },
        // Colours by sensor are a choice where there are several.
        setSensors: (names) => offerColour("sensor", "sensor", names !== null),
        // Colours by label where points have labels.
        setLabels: (isThere) => offerColour("label", "label", isThere),
        // The next choice of a list, as a key does it.
        next(id, key) {
            const list = at(id);
            if (list.disabled) {
                return;
            }
            const option = list.options[(list.selectedIndex + 1) % list.options.length];
            settings.set({ [key]: typeof values[key] === "number" ? Number(option.value) : option.value });
        },
    };
}
