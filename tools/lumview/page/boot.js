// lumview.html alone: what the file has within, compressed by LZMA, and the start of the page's script, which is one of it.
// Browsers unpack gzip, of which the file would be half as large again: it has two modules that are nearly the same.

const SIGN = 0x80000000;

// What a .lzma file holds, of which the size is known (LZMA specification, I. Pavlov, public domain).
function unpackLzma(input, size) {
    const out = new Uint8Array(size);
    const [literalBits, placeBits, positionBits] = [input[0] % 9, Math.floor(input[0] / 9) % 5, Math.floor(input[0] / 45)];
    // Of 32 bits, but compared as if they were not signed; browsers are fastest at that.
    const state = new Int32Array([-1, new DataView(input.buffer, input.byteOffset).getInt32(14)]); // range, code
    const isBelow = (a, b) => (a ^ SIGN) < (b ^ SIGN);
    let at = 18;
    let done = 0;
    const chances = (count) => new Uint16Array(count).fill(1024);

    function refill() {
        if ((state[0] & 0xff000000) === 0) {
            state[0] <<= 8;
            state[1] = (state[1] << 8) | input[at++];
        }
    }

    function bit(table, i) {
        const chance = table[i];
        const bound = Math.imul(state[0] >>> 11, chance);
        const isZero = isBelow(state[1], bound);
        if (isZero) {
            state[0] = bound;
            table[i] = chance + ((2048 - chance) >> 5);
        } else {
            state[0] -= bound;
            state[1] -= bound;
            table[i] = chance - (chance >> 5);
        }
        refill();
        return isZero ? 0 : 1;
    }

    function plainBits(count) {
        let value = 0;
        for (let i = 0; i < count; i++) {
            state[0] >>>= 1;
            const isZero = isBelow(state[1], state[0]);
            if (!isZero) {
                state[1] -= state[0];
            }
            refill();
            value = (value << 1) | (isZero ? 0 : 1);
        }
        return value;
    }

    function tree(table, from, bits) {
        let node = 1;
        for (let i = 0; i < bits; i++) {
            node = (node << 1) | bit(table, from + node);
        }
        return node - (1 << bits);
    }

    function treeFromBelow(table, from, bits) {
        let [node, value] = [1, 0];
        for (let i = 0; i < bits; i++) {
            const one = bit(table, from + node);
            node = (node << 1) | one;
            value |= one << i;
        }
        return value;
    }

    function makeLengths() {
        const [choice, low, middle, high] = [chances(2), chances(128), chances(128), chances(256)];
        return (place) => {
            if (bit(choice, 0) === 0) {
                return tree(low, place << 3, 3);
            }
            return bit(choice, 1) === 0 ? 8 + tree(middle, place << 3, 3) : 16 + tree(high, 0, 8);
        };
    }

    const literals = chances(0x300 << (literalBits + placeBits));
    const [isMatch, isLong] = [chances(192), chances(192)];
    const [isAgain, isOther, isOlder, isOldest] = [chances(12), chances(12), chances(12), chances(12)];
    const [slots, distances, ends] = [chances(256), chances(128), chances(16)];
    const [lengthOf, lengthAgain] = [makeLengths(), makeLengths()];
    const last = [0, 0, 0, 0]; // distances, less 1
    let kind = 0; // of what came before

    function literal() {
        const before = done > 0 ? out[done - 1] : 0;
        const from = 0x300 * (((done & ((1 << placeBits) - 1)) << literalBits) + (before >> (8 - literalBits)));
        let symbol = 1;
        if (kind >= 7) {
            let match = out[done - last[0] - 1];
            for (let same = true; symbol < 0x100 && same;) {
                const wanted = (match >> 7) & 1;
                match <<= 1;
                const one = bit(literals, from + ((1 + wanted) << 8) + symbol);
                symbol = (symbol << 1) | one;
                same = wanted === one;
            }
        }
        while (symbol < 0x100) {
            symbol = (symbol << 1) | bit(literals, from + symbol);
        }
        out[done++] = symbol & 0xff;
        kind = kind < 4 ? 0 : kind < 10 ? kind - 3 : kind - 6;
    }

    function distance(length) {
        const slot = tree(slots, Math.min(length, 3) << 6, 6);
        if (slot < 4) {
            return slot;
        }
        const bits = (slot >> 1) - 1;
        const base = (2 | (slot & 1)) << bits;
        return slot < 14
            ? base + treeFromBelow(distances, base - slot, bits)
            : base + (plainBits(bits - 4) << 4) + treeFromBelow(ends, 0, 4);
    }

    // Moves one of the last distances to the front, after which it is the one that counts.
    const toFront = (i) => last.unshift(...last.splice(i, 1));

    // The length of what repeats; 1 for a single byte.
    function repetition(place) {
        if (bit(isAgain, kind) === 0) {
            const length = lengthOf(place);
            kind = kind < 7 ? 7 : 10;
            last.pop();
            last.unshift(distance(length));
            return length + 2;
        }
        if (bit(isOther, kind) === 0) {
            if (bit(isLong, (kind << 4) + place) === 0) {
                kind = kind < 7 ? 9 : 11;
                return 1;
            }
        } else {
            toFront(bit(isOlder, kind) === 0 ? 1 : 2 + bit(isOldest, kind));
        }
        kind = kind < 7 ? 8 : 11;
        return lengthAgain(place) + 2;
    }

    while (done < size) {
        if (at > input.length) {
            throw new Error("its end is not there");
        }
        const place = done & ((1 << positionBits) - 1);
        if (bit(isMatch, (kind << 4) + place) === 0) {
            literal();
            continue;
        }
        for (let length = Math.min(repetition(place), size - done); length > 0; length--, done++) {
            out[done] = out[done - last[0] - 1];
        }
    }
    return out;
}

function unpack() {
    const { order, sizes } = JSON.parse(document.getElementById("packed-parts").textContent);
    const packed = Uint8Array.from(atob(document.getElementById("packed").textContent), (character) => character.charCodeAt(0));
    const all = unpackLzma(packed, sizes.reduce((sum, size) => sum + size, 0));
    let at = 0;
    return Object.fromEntries(order.map((name, i) => [name, all.slice(at, (at += sizes[i])).buffer]));
}

try {
    const parts = unpack();
    // A part of this file as bytes: a script, a module of WebAssembly, the licences.
    globalThis.lumviewPacked = async (name) => parts[name];
    const script = document.createElement("script");
    script.type = "module";
    script.textContent = new TextDecoder().decode(parts["app.js"]);
    document.head.append(script);
} catch (error) {
    const banner = document.getElementById("banner");
    banner.textContent = `lumview.html cannot be unpacked, as if a part of the file were missing: ${error.message}`;
    banner.hidden = false;
}
