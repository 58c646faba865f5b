// Which parts of the page are shown: what the user wants, and else what there
// is room for. The picture comes first.

const SMALL = window.matchMedia("(max-width: 1099px), (max-height: 639px)");
const MARGIN = 24; // pixels, on both sides of a card
const at = (id) => document.getElementById(id);

// Part, what its button is; each is a setting too.
const PARTS = { panel: "panel", stats: "stats", legend: "legend-body", strip: "strip" };

export function makeLayout(settings, changed) {
    const { values } = settings;
    const isShown = (part) => values[part] ?? !SMALL.matches;
    const toggle = (part) => settings.set({ [part]: !isShown(part) });

    function apply() {
        for (const [part, id] of Object.entries(PARTS)) {
            at(id).hidden = !isShown(part);
            at(`${part}-toggle`).setAttribute("aria-expanded", String(isShown(part)));
            at(`${part}-toggle`).setAttribute("aria-pressed", String(isShown(part)));
        }
        at("legend-line").hidden = isShown("legend");
        changed();
    }

    for (const part of Object.keys(PARTS)) {
        at(`${part}-toggle`).addEventListener("click", () => toggle(part));
    }
    SMALL.addEventListener("change", apply);
    settings.onChange((keys) => {
        if (Object.keys(PARTS).some((part) => keys.has(part))) {
            apply();
        }
    });
    return {
        apply,
        toggle,
        // Pixels at the left and the right that cards take from the picture.
        covered(width) {
            const left = isShown("stats") ? at("stats").offsetWidth + MARGIN : 0;
            const right = isShown("legend") ? at("legend").offsetWidth + MARGIN : 0;
            return left + right < 0.5 * width ? { left, right } : { left: 0, right: 0 };
        },
    };
}
