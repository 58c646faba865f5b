// Where frames come from: lumview by a WebSocket, captures that a worker decodes, or frames that are in the page.
//
// A source is { send(text), connected }. It calls on.text(object) with the greeting and the status of status.c,
// on.binary(ArrayBuffer) with the frames of packed.h, and takes the commands of command.c. Some have open(files) too.
import { makeFiles } from "./files.js";
import { makeLink } from "./link.js";
import { attachLicenses } from "./open.js";
import { makeReel } from "./reel.js";

export function bytesOf(base64) {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) {
        bytes[i] = text.charCodeAt(i);
    }
    return bytes.buffer;
}

// What a program has written into lumview.html: captures or frames; null: nothing.
function embeddedData() {
    const element = document.getElementById("lumview-data");
    return element ? JSON.parse(element.textContent) : null;
}

function openEmbedded(source, { captures, options }) {
    const files = captures.map(({ name, base64 }) => ({ name, bytes: bytesOf(base64) }));
    source.open({ captures: files, ...options });
}

function makeSourceOf(data, on, unpack) {
    if (data?.frames) {
        return makeReel(on, data.hello, data.frames.map(bytesOf));
    }
    if (!unpack) {
        return makeLink(on);
    }
    const source = makeFiles(on, unpack);
    if (data?.captures) {
        openEmbedded(source, data);
    }
    return source;
}

// on: that of makeLink(), and failed(sentence), inferred({ yaml, sentence }), opening(files)
export function makeSource(on) {
    const unpack = globalThis.lumviewPacked;
    if (unpack) {
        attachLicenses(unpack);
    }
    try {
        return makeSourceOf(embeddedData(), on, unpack);
    } catch (error) {
        setTimeout(() => on.failed(`the data in this page is damaged: ${error.message}; make or copy the page again`), 0);
        return makeSourceOf(null, on, unpack);
    }
}
