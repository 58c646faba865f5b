// lumview.html alone: what the file has within, compressed by gzip, and the start of the page's script, which is one of it.

// A part of this file as bytes: a script, the module of WebAssembly, the licences.
async function unpack(name) {
    const packed = Uint8Array.from(atob(document.getElementById(name).textContent), (character) => character.charCodeAt(0));
    return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

try {
    globalThis.lumviewPacked = unpack;
    const script = document.createElement("script");
    script.type = "module";
    script.textContent = new TextDecoder().decode(await unpack("app.js"));
    document.head.append(script);
} catch (error) {
    const banner = document.getElementById("banner");
    banner.textContent = `lumview.html cannot be unpacked, as if a part of the file were missing: ${error.message}`;
    banner.hidden = false;
}
