// Marks at the slider of a capture: where ranges were lost, and where the sensor, or one eye of it, paused.
// status.marks has them as [frame, range words lost, pauses, lines lost], each of status.mark_frames together; a status without
// them says nothing new.

const NONE = [];

function textOf([, lost, pauses, lines = 0]) {
    const losses = [[lost, "ranges lost"], [lines, "lines lost"], [pauses, pauses === 1 ? "pause" : "pauses"]];
    return losses.filter(([count]) => count > 0).map(([count, what]) => `${count.toLocaleString("en")} ${what}`).join(", ");
}

// The lines that a pause lacks are no loss on their way.
const isLoss = ([, lost, pauses, lines = 0]) => lost > 0 || (lines > 0 && pauses === 0);

export function makeMarks(place) {
    let marks = NONE;
    let width = 1; // frames of a mark
    let shown = "";

    function markItem(mark, first, last) {
        const item = document.createElement("i");
        item.className = isLoss(mark) ? "lost" : "pause";
        item.style.setProperty("--share", String((mark[0] - first) / Math.max(1, last - first)));
        return item;
    }

    return {
        show(status) {
            marks = status.marks ?? marks;
            width = status.mark_frames ?? width;
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
            return mark && frame - mark[0] < width ? textOf(mark) : "";
        },
        // The next mark after a frame, the last before it; null: there is none.
        after: (frame) => marks.find(([at]) => at > frame)?.[0] ?? null,
        before: (frame) => marks.findLast(([at]) => at < frame)?.[0] ?? null,
    };
}
