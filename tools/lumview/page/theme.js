// Dark or light: as the user chose, or as the system is. style.css has the
// colours of the page, this the ones that are drawn on canvases.
const LIGHT = window.matchMedia("(prefers-color-scheme: light)");

export const THEMES = {
    dark: { ground: 0x0e1218, grid: 0x232d3a, rings: 0x46566b, axes: [0xff7b6e, 0x7ed98a, 0x6fb1ff], ruler: 0xffffff, halo: "#0e1218", text: "#dbe4ef" },
    light: { ground: 0xeef1f5, grid: 0xd3dae3, rings: 0x9aa8b9, axes: [0xc6281c, 0x1c7a33, 0x1f5fbf], ruler: 0x15202e, halo: "#eef1f5", text: "#24303f" },
};

// paint(colours): the canvases' part, called at once too.
export function makeTheme(settings, paint) {
    const { values } = settings;

    function show() {
        const name = values.theme === "system" ? (LIGHT.matches ? "light" : "dark") : values.theme;
        document.documentElement.dataset.theme = name;
        paint(THEMES[name]);
    }

    LIGHT.addEventListener("change", show);
    settings.onChange((changed) => changed.has("theme") && show());
    show();
}

// A colour of style.css, by its name there.
export const cssColour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
