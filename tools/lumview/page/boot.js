// lumview.html alone: what the file has within, compressed, and the start of the page's script, which is one of it.
const textOf = (name) => document.getElementById(`packed-${name}`).textContent;

// A part of this file as bytes: a script, a module of WebAssembly, the licences.
async function unpack(name) {
    const packed = Uint8Array.from(atob(textOf(name)), (character) => character.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
}

globalThis.lumviewPacked = unpack;
try {
    const script = document.createElement("script");
    script.type = "module";
    script.textContent = new TextDecoder().decode(await unpack("app.js"));
    document.head.append(script);
} catch (error) {
    const banner = document.getElementById("banner");
    banner.textContent = `lumview.html cannot be unpacked: ${error.message}. It needs a browser of 2023 or later: `
        + "Firefox 113, Chromium 80 or Safari 16.4, and the whole file";
    banner.hidden = false;
}
