// The controls: each shows and changes one setting.
import { COLOURINGS } from "./colouring.js";

const SMOOTHINGS = [5, 7, 9, 11, 15, 21, 31, 41, 63];

const asNumber = (text) => (text.trim() === "" || !Number.isFinite(Number(text)) ? null : Number(text));
const box = { read: (e) => e.checked, show: (e, v) => (e.checked = v) };
const choice = { read: (e) => e.value, show: (e, v) => (e.value = v) };
const choiceOfNumber = { read: (e) => Number(e.value), show: (e, v) => (e.value = String(v)) };
const slider = { read: (e) => Number(e.value), show: (e, v) => (e.value = v), event: "input" };
const number = {
    read: (e) => asNumber(e.value),
    show: (e, v) => {
        if (asNumber(e.value) !== v) {
            e.value = v ?? "";
        }
    },
    event: "input",
};

// Element, setting, how it is read and shown.
const CONTROLS = [
    ["return", "return", choice],
    ["edges", "edges", choice],
    ["smooth", "smooth", choiceOfNumber],
    ["blue", "blue", box],
    ["green", "green", box],
    ["colour", "colour", choice],
    ["map", "map", choice],
    ["from", "from", number],
    ["to", "to", number],
    ["size", "size", slider],
    ["accumulate", "accumulate", slider],
    ["range-min", "rangeMin", number],
    ["range-max", "rangeMax", number],
    ["height-min", "heightMin", number],
    ["height-max", "heightMax", number],
    ["flat", "flat", box],
    ["grid", "grid", box],
    ["rings", "rings", box],
    ["ground", "ground", number],
];

const at = (id) => document.getElementById(id);

// Buttons of the page that show and hide one of its parts.
export function makeToggle(button, part, changed) {
    const show = (isShown) => {
        part.hidden = !isShown;
        button.setAttribute("aria-expanded", String(isShown));
        button.setAttribute("aria-pressed", String(isShown));
        changed?.();
    };
    const toggle = () => show(part.hidden);
    button.addEventListener("click", toggle);
    show(!part.hidden);
    return { toggle, show };
}

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
        at("map").disabled = values.colour === "eye";
    }

    CONTROLS.forEach(([id, key, kind]) => {
        at(id).addEventListener(kind.event ?? "change", () => settings.set({ [key]: kind.read(at(id)) }));
    });
    // The ends belong to what is coloured.
    at("colour").addEventListener("change", () => settings.set({ from: null, to: null }));
    at("controls").addEventListener("submit", (event) => event.preventDefault());
    at("reset").addEventListener("click", settings.reset);
    settings.onChange(showAll);
    showAll();
    return {
        setSmoothings(most) {
            const windows = SMOOTHINGS.filter((w) => w <= most);
            const options = windows.map((w) => new Option(`over ${w} pixels`, String(w)));
            at("smooth").replaceChildren(new Option("off", "0"), ...options);
            showAll();
        },
        // The next choice of a list, as a key does it.
        next(id, key) {
            const list = at(id);
            const option = list.options[(list.selectedIndex + 1) % list.options.length];
            settings.set({ [key]: typeof values[key] === "number" ? Number(option.value) : option.value });
        },
    };
}
