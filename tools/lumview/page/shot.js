// The picture as a PNG file: points, legend, and what it shows.
import { drawBar, legendOf } from "./legend.js";
import { save } from "./save.js";
import { cssColour } from "./theme.js";

const TOO_LARGE = "this browser makes no picture of that size: make its window smaller";
const FONT = "system-ui, 'DejaVu Sans', sans-serif";

function drawLegend(pen, values, domain, bytes, right, bottom) {
    const legend = legendOf(values, domain);
    pen.font = `13px ${FONT}`;
    const width = Math.max(59, ...legend.ticks.map(({ text }) => pen.measureText(text).width)); // of texts
    const [x, y, height] = [right - 36 - width, bottom - 210, 180];
    pen.fillStyle = cssColour("--card");
    pen.fillRect(x - 12, y - 30, 43 + width, height + 44);
    pen.fillStyle = cssColour("--text");
    pen.font = `600 13px ${FONT}`;
    pen.fillText(legend.title, x, y - 14);
    drawBar(pen, x, y, 16, height, values, legend, bytes);
    pen.fillStyle = cssColour("--text");
    pen.font = `13px ${FONT}`;
    legend.ticks.forEach(({ at, text }) => pen.fillText(text, x + 24, y + (1 - at) * height));
}

// render: draws the scene now, so that its pixels can be read. tell(sentence): what hinders it.
export function takeShot({ canvas, render, values, domain, bytes, caption, name, tell }) {
    const picture = document.createElement("canvas");
    picture.width = canvas.width;
    picture.height = canvas.height;
    const pen = picture.getContext("2d");
    render();
    pen.drawImage(canvas, 0, 0);
    const ratio = canvas.width / canvas.clientWidth;
    pen.scale(ratio, ratio);
    pen.textBaseline = "middle";
    drawLegend(pen, values, domain, bytes, canvas.clientWidth, canvas.clientHeight);
    pen.font = `13px ${FONT}`;
    pen.fillText(caption, 12, canvas.clientHeight - 16);
    picture.toBlob((blob) => (blob ? save([blob], "image/png", name) : tell(TOO_LARGE)), "image/png");
}
