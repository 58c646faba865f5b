// Marks at the slider of a capture: where ranges were lost, and where the sensor, or one eye of it, paused.
// status.marks has them as [frame, range words lost, pauses], of so many frames together as the whole has room for; a status
// without them says nothing new.

const NONE = [];

function textOf([, lost, pauses]) {
    const losses = lost > 0 ? `${lost.toLocaleString("en")} ranges lost` : "";
    return [losses, pauses > 0 ? `${pauses} ${pauses === 1 ? "pause" : "pauses"}` : ""].filter(Boolean).join(", ");
}

export function makeMarks(place) {
    let marks = NONE;
    let shown = "";

    function markItem([frame, lost], first, last) {
        const item = document.createElement("i");
        item.className = lost > 0 ? "lost" : "pause";
        item.style.setProperty("--share", String((frame - first) / Math.max(1, last - first)));
        return item;
    }

    return {
        show(status) {
            marks = status.marks ?? marks;
            const { first_frame: first, last_frame: last } = status;
            const key = JSON.stringify([marks, first, last]);
            if (key === shown) {
                return;
            }
            shown = key;
            const isKnown = first !== null && last !== null;
            place.replaceChildren(...(isKnown ? marks.map((mark) => markItem(mark, first, last)) : []));
        },
        clear() {
            marks = NONE;
        },
        // What the mark says that covers a frame; "": there is none.
        at(frame) {
            const mark = marks.findLast(([from]) => from <= frame);
            const width = marks.length > 1 ? Math.min(...marks.slice(1).map(([from], i) => from - marks[i][0])) : 1;
            return mark && frame - mark[0] < width ? textOf(mark) : "";
        },
        // The next mark after a frame, the last before it; null: there is none.
        after: (frame) => marks.find(([at]) => at > frame)?.[0] ?? null,
        before: (frame) => marks.findLast(([at]) => at < frame)?.[0] ?? null,
    };
}
