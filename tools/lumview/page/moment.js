// When a frame began, for people.

const STEPS = 1e4; // of a second: what is shown is rounded to these
const KINDS = [null, "arrival", "fitted"];

// From the head of a frame: { utc, kind, error } in seconds; null where no time is known, and an error of NaN where that is not.
export const makeMoment = (utc, kind, error) => (KINDS[kind] ? { utc, kind: KINDS[kind], error } : null);

// Day and time of day, in UTC.
function partsOf(utc) {
    const steps = Math.round(utc * STEPS);
    const seconds = Math.floor(steps / STEPS);
    const [day, time] = new Date(seconds * 1000).toISOString().slice(0, 19).split("T");
    return [day, `${time}.${String(steps - seconds * STEPS).padStart(4, "0")}`];
}

// How exact it is.
function errorText(seconds) {
    if (Number.isNaN(seconds)) return "error not known";
    return seconds < 1e-3 ? `± ${Math.ceil(seconds * 1e6)} µs` : `± ${(seconds * 1e3).toFixed(1)} ms`;
}

const whyText = (seconds) => (Number.isNaN(seconds) ? ": the host's clock was stepped, or its stamps stand still" : "");

const HINTS = {
    fitted: ({ error }) => `UTC, by the sensor's clock fitted to when packets came; ${errorText(error)}${whyText(error)}`,
    arrival: () => "UTC, when its first packet came; nothing could be fitted to the sensor's clock",
};

// One line: day and time, and which it is. What a narrow page leaves out is fine: the fraction, and the kind.
export function showMoment(element, moment) {
    const [day, time] = moment ? partsOf(moment.utc) : [];
    const texts = moment ? [`${day} ${time.slice(0, 8)}`, time.slice(8), " UTC", `, ${moment.kind}`] : [];
    element.replaceChildren(...texts.map((text, i) => {
        const part = document.createElement("span");
        part.className = i % 2 === 1 ? "fine" : "";
        part.textContent = text;
        return part;
    }));
    element.title = hintOf(moment);
}

// By the clock and the place of who looks.
function localText(utc) {
    const zone = Intl.DateTimeFormat().resolvedOptions().timeZone ?? "here";
    return `${new Date(utc * 1000).toLocaleString("sv-SE")} local time (${zone})`;
}

// What that means, and the local time.
const hintOf = (moment) => (moment ? `began at ${localText(moment.utc)}; ${HINTS[moment.kind](moment)}` : "");

// The same in two rows.
export const timeOf = (moment) => (moment ? `${partsOf(moment.utc)[1]} UTC` : "unknown");

export function kindOf(moment) {
    return !moment ? "unknown" : moment.kind === "fitted" ? `fitted, ${errorText(moment.error)}` : moment.kind;
}
