// What the user has chosen. One flat set of values; whoever depends on one
// hears of its change.

export const DEFAULTS = Object.freeze({
    return: "all", // all, 1, 2, 3, last, strongest
    edges: "rising", // rising, falling, both: made by the server
    smooth: 0, // window of the angle smoothing: made by the server
    blue: true,
    green: true,
    colour: "range",
    map: "turbo",
    from: null, // ends of the colours; null: from the points
    to: null,
    size: 2, // pixels of the page
    accumulate: 1, // frames
    rangeMin: null,
    rangeMax: null,
    heightMin: null,
    heightMax: null,
    flat: false, // parallel projection
    grid: true,
    rings: true,
    ground: null, // height of the grid, metres; null: from the points
});

export function makeSettings() {
    const values = { ...DEFAULTS };
    const listeners = [];

    function set(changes) {
        const changed = Object.keys(changes).filter((key) => values[key] !== changes[key]);
        Object.assign(values, changes);
        if (changed.length > 0) {
            listeners.forEach((tell) => tell(new Set(changed)));
        }
    }

    return {
        values,
        set,
        reset: () => set({ ...DEFAULTS }),
        onChange: (tell) => listeners.push(tell),
    };
}
