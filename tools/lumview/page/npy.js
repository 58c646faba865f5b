// Arrays in files of NumPy (.npy): numbers in rows and columns, or rows with named columns.

const MAGIC = "\x93NUMPY";
const READ = {
    f4: "getFloat32", f8: "getFloat64", i1: "getInt8", i2: "getInt16", i4: "getInt32", i8: "getBigInt64",
    u1: "getUint8", u2: "getUint16", u4: "getUint32", u8: "getBigUint64", b1: "getUint8",
};

// What the head says in Python's words: { descr, isByColumns, shape, begin }
function parseHead(buffer) {
    const view = new DataView(buffer);
    const text = (from, length) => String.fromCharCode(...new Uint8Array(buffer, from, length));
    if (buffer.byteLength < 12 || text(0, 6) !== MAGIC) {
        throw new Error("it is no array of NumPy, as numpy.save() writes it");
    }
    const isLong = view.getUint8(6) > 1;
    const length = isLong ? view.getUint32(8, true) : view.getUint16(8, true);
    const begin = (isLong ? 12 : 10) + length;
    const head = begin <= buffer.byteLength ? text(begin - length, length) : "";
    const shape = /'shape':\s*\(([^)]*)\)/.exec(head);
    const descr = /'descr':\s*(?:'([^']*)'|\[(.*?)\])\s*,/s.exec(head);
    if (!shape || !descr) {
        throw new Error("the head of the array cannot be read");
    }
    const numbers = shape[1].split(",").map((part) => part.trim()).filter(Boolean).map(Number);
    return { descr, isByColumns: /'fortran_order':\s*True/.test(head), shape: numbers, begin };
}

// (name, type) or ((title, name), type)
const NAMED = /\(\s*(?:\(\s*'[^']*'\s*,\s*'([^']*)'\s*\)|'([^']*)')\s*,\s*'([^']*)'\s*\)/g;
const LONGEST = 100; // characters of what a sentence quotes

// The names and types of a list in Python's words.
function namesOf(list) {
    const rest = list.replace(NAMED, "").replace(/^[\s,]+|[\s,]+$/g, "");
    if (rest !== "") {
        const quoted = rest.length > LONGEST ? `${rest.slice(0, LONGEST)}...` : rest;
        throw new Error(`a column of it is more than one number: ${quoted}; save the columns that are numbers alone`);
    }
    return [...list.matchAll(NAMED)].map(([, titled, name, type]) => [titled ?? name, type]);
}

// The columns of a row, { name, type, at }, and its bytes. Void ones, as NumPy pads rows with, are passed over.
function columnsOf({ descr, shape }) {
    const isNamed = descr[2] !== undefined;
    const named = !isNamed
        ? Array.from({ length: shape.length > 1 ? shape[1] : 1 }, (_, i) => [String(i), descr[1]])
        : namesOf(descr[2]);
    let at = 0;
    const columns = named.flatMap(([name, text]) => {
        const padding = isNamed ? /^\|V(\d+)$/.exec(text) : null;
        if (padding) {
            at += Number(padding[1]);
            return [];
        }
        const type = text.replace(/^[<|=>]/, "");
        if (!READ[type] || (text.startsWith(">") && !type.endsWith("1"))) {
            throw new Error(`its numbers are of the type ${text}, which the page does not read: save them as '<f8'`);
        }
        const column = { name, type, at };
        at += Number(type[1]);
        return [column];
    });
    return { columns, bytes: at };
}

// As Python writes it.
const textOf = (shape) => `(${shape.join(", ")}${shape.length === 1 ? "," : ""})`;

// { rows, names, shape, column(name) }: a column as Float64Array; columns without names are "0", "1" and so on; shape: a text,
// "" where columns have names.
export function parseNpy(buffer) {
    const head = parseHead(buffer);
    const { columns, bytes } = columnsOf(head);
    const [rows = 0] = head.shape;
    if (head.shape.length > 2 || (head.descr[2] !== undefined && head.shape.length !== 1)) {
        throw new Error(`its shape is ${textOf(head.shape)}, not rows of columns`);
    }
    if (columns.length === 0 || head.begin + rows * bytes > buffer.byteLength) {
        throw new Error(`it ends before its ${rows.toLocaleString("en")} rows do`);
    }
    const view = new DataView(buffer, head.begin);

    return {
        rows,
        names: columns.map(({ name }) => name),
        shape: head.descr[2] === undefined ? textOf(head.shape) : "",
        column(name) {
            const index = columns.findIndex((column) => column.name === name);
            const { type, at } = columns[index];
            const [read, width] = [READ[type], Number(type[1])];
            const place = head.isByColumns ? (i) => (index * rows + i) * width : (i) => i * bytes + at;
            return Float64Array.from({ length: rows }, (_, i) => Number(view[read](place(i), true)));
        },
    };
}
