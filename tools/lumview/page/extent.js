// Where the points of a frame are, for the views.
import { rangeOf } from "./filter.js";

const STEP = 50; // points; of few, all are looked at
const MANY = 5000;
const MOST = 0.9; // share of the points that a view takes in

const shareOf = (values, share) => values.toSorted((a, b) => a - b)[Math.floor(share * values.length)];
const limit = (v, least, most) => Math.max(least, Math.min(most, v));

// { reach, middle }: metres that a view should take in, and about which place; middle is null where points lie about the
// sensor, as they do where it is known from where they were seen.
export function extentOf(slot, eyes) {
    const places = [];
    const isAnywhere = eyes.length > 0 && eyes.every(({ lacks }) => lacks?.includes("place"));
    for (let i = 0; i < (slot?.size ?? 0); i += slot.size > MANY ? STEP : 1) {
        places.push(i);
    }
    if (places.length === 0) {
        return { reach: 40, middle: null };
    }
    if (!isAnywhere) {
        return { reach: limit(shareOf(places.map((i) => rangeOf(slot.points, i, eyes)), MOST), 20, 150), middle: null };
    }
    const { xyz } = slot.points;
    const middle = [0, 1, 2].map((k) => shareOf(places.map((i) => xyz[3 * i + k]), 0.5));
    const away = places.map((i) => Math.hypot(...middle.map((v, k) => xyz[3 * i + k] - v)));
    return { reach: limit(shareOf(away, MOST), 0.5, 1500), middle };
}
